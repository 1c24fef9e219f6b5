// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Alternating timing of a subject and its reference in one run, so that noise of the machine
// affects both alike. The benchmark's time is the subject's; counters give the medians and their
// ratio. A slow reference doesn't run in every turn, only until its time share is spent.

#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cores.h"

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

/// Times of the turns, and their statistics per item.
class Turns {
  public:
    /// @param reference  its name, for the heading of the table
    /// @param threads  of the subject: their available cores are counted beside each turn, except
    ///                 for turns so short that counting would disturb them
    Turns(benchmark::State& state, const std::string& reference, int threads = 1) : m_state(state) {
        state.SetLabel("reference: " + reference);
        if (threads > 1) m_cores.emplace(threads);
    }

    void add_subject(double seconds) {
        m_subject_s.push_back(seconds);
        m_state.SetIterationTime(seconds);
        if (m_cores && seconds > kShortTurn_s) m_cores_at_hand.push_back(m_cores->look());
    }
    void add_reference(double seconds) {
        m_reference_s.push_back(seconds);
        m_spent_s += seconds;
    }
    /// At least once; then until its share of the time is used up.
    bool wants_reference() const { return m_spent_s < kReferenceShare_s; }

    /// @param items  number of items in one turn of the subject
    /// @param reference_items  the reference's number, if it differs
    void count(double items, double reference_items = 0) const {
        const double a = median(m_subject_s) / items;
        const double b = median(m_reference_s) / (reference_items > 0 ? reference_items : items);
        m_state.counters["items"] = items;
        m_state.counters["ns/item"] = a * 1e9;
        m_state.counters["reference_ns/item"] = b * 1e9;
        m_state.counters["times_faster"] = b / a;
        m_state.counters["reference_turns"] = double(m_reference_s.size());
        if (reference_items > 0) m_state.counters["reference_items"] = reference_items;
        if (2 * m_cores_at_hand.size() > m_subject_s.size())
            m_state.counters["cores"] = median(m_cores_at_hand);
    }

  private:
    static constexpr double kReferenceShare_s = 1.5;
    static constexpr double kShortTurn_s = 0.5e-3;

    benchmark::State& m_state;
    std::optional<Cores> m_cores;
    std::vector<double> m_subject_s, m_reference_s, m_cores_at_hand;
    double m_spent_s = 0;
};

/// @param prepare  untimed, before each timed run. @param threads  of the subject
template <class Prepare, class Subject, class Reference>
Turns run_interleaved(benchmark::State& state, const std::string& name, Prepare&& prepare,
                      Subject&& subject, Reference&& reference, int threads = 1) {
    Turns turns(state, name, threads);
    for (auto _ : state) {
        if (turns.wants_reference()) {
            prepare();
            turns.add_reference(seconds_of(reference));
        }
        prepare();
        turns.add_subject(seconds_of(subject));
    }
    return turns;
}

}  // namespace pliant::bench
