# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# LZ4. BSD-2-Clause (the library; its tools are GPL and not used). Packs the history's steps and the
# files of a lattice's state, and unpacks blocks of VTK's images. It comes without a CMake package
# on Debian and Ubuntu.
find_path(PLIANT_LZ4_INCLUDE_DIR lz4.h)
find_library(PLIANT_LZ4_LIBRARY lz4)
mark_as_advanced(PLIANT_LZ4_INCLUDE_DIR PLIANT_LZ4_LIBRARY)
set(PLIANT_RECIPE_FOUND OFF)
if(PLIANT_LZ4_INCLUDE_DIR AND PLIANT_LZ4_LIBRARY)
    set(PLIANT_RECIPE_FOUND ON)
elseif(PLIANT_FIND STREQUAL "REQUIRED")
    message(FATAL_ERROR "LZ4: expected lz4.h and the library lz4 (liblz4-dev), found none")
endif()
if(PLIANT_RECIPE_FOUND AND NOT TARGET pliant_lz4)
    add_library(pliant_lz4 UNKNOWN IMPORTED)
    set_target_properties(pliant_lz4 PROPERTIES
        IMPORTED_LOCATION "${PLIANT_LZ4_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${PLIANT_LZ4_INCLUDE_DIR}")
endif()
