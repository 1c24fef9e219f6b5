// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gibson's lists, one for each direction [Gibson1997, 3.3.1], in three dimensions or, in a lattice
// of one layer, two.
//
// A candidate is compared with its sponsor alone. To examine each element once, one moved from the
// front or back list passes the motion on in five directions, from right or left in three, from top
// or bottom in one: first lines of elements, then planes from these, then the rest. In a non-convex
// object a line can be missing. If the neighbour across lacks the neighbour that would have
// sponsored it, it is added to the list too, and lists are processed again.
//
// The report describes the plane; the order of the six lists is that of the program which its
// author's laboratory published. With limits that vary the theorem behind the lists [Gibson1997,
// 3.3.2] does not hold; such runs are allowed, for demonstration.

#include "chains/lattice_ordering.h"

namespace pliant {
namespace {

class GibsonLists final : public LatticeOrdering {
  public:
    explicit GibsonLists(const ChainLattice& lattice)
        : LatticeOrdering(lattice, Regions::MeanOfEnds) {}

  private:
    struct List {
        std::vector<std::int32_t> candidates;
        std::size_t next = 0;
        bool is_empty() const { return next == candidates.size(); }
    };

    void put(std::int32_t sponsor, int direction) {
        if (has_neighbour(sponsor, direction))
            m_lists[std::size_t(direction)].candidates.push_back(neighbour(sponsor, direction));
    }
    void put_neighbours(std::int32_t moved, int direction);
    bool run_list(int direction);
    bool propagate(std::span<const std::int32_t> initial) override;

    std::array<List, kWays> m_lists;
};

void GibsonLists::put_neighbours(std::int32_t moved, int direction) {
    put(moved, direction);
    for (int d = 2 * axis_of(direction) + 2; d < kWays; ++d) put(moved, d);
    // Non-convex: no other element reaches the neighbour across.
    for (int d = 0; d < 2 * axis_of(direction); ++d)
        if (has_neighbour(moved, d) && !has_neighbour(neighbour(moved, d), opposite(direction)))
            put(moved, d);
}

bool GibsonLists::run_list(int direction) {
    List& list = m_lists[std::size_t(direction)];
    while (!list.is_empty()) {
        if (!count_candidate()) return false;
        const std::int32_t candidate = list.candidates[list.next++];
        if (is_initial(candidate)) continue;  // stays at the tool's position
        const std::int32_t sponsor = neighbour(candidate, opposite(direction));
        const Region allowed = region(sponsor, candidate, direction);
        const Vec3d to = clamped(u(candidate), u(sponsor), allowed.low, allowed.high);
        if (to == u(candidate)) continue;
        if (!move(candidate, to)) return false;
        put_neighbours(candidate, direction);
    }
    list = {};
    return true;
}

bool GibsonLists::propagate(std::span<const std::int32_t> initial) {
    m_lists = {};
    for (const std::int32_t e : initial)
        for (int d = 0; d < kWays; ++d) put(e, d);
    const auto any = [&] {
        for (const List& list : m_lists)
            if (!list.is_empty()) return true;
        return false;
    };
    while (any())
        for (int d = 0; d < kWays; ++d)
            if (!run_list(d)) return false;
    return true;
}

}  // namespace

std::unique_ptr<OrderingSolver> make_gibson_lists(const ChainLattice& lattice) {
    return std::make_unique<GibsonLists>(lattice);
}

}  // namespace pliant
