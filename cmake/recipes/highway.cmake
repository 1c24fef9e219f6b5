# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Highway. Apache-2.0. One source of a kernel, compiled for each vector instruction set; the program
# chooses at run time.
find_package(hwy 1.0 ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${hwy_FOUND})
