// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Times of single runs, and their statistics.

#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <vector>

namespace pliant::results {

template <class Work>
double milliseconds_of(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

/// Processor time of all threads together; independent of other load on the machine.
template <class Work>
double processor_ms_of(Work&& work) {
    const std::clock_t start = std::clock();
    work();
    return 1000.0 * double(std::clock() - start) / CLOCKS_PER_SEC;
}

/// The smallest value that is not exceeded by the given share of all. @param share  0…1
inline double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto last = double(values.size() - 1);
    const auto at = values.begin() + std::ptrdiff_t(share * last + 0.5);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace pliant::results
