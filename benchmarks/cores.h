// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Measures the number of cores that a benchmark's threads really have. Two processors of a virtual
// machine may share one core, or the system schedules two threads on one core: the same program
// then takes 1.5 to 2 times as long, without any other sign.

#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <barrier>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace pliant::bench {

/// Multiplications that saturate the multiplier of a core without memory accesses.
/// @returns seconds
inline double multiply_for_a_while() {
    constexpr int kTurns = 20'000;
    constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15;
    std::uint64_t a = 1, b = 3, c = 5, d = 7, e = 11, f = 13;
    const auto start = std::chrono::steady_clock::now();
    for (int n = 0; n < kTurns; ++n) {
        a *= kFactor, b *= kFactor, c *= kFactor;
        d *= kFactor, e *= kFactor, f *= kFactor;
        benchmark::DoNotOptimize(a);
    }
    benchmark::DoNotOptimize(b ^ c ^ d ^ e ^ f);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Number of available cores for so many threads: `threads` if each has a separate core.
class Cores {
  public:
    explicit Cores(int threads) : m_seconds(std::size_t(threads)) {}

    double look() {
        for (int n = 0; n < 2; ++n) m_alone = std::min(m_alone, multiply_for_a_while());
        std::barrier together(std::ptrdiff_t(m_seconds.size()));
        const auto run = [&](double& seconds) {
            together.arrive_and_wait();
            seconds = multiply_for_a_while();
        };
        std::vector<std::thread> others;
        for (std::size_t n = 1; n < m_seconds.size(); ++n)
            others.emplace_back(run, std::ref(m_seconds[n]));
        run(m_seconds[0]);
        for (std::thread& other : others) other.join();
        return double(m_seconds.size()) * m_alone /
               *std::max_element(m_seconds.begin(), m_seconds.end());
    }

  private:
    std::vector<double> m_seconds;
    double m_alone = 1;
};

}  // namespace pliant::bench
