// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A subject and its reference, timed turn by turn in one run, so that a noisy machine disturbs both
// alike. The benchmark's own time is the subject's; counters give the medians and their ratio.

#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace pliant::bench {

inline double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

template <class Work>
double seconds_of(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// @param items  what one turn works on, for the counters in ns per item
/// @param prepare  untimed, before each timed piece of work
template <class Prepare, class Subject, class Reference>
void run_interleaved(benchmark::State& state, double items, Prepare&& prepare, Subject&& subject,
                     Reference&& reference) {
    std::vector<double> subject_s, reference_s;
    for (auto _ : state) {
        prepare();
        reference_s.push_back(seconds_of(reference));
        prepare();
        subject_s.push_back(seconds_of(subject));
        state.SetIterationTime(subject_s.back());
    }
    const double a = median(subject_s), b = median(reference_s);
    state.counters["items"] = items;
    state.counters["ns/item"] = a / items * 1e9;
    state.counters["reference_ns/item"] = b / items * 1e9;
    state.counters["times_faster"] = b / a;
}

}  // namespace pliant::bench
