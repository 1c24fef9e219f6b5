# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Google Benchmark. Apache-2.0. Benchmarks only.
find_package(benchmark REQUIRED)
