# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# GoogleTest. BSD-3-Clause. Tests only.
find_package(GTest REQUIRED)
