# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# GDCM, Grassroots DICOM. BSD-3-Clause.
# Decodes compressed pixels, in pliant-decode-pixels alone: the library doesn't link it.
#
# Its package lists command line tools, which Debian puts in a package of their own that nothing
# here needs, and CMake reports each of them at length; hence the quiet search.
set(PLIANT_LOG_LEVEL "${CMAKE_MESSAGE_LOG_LEVEL}")
set(CMAKE_MESSAGE_LOG_LEVEL NOTICE)
find_package(GDCM 3.0 REQUIRED)
set(CMAKE_MESSAGE_LOG_LEVEL "${PLIANT_LOG_LEVEL}")
