// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Excuses of links. After a change of materials, links can be outside of their new limits. They
// stay as they are, and may only come back: the solvers ensure that (see
// Lattice::may_exceed_limits). This is the record with which the check compares them: the
// components of links that were outside, and their differences at the change. It is taken at the
// change, shrinks after each step as links come back, and is empty once all are within their
// limits.

#pragma once

#include <pliant/core/tasks.h>

#include <cstdint>
#include <vector>

#include "lattice/lattice.h"

namespace pliant {

class Allowance {
  public:
    /// Takes a new record of the present state, and tells the lattice whether it is empty. Has no
    /// effect if it throws.
    void excuse_present(Lattice& lattice, const TaskArena& arena);
    /// Removes links that came back, and tightens the rest. Doesn't allocate.
    /// @pre the lattice's materials are those of excuse_present
    void shrink(Lattice& lattice, const TaskArena& arena);

    /// Restores a record that was taken before changes of the lattice that have been undone.
    void restore(Lattice& lattice, Allowance former) noexcept;

    /// Number of components outside of their limits.
    std::int64_t size() const;
    /// Largest permitted difference of the ends [units], for component a of the link from element
    /// `index` of a brick along axis b; 0 if the link is not excused.
    Fixed excused(Vec3i brick_coord, int index, int b, int a) const;

  private:
    struct Entry {
        std::uint32_t code;  ///< 9·index + 3·b + a
        Fixed difference;    ///< of component a, upper end minus lower end
    };
    struct Block {
        Vec3i coord;
        std::vector<Entry> entries;  ///< sorted by code
    };
    static void find_exceeding(const Lattice& lattice, Block& block);
    static void shrink_block(const Lattice& lattice, Block& block);

    std::vector<Block> m_blocks;  ///< sorted by coordinate, z first
    std::uint64_t m_seen = 0;     ///< the lattice's clock at the last update
};

}  // namespace pliant
