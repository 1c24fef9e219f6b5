# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# libpng. libpng licence (permissive). Writes pictures.
find_package(PNG REQUIRED)
