# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# libpng. libpng licence (permissive). Writes pictures.
find_package(PNG ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${PNG_FOUND})
