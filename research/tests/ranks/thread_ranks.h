// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Ranks as threads of one process.

#pragma once

#include <pliant/research/ranks.h>

#include <algorithm>
#include <barrier>
#include <memory>
#include <thread>
#include <vector>

namespace pliant::test {

class ThreadRanks {
  public:
    explicit ThreadRanks(int count)
        : m_barrier(count), m_below(slots(count)), m_above(slots(count)) {
        for (int r = 0; r < count; ++r) m_ranks.push_back(std::make_unique<One>(*this, r));
    }

    /// Calls body(ranks) on each rank's thread.
    template <class Body>
    void run(const Body& body) {
        std::vector<std::thread> threads;
        for (const auto& rank : m_ranks) threads.emplace_back([&] { body(*rank); });
        for (std::thread& thread : threads) thread.join();
    }

  private:
    using Slots = std::vector<std::span<const double>>;
    static Slots slots(int count) { return Slots(std::size_t(count)); }

    class One : public Ranks {
      public:
        One(ThreadRanks& all, int rank) : m_all(all), m_rank(std::size_t(rank)) {}
        int rank() const override { return int(m_rank); }
        int count() const override { return int(m_all.m_ranks.size()); }
        void exchange(std::span<const double> to_below, std::span<const double> to_above,
                      std::span<double> from_below, std::span<double> from_above) override {
            m_all.m_below[m_rank] = to_below;
            m_all.m_above[m_rank] = to_above;
            m_all.m_barrier.arrive_and_wait();
            if (m_rank > 0) copy(m_all.m_above[m_rank - 1], from_below);
            if (m_rank + 1 < m_all.m_ranks.size()) copy(m_all.m_below[m_rank + 1], from_above);
            m_all.m_barrier.arrive_and_wait();
        }
        void gather(std::span<const double> mine, std::span<const std::size_t> counts,
                    std::span<double> all) override {
            m_all.m_below[m_rank] = mine;
            m_all.m_barrier.arrive_and_wait();
            std::size_t at = 0;
            for (std::size_t r = 0; r < counts.size(); at += counts[r], ++r)
                copy(m_all.m_below[r], all.subspan(at, counts[r]));
            m_all.m_barrier.arrive_and_wait();
        }

      private:
        static void copy(std::span<const double> from, std::span<double> to) {
            if (from.size() != to.size()) std::abort();  // sizes of both sides must agree
            std::copy(from.begin(), from.end(), to.begin());
        }

        ThreadRanks& m_all;
        std::size_t m_rank;
    };

    std::barrier<> m_barrier;
    Slots m_below, m_above;
    std::vector<std::unique_ptr<One>> m_ranks;
};

}  // namespace pliant::test
