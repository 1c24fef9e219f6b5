// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What links are excused for. When materials change, links may find themselves outside of their new
// limits. They stay as they are, and from then on may only come back: the solvers see to that (see
// Lattice::may_exceed_limits). This is the record that the check compares them with: which
// component of which link was outside, and what it was. It is taken at the change, shrinks after
// each step as links come back, and is empty once all are within their limits.

#pragma once

#include <pliant/tasks.h>

#include <cstdint>
#include <vector>

#include "chainmail/lattice.h"

namespace pliant {

class Allowance {
  public:
    /// Takes the record of the present state anew, and tells the lattice whether there is any.
    /// Where it throws nothing has changed.
    void excuse_present(Lattice& lattice, const TaskArena& arena);
    /// Follows links that came back. Allocates nothing.
    /// @pre the lattice's materials are those of excuse_present
    void shrink(Lattice& lattice, const TaskArena& arena);

    /// Puts back a record that was taken before the lattice's last changes, which were taken back.
    void restore(Lattice& lattice, Allowance former) noexcept;

    /// Components of links outside of their limits.
    std::int64_t size() const;
    /// What component a of the link from element `index` of a brick along axis b may be: the
    /// difference of its ends [units]; 0: not excused.
    Fixed excused(Vec3i brick_coord, int index, int b, int a) const;

  private:
    struct Entry {
        std::uint32_t code;  ///< 9·index + 3·b + a
        Fixed difference;    ///< of component a, upper end minus lower end
    };
    struct Block {
        Vec3i coord;
        std::vector<Entry> entries;  ///< by code
    };
    static void find_exceeding(const Lattice& lattice, Block& block);
    static void shrink_block(const Lattice& lattice, Block& block);

    std::vector<Block> m_blocks;  ///< by coordinate, z first
    std::uint64_t m_seen = 0;     ///< the lattice's clock at the last look
};

}  // namespace pliant
