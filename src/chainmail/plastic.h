// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The imprint: what a push beyond the yield limit leaves behind.
//
// An element returns to its rest place plus its imprint p. The elastic part of its displacement is
// e = u − p, and a link yields where the elastic difference of its ends is beyond the yield limit,
// a fraction of the link's own. Then p flows: u stays, and e goes to the state e' nearest to zero
// among those between the two envelopes of e,
//
//   low(i)  = min over j of e(j) + d(j, i)       largest state within yield that is not above e
//   high(i) = max over j of e(j) − d(i, j)       smallest one that is not below
//   e'(i)   = the number in low(i)…high(i) that is nearest to zero
//
// where d are shortest distances with the yield limits as lengths. Differences within limits are
// kept by minimum and maximum, and low, high and zero have them, so e' has them too; it lies
// between 0 and e. For a push from one side that is the least flow of every element at once. It is
// unique, so no order of updates and no number of threads changes it.
//
// Where that would stretch the imprint itself beyond the links' limits, yield limits are larger:
// the imprint is a valid state, and can be returned to.

#pragma once

#include <pliant/tasks.h>

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "chainmail/lattice.h"
#include "chainmail/relax_links.h"

namespace pliant {

/// The imprint of one brick's elements, by component.
struct PlasticBrick {
    std::array<std::vector<Fixed>, 3> imprint;
    std::uint64_t changed_at = 0;  ///< Lattice::clock() then
};

/// All imprints; only bricks that yielded are there.
class PlasticRest {
  public:
    bool empty() const { return m_bricks.empty(); }
    const PlasticBrick* find(Vec3i brick_coord) const;
    Vec3<Fixed> imprint_at(const Lattice& lattice, Vec3i ijk) const;
    const auto& bricks() const { return m_bricks; }
    /// Replaces a brick's imprint; all zero takes it away.
    void set(const Lattice& lattice, Vec3i brick_coord, std::array<std::vector<Fixed>, 3> imprint);
    /// Counts changes.
    std::uint64_t version() const { return m_version; }
    std::size_t bytes() const;
    void clear();
    /// Takes the imprints of void elements away. @param coords  of bricks to look at
    void forget_void(const Lattice& lattice, std::span<const Vec3i> coords);

    /// A brick's imprint at some time; empty arrays: none.
    struct Former {
        Vec3i coord;
        std::array<std::vector<Fixed>, 3> imprint;
    };
    /// Bricks that have changed since the last call, as they were then, in no particular order.
    std::vector<Former> take_changes();
    /// Exchanges imprints with those of bricks that differ. Counts as no change of the above.
    void exchange(const Lattice& lattice, std::vector<Former>& formers);

  private:
    using Imprint = std::array<std::vector<Fixed>, 3>;
    /// @returns what was there
    Imprint replace(const Lattice& lattice, Vec3i brick_coord, Imprint imprint);

    std::unordered_map<Vec3i, PlasticBrick, CoordHash> m_bricks;
    std::unordered_map<Vec3i, Imprint, CoordHash> m_formers;  ///< since the last take_changes
    std::uint64_t m_version = 0;
};

/// Lets links that are beyond their yield limits flow, after a push. Nothing moves.
void flow(const Lattice& lattice, PlasticRest& rest, const TaskArena& arena);

/// What the imprints of a brick and of those beside it add to the forces on its elements:
/// Σ weight_j · (p − p_j), by component; exact. Empty: no imprint near.
struct PlasticPull {
    std::uint64_t version = 0;  ///< of the PlasticRest
    std::array<std::vector<double>, 3> force;
};
PlasticPull pull_of(const Lattice& lattice, const Brick& brick, const BrickLinks& links,
                    const PlasticRest& rest);

}  // namespace pliant
