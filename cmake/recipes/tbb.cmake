# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# oneTBB. Apache-2.0. Schedules data-parallel loops.
find_package(TBB ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${TBB_FOUND})
