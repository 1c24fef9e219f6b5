# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Up to version 5.2, ITK's headers know only the compiler that ITK itself was built with, which in
# Debian is GCC: with Clang they stop at "Unsupported compiler". The header beside this file is read
# before them and lets them look at Clang as at a GCC of the same abilities.

if(CMAKE_CXX_COMPILER_ID MATCHES Clang AND ITK_VERSION VERSION_LESS 5.3)
    target_compile_options(ITKCommon INTERFACE
        "SHELL:-include ${CMAKE_CURRENT_LIST_DIR}/itk_with_clang.h")
endif()
