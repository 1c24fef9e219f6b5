// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Slabs of a lattice: each rank owns some planes of nodes, and keeps copies of one plane on either
// side, which are exchanged when they have become stale.
//
//   rank 0   0 1 2 3 (4)
//   rank 1       (3) 4 5 6 (7)
//   rank 2             (6) 7 8 9
//
// Every node's sums are taken on the rank that owns it, in the same order as on one rank, and
// partial dot products are the same pieces in the same order. So results are bit-identical for any
// number of ranks.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/research/ranks.h>

#include <memory>
#include <vector>

#include "fem/held_nodes.h"
#include "fem/lattice_stiffness.h"
#include "fem/multigrid_transfer.h"

namespace pliant {

class Slabs {
  public:
    /// Splits the planes evenly; the whole lattice if the slabs would be thin.
    /// @param ranks  null: one
    Slabs(const HexLattice& whole, Ranks* ranks);
    /// Slabs of a coarse lattice; a plane belongs to the owner of the fine plane at its position.
    Slabs coarse(const HexLattice& coarse, Vec3i factor) const;

    bool is_whole() const { return m_ranks == nullptr; }
    /// Whether the slabs are worth a level of their own.
    bool are_thick() const;
    const HexLattice& whole() const { return m_whole; }
    HexLattice local() const;                       ///< owned planes and copies
    int low() const;                                ///< first plane of local()
    int first() const { return first_of(rank()); }  ///< owned planes
    int end() const { return first_of(rank() + 1); }
    /// @param rank  0…count: its first plane, or the end
    int first_of(int rank) const { return m_first[std::size_t(rank)]; }
    Ranks* ranks() const { return m_ranks; }

    /// The local part of the lattice's cells and nodes.
    std::vector<double> local_cells(const std::vector<double>& whole) const;
    HeldNodes local_held(const HeldNodes& whole) const;
    NodeVector local_nodes(const NodeVector& whole) const;

    /// Updates the copies of planes.
    void exchange(NodeVector& v) const;
    /// Collects the owned planes of all ranks on all ranks.
    NodeVector gather(const NodeVector& local) const;

    std::size_t plane() const { return std::size_t(m_whole.size.x) * std::size_t(m_whole.size.y); }

  private:
    Slabs(const HexLattice& whole, Ranks* ranks, std::vector<int> first);
    int rank() const { return m_ranks ? m_ranks->rank() : 0; }

    HexLattice m_whole;
    Ranks* m_ranks;
    std::vector<int> m_first;  ///< [rank] first owned plane; then the end
    mutable std::vector<double> m_buffers[4];
};

}  // namespace pliant
