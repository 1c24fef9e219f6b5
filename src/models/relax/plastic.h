// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The imprint: permanent deformation by a push beyond the yield limit.
//
// An element returns to its rest position plus its imprint p. The elastic part of its displacement
// is e = u − p, and a link yields where the elastic difference of its ends exceeds the yield limit,
// a fraction of the link's own limit. Then p flows: u stays, and e goes to the state e' nearest to
// zero between the two envelopes of e,
//
//   low(i)  = min over j of e(j) + d(j, i)       largest state within yield that is not above e
//   high(i) = max over j of e(j) − d(i, j)       smallest one that is not below
//   e'(i)   = the number in low(i)…high(i) that is nearest to zero
//
// where d are shortest distances with the yield limits as lengths. Minimum and maximum preserve
// differences within limits, and low, high and zero satisfy them, so e' does too; it lies between 0
// and e. For a push from one side that is the least flow of every element at once. It is unique, so
// it doesn't depend on the order of updates or the number of threads.
//
// Yield limits are enlarged where the flow would stretch the imprint itself beyond the links'
// limits: the imprint is a valid state, to which elements can return.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "lattice/lattice.h"
#include "relax/relax_links.h"

namespace pliant {

/// Imprint by component; empty arrays: none.
using Imprint = std::array<std::vector<Fixed>, 3>;

/// The imprint of one brick's elements.
struct PlasticBrick {
    Imprint imprint;
    std::uint64_t changed_at = 0;  ///< Lattice::clock() at the last change
};

/// Imprints by brick coordinate.
using ImprintMap = std::unordered_map<Vec3i, PlasticBrick, CoordHash>;

/// All imprints; only bricks that yielded are in it.
class PlasticRest {
  public:
    bool empty() const { return m_bricks.empty(); }
    const PlasticBrick* find(Vec3i brick_coord) const;
    Vec3<Fixed> imprint_at(const Lattice& lattice, Vec3i ijk) const;
    const auto& bricks() const { return m_bricks; }
    /// Replaces a brick's imprint; an all-zero one removes it. For states without undo.
    void set(const Lattice& lattice, Vec3i brick_coord, Imprint imprint);
    /// Exchange of the imprints of several bricks in three calls, of which only the first can fail;
    /// it has no effect then. A second call of exchange reverts the first.
    void prepare(const Lattice& lattice, const ImprintMap& imprints);
    void exchange(const Lattice& lattice, ImprintMap& imprints) noexcept;
    void finish(const ImprintMap& imprints) noexcept;
    /// Restores imprints that were replaced since they were saved. Leaves `saved` unspecified.
    void restore(const Lattice& lattice, ImprintMap& saved) noexcept;
    /// Number of changes.
    std::uint64_t version() const { return m_version; }
    std::size_t bytes() const;
    /// Removes all imprints. The lattice's observer is not told.
    void clear() noexcept;

  private:
    ImprintMap m_bricks;  ///< none is empty except during an exchange
    std::uint64_t m_version = 0;
};

/// Whether any material yields.
bool any_yields(const MaterialTable& materials);
/// Lets links beyond their yield limits flow, after a push. Nothing moves. Has no effect if it
/// throws.
void flow(const Lattice& lattice, PlasticRest& rest, const TaskArena& arena);

/// Contribution of the imprints of a brick and its neighbours to the forces on its elements: Σ
/// weight_j · (p − p_j), by component; exact. Empty: no imprint near.
struct PlasticPull {
    std::uint64_t version = 0;  ///< version of the PlasticRest
    std::array<std::vector<double>, 3> force;
};
PlasticPull pull_of(const Lattice& lattice, const Brick& brick, const BrickLinks& links,
                    const PlasticRest& rest);

}  // namespace pliant
