// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fem/conjugate_gradients.h"
#include "ranks/slabs.h"

namespace pliant {

/// Sums over vectors of which each rank has a slab: same pieces, same order, so the same bits.
class SlabSums : public Sums {
  public:
    /// @pre !slabs.is_whole()
    SlabSums(const Slabs& slabs, const TaskArena& arena);
    double dot(const NodeVector& a, const NodeVector& b) const override;
    double advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                   NodeVector& r) const override;

  private:
    const Slabs& m_slabs;
    const TaskArena& m_arena;
    std::vector<std::size_t> m_counts;  ///< pieces of each rank: those that begin in its planes
    std::int64_t m_begin, m_end;        ///< the slab's nodes in the whole lattice
    std::int64_t m_borrowed;            ///< nodes above the slab in its last piece
    std::int64_t m_lent;                ///< nodes of the slab in the last piece of the rank below
    mutable std::vector<double> m_sums, m_all, m_lending, m_tail;
};

}  // namespace pliant
