// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The thesis's deformation [Draeger2005, 3.5.3 and 3.6.2]: Schill's sorted list, started by several
// elements at once, with Gibson's spreading rule.
//
// Elements that start together would pass the same neighbours to each other again and again. So
// each ignores the directions in which another initial element lies, and passes these flags on to
// the elements that it sponsors. The object is thereby cut between the initial elements, and the
// parts move independently. Along the cut, links may end outside of their limits; the thesis says
// so itself, and lists a better strategy as further work.
//
// A candidate is checked against the chain region of its sponsor.

#include <algorithm>

#include "chains/lattice_ordering.h"

namespace pliant {
namespace {

class DraegerMultiMove final : public LatticeOrdering {
  public:
    DraegerMultiMove(const ChainLattice& lattice, bool mean_of_ends)
        : LatticeOrdering(lattice, mean_of_ends ? Regions::MeanOfEnds : Regions::OfSponsor),
          m_ignored(voxel_count({.size = lattice.size}), 0) {}

  private:
    struct Candidate {
        double violation;
        std::int32_t element;
        std::int32_t direction;  ///< from the sponsor
        friend bool operator<(const Candidate& a, const Candidate& b) {
            return a.violation < b.violation;
        }
    };

    void put(std::int32_t sponsor, int direction);
    bool propagate(std::span<const std::int32_t> initial) override;

    std::vector<std::uint8_t> m_ignored;  ///< [element]: a bit for each direction
    std::vector<Candidate> m_heap;
};

void DraegerMultiMove::put(std::int32_t sponsor, int direction) {
    if (m_ignored[std::size_t(sponsor)] >> direction & 1) return;
    if (!has_neighbour(sponsor, direction)) return;
    const std::int32_t candidate = neighbour(sponsor, direction);
    const Region allowed = region(sponsor, candidate, direction);
    const double amount = violation(u(candidate), u(sponsor), allowed.low, allowed.high);
    if (amount <= 0) return;
    m_heap.push_back({amount, candidate, direction});
    std::push_heap(m_heap.begin(), m_heap.end());
}

bool DraegerMultiMove::propagate(std::span<const std::int32_t> initial) {
    m_heap.clear();
    for (const std::int32_t e : initial) {
        unsigned ignored = 0;
        for (int d = 0; d < kWays; ++d)
            if (has_neighbour(e, d) && is_initial(neighbour(e, d))) ignored |= 1u << d;
        m_ignored[std::size_t(e)] = std::uint8_t(ignored);
    }
    for (const std::int32_t e : initial)
        for (int d = 0; d < kWays; ++d) put(e, d);
    while (!m_heap.empty()) {
        if (!count_candidate()) return false;
        std::pop_heap(m_heap.begin(), m_heap.end());
        const auto [amount, candidate, direction] = m_heap.back();
        m_heap.pop_back();
        if (is_moved(candidate)) continue;
        const std::int32_t sponsor = neighbour(candidate, opposite(direction));
        const Region allowed = region(sponsor, candidate, direction);
        const Vec3d to = clamped(u(candidate), u(sponsor), allowed.low, allowed.high);
        m_ignored[std::size_t(candidate)] = m_ignored[std::size_t(sponsor)];
        if (!move(candidate, to)) return false;
        put(candidate, direction);
        for (int d = 2 * axis_of(direction) + 2; d < kWays; ++d) put(candidate, d);
    }
    return true;
}

}  // namespace

std::unique_ptr<OrderingSolver> make_draeger(const ChainLattice& lattice, bool mean_of_ends) {
    return std::make_unique<DraegerMultiMove>(lattice, mean_of_ends);
}

}  // namespace pliant
