# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# toml++. MIT. Reads the settings file.
find_package(tomlplusplus REQUIRED)
