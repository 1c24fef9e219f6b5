# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# pugixml. MIT. Reads VTK's XML meshes.
find_package(pugixml 1.11 ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${pugixml_FOUND})
