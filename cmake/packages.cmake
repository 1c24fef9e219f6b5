# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Debian packages of `./dev package`: pliant, the program with its page and decoder, and
# libpliant-dev, the library to build with.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME pliant)
set(CPACK_PACKAGE_VENDOR "The Pliant authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The Pliant authors")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME pliant)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "Soft tissue of medical scans, pushed and seen
 Opens a CT, MR or other scan, pushes its soft tissue at full resolution, and shows and
 writes the deformed scan, on the command line and in a browser. Not for clinical use.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libpliant-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
# What the static libraries link, by cmake/recipes; the decoder is in the program's package.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "pliant (= ${PROJECT_VERSION}), libtbb-dev, libhwy-dev, liblz4-dev, libpng-dev")
string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", libpugixml-dev, zlib1g-dev, libssl-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "Soft-tissue engine for medical scans, library
 Static libraries, headers and a package for CMake's find_package(pliant).")
include(CPack)
