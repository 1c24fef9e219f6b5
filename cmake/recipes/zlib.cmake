# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# zlib. zlib licence (permissive). Reads and writes compressed scans.
find_package(ZLIB ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${ZLIB_FOUND})
