# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# toml++. MIT. Reads the settings file. Distributions have it as a library too; the one file that
# uses it takes the headers alone, so that users of the library don't need it.
find_package(tomlplusplus REQUIRED)
add_library(pliant_toml INTERFACE)
target_include_directories(pliant_toml SYSTEM INTERFACE
    $<TARGET_PROPERTY:tomlplusplus::tomlplusplus,INTERFACE_INCLUDE_DIRECTORIES>)
