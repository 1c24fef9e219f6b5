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

/// By component; empty arrays: none.
using Imprint = std::array<std::vector<Fixed>, 3>;

/// The imprint of one brick's elements.
struct PlasticBrick {
    Imprint imprint;
    std::uint64_t changed_at = 0;  ///< Lattice::clock() then
};

/// By brick coordinate.
using ImprintMap = std::unordered_map<Vec3i, PlasticBrick, CoordHash>;

/// All imprints; only bricks that yielded are there.
class PlasticRest {
  public:
    bool empty() const { return m_bricks.empty(); }
    const PlasticBrick* find(Vec3i brick_coord) const;
    Vec3<Fixed> imprint_at(const Lattice& lattice, Vec3i ijk) const;
    const auto& bricks() const { return m_bricks; }
    /// Replaces a brick's imprint; all zero takes it away. For a state that is never undone.
    void set(const Lattice& lattice, Vec3i brick_coord, Imprint imprint);
    /// Exchanges the imprints of several bricks in three calls, of which only the first can fail;
    /// then nothing has changed. The second one may be repeated to take the exchange back.
    void prepare(const Lattice& lattice, const ImprintMap& imprints);
    void exchange(const Lattice& lattice, ImprintMap& imprints) noexcept;
    void finish(const ImprintMap& imprints) noexcept;
    /// Puts back imprints that were replaced since they were saved. Leaves `saved` unspecified.
    void restore(const Lattice& lattice, ImprintMap& saved) noexcept;
    /// Counts changes.
    std::uint64_t version() const { return m_version; }
    std::size_t bytes() const;
    /// Takes all imprints away. The lattice's observer is not told.
    void clear() noexcept;

  private:
    ImprintMap m_bricks;  ///< none is empty but for the time of an exchange
    std::uint64_t m_version = 0;
};

/// Whether links of any material yield.
bool any_yields(const MaterialTable& materials);
/// Lets links that are beyond their yield limits flow, after a push. Nothing moves. Where it throws
/// nothing has changed.
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
