# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# ITK, the Insight Toolkit. Apache-2.0.
# Reads scans (NRRD, MetaImage, NIfTI).
#
# GDCM's package lists its command line tools, which Debian puts in a package of their own that
# nobody needs here, and CMake reports each of them at length; hence the quiet search.
set(PLIANT_LOG_LEVEL "${CMAKE_MESSAGE_LOG_LEVEL}")
set(CMAKE_MESSAGE_LOG_LEVEL NOTICE)
find_package(ITK 5.2 REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIONRRD ITKIOMeta ITKIONIFTI)
set(CMAKE_MESSAGE_LOG_LEVEL "${PLIANT_LOG_LEVEL}")
