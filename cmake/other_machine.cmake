# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Toolchain file of `./dev machines`: Debian's cross compiler for PLIANT_MACHINE (aarch64, riscv64,
# s390x), with the libraries of that machine's Debian in PLIANT_MACHINE_ROOT.

set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PLIANT_MACHINE PLIANT_MACHINE_ROOT)
set(triplet ${PLIANT_MACHINE}-linux-gnu)
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR ${PLIANT_MACHINE})
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
set(CMAKE_SYSROOT ${PLIANT_MACHINE_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind IN ITEMS LIBRARY INCLUDE PACKAGE)
    set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-${PLIANT_MACHINE}-static -L ${PLIANT_MACHINE_ROOT})

# The compiler's own libraries are those of this Debian. A newer one's come before them, and need
# a linker that knows their relocations.
set(flags -L${CMAKE_SYSROOT}/link -L${CMAKE_SYSROOT}/usr/lib/${triplet})
if(EXISTS ${CMAKE_SYSROOT}/link/ld.lld)
    list(PREPEND flags -B${CMAKE_SYSROOT}/link -fuse-ld=lld)
endif()
list(JOIN flags " " flags)
foreach(kind IN ITEMS EXE SHARED MODULE)
    set(CMAKE_${kind}_LINKER_FLAGS_INIT "${flags}")
endforeach()
