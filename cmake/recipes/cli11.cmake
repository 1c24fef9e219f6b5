# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# CLI11. BSD-3-Clause. The program's command line.
find_package(CLI11 REQUIRED)
