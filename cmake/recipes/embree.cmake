# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Embree. Apache-2.0. What the ray caster is measured against; benchmarks only, and they do without.
find_package(embree 3 QUIET)
