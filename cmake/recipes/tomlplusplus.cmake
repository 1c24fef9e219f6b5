# toml++. MIT. Reads the settings file.
find_package(tomlplusplus REQUIRED)
