# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# nlohmann-json. MIT. Reports and markups files.
find_package(nlohmann_json 3.10 REQUIRED)
