# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# zlib. zlib licence (permissive). Reads and writes compressed scans.
find_package(ZLIB REQUIRED)
