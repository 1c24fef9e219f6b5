// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The order in which sweeps visit bricks. Bricks whose neighbours rose wait in a list. Bricks with
// the largest pending raise go first, in a few coarse classes, because a brick that is visited too
// early has to be visited again. Bricks of one chessboard colour share no face and go in parallel.

#pragma once

#include <pliant/core/tasks.h>

#include <algorithm>
#include <functional>

#include "lattice/lattice.h"
#include "propagate/propagation.h"

namespace pliant {

/// Sizes of rounds, by the cost of a visit.
struct RoundSizes {
    /// A round takes all bricks whose pending raise is within this fraction of the largest raise.
    /// More buckets: fewer repeated visits, but shorter rounds.
    int buckets = 16;
    std::size_t few_bricks = 8;  ///< rounds with fewer bricks run on one thread
    std::int64_t bricks_per_task = 4;
};

class SweepRounds {
  public:
    using Wakes = SweepWork::Wakes;
    using Node = SweepWork::Node;

    SweepRounds(Lattice& lattice, SweepWork& work, RoundSizes sizes = {})
        : m_lattice(lattice), m_work(work), m_sizes(sizes) {
        work.touched.clear();
        work.active.clear();
        work.cancelled = 0;
    }

    /// Puts a brick into the list. @param raise  > 0
    Node& wake(int index, Fixed raise) {
        Node& node = m_work.touch(index, m_lattice.brick_index_bound());
        if (node.pending == 0) m_work.active.push_back(index);
        node.pending = std::max(node.pending, raise);
        return node;
    }

    /// Visits bricks until the list is empty. @param amount  the largest raise of all
    /// @param visit  (brick index, wakes): reads neighbours, writes only the brick; on any thread
    /// @param after_round  (refused): on this thread; whether a brick was refused
    /// @returns false if more than max_bricks would be needed
    template <class Visit, class AfterRound>
    bool run(Fixed amount, const TaskArena& arena, int max_bricks, const Visit& visit,
             const AfterRound& after_round) {
        bool fits = true;
        while (fits && !m_work.active.empty()) {
            take_next_bucket(amount);
            for (const std::vector<int>& round : m_work.round) {
                visit_all(round, arena, visit);
                bool refused = false;
                for (std::size_t n = 0; n < round.size(); ++n) {
                    wake_neighbours(round[n], m_work.wakes[n], amount);
                    refused |= m_work.wakes[n].refused;
                    m_work.cancelled = std::max(m_work.cancelled, m_work.wakes[n].cancelled);
                }
                after_round(refused);
            }
            fits = m_lattice.resident_brick_count() <= max_bricks;
        }
        for (const int index : m_work.touched) m_work.nodes[std::size_t(index)] = {};
        return fits;
    }

  private:
    /// Moves the most urgent bricks from the active list to this round's two colours.
    void take_next_bucket(Fixed amount) {
        const auto node_of = [&](int index) -> Node& { return m_work.nodes[std::size_t(index)]; };
        Fixed largest = 0;
        for (const int index : m_work.active) largest = std::max(largest, node_of(index).pending);
        const Fixed threshold = largest - amount / m_sizes.buckets;
        for (auto& round : m_work.round) round.clear();
        std::erase_if(m_work.active, [&](int index) {
            Node& node = node_of(index);
            if (node.pending < threshold) return false;
            node.pending = 0;
            // Nothing new since its visit in the round in which it was woken.
            if (!node.has_news()) return true;
            const Vec3i c = m_lattice.brick(index).coord;
            m_work.round[std::size_t((c.x + c.y + c.z) & 1)].push_back(index);
            return true;
        });
    }

    template <class Visit>
    void visit_all(const std::vector<int>& round, const TaskArena& arena, const Visit& visit) {
        m_work.wakes.resize(std::max(m_work.wakes.size(), round.size()));
        const auto visit_some = [&](std::int64_t begin, std::int64_t end) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
                if (n + 1 < std::size_t(end)) m_lattice.fetch_early(m_lattice.brick(round[n + 1]));
                m_work.wakes[n] = {};
                visit(round[n], m_work.wakes[n]);
            }
        };
        if (round.size() < m_sizes.few_bricks)
            visit_some(0, std::int64_t(round.size()));
        else
            arena.for_each(std::int64_t(round.size()), m_sizes.bricks_per_task,
                           std::ref(visit_some));
    }

    void wake_neighbours(int index, const Wakes& wakes, Fixed amount) {
        // A refused brick goes back into the list; its news are still set.
        if (wakes.refused) {
            wake(index, amount);
            return;
        }
        for (std::size_t side = 0; side < 6; ++side) {
            if (wakes.raise[side] == 0) continue;
            const Brick& brick = m_lattice.brick(index);
            int neighbour = brick.neighbours[side];
            if (neighbour < 0)
                neighbour = m_lattice.ensure_blank_brick(coord_behind(brick, int(side)));
            wake(neighbour, wakes.raise[side]).news[side ^ 1] |= wakes.fields[side];
        }
    }

    Lattice& m_lattice;
    SweepWork& m_work;
    RoundSizes m_sizes;
};

}  // namespace pliant
