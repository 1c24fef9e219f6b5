# zlib. zlib licence (permissive). Reads the headers of compressed NIfTI files.
find_package(ZLIB REQUIRED)
