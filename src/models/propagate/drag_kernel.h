// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of a drag, for its frames and for the reading of a pick's fields, in two
// versions: plain, and with vector instructions. Both give the same bits.
//
// A frame is limited by memory bandwidth, so it avoids memory accesses. A brick is divided into
// lines of 16 elements, 64 bytes of each array. A line whose fields ask for no position above the
// brick's lowest one is skipped, its displacements unread.
//
//     field   . . . . . . . . | o O O O O O O o | o O O O O O O O      O: above the lowest position
//     u       not read          read, written     read, written
//
// If all elements of a brick were at rest at the pick, and one field holds for all directions,
// displacements follow from the field and the turns of the drag since. If the caches can't hold
// them, they are not read then, and are written by non-temporal stores: an ordinary store reads the
// line first.

#pragma once

#include <array>
#include <span>

#include "propagate/sweep_kernels.h"

namespace pliant {

/// A motion of one component in one direction: w = sign·u rose to max(w, raised − left).
struct DragTurn {
    Fixed left, sign;
};

/// Turns of one component since the pick that still determine positions, in their order. Directions
/// alternate, and of two turns in the same direction the later one went less far: otherwise the
/// earlier one would no longer matter, nor the turns between them.
class DragTurns {
  public:
    static constexpr std::size_t kMost = 4;

    void clear() { m_count = 0, m_is_lost = false; }
    /// Adds a move. @pre turn.left is at most that of the previous move, if that had the same
    /// direction
    void add(DragTurn turn);
    std::span<const DragTurn> turns() const { return {m_turns.data(), m_count}; }
    /// Whether there were too many turns.
    bool is_lost() const { return m_is_lost; }

  private:
    void remove(std::size_t at);

    std::array<DragTurn, kMost + 1> m_turns{};
    std::size_t m_count = 0;
    bool m_is_lost = false;
};

/// One component of a brick that moves: w = sign·u rises to max(w, raised − left).
struct DraggedComponent {
    Fixed* u;
    const Fixed* raised;
    Fixed left, sign;
    Fixed lowest;  ///< in and out: lower bound of w
    /// The same arrays of the next brick, or again these ones: prefetched line by line meanwhile.
    const Fixed* next_u;
    const Fixed* next_raised;
    std::span<const DragTurn> turns{};  ///< that lead from 0 to u; empty if u isn't known
};
struct DraggedBrick {
    int moved = 0;  ///< number of elements
    /// Lines were skipped, so no element may be as low as the bounds.
    bool has_wide_bounds = false;
};

/// Moves the elements of a brick. @param components  1…3  @param count  elements in each array;
/// arrays are aligned to 64 bytes. @param known  u follows from the turns, and `raised` is the same
/// for all
using MoveDragged = DraggedBrick (*)(std::span<DraggedComponent> components, int count, bool known);

/// Fields of a brick that a pick examines (drag_fields.h).
struct FieldsOfBrick {
    std::array<const Fixed*, 6> of;  ///< by direction: 2·axis, + 1 for the positive one
    std::array<const Fixed*, 3> u;
    std::array<Fixed, 6> ahead;  ///< a field raises an element to field + ahead
    bool at_rest;                ///< all u are 0
};
struct LookAtFields {
    std::array<Fixed, 6> highest;
    int reached;  ///< number of elements that any field would raise
};
using LookAtBrick = LookAtFields (*)(const FieldsOfBrick& fields, int count);

/// Each thread calls this after its moves. Otherwise other threads could see its next writes before
/// its non-temporal ones.
void finish_moves();

/// Plain loops, any size.
LookAtBrick plain_look_at_fields();
/// Vector instructions, the best that this processor supports. @pre count is a multiple of 16
LookAtBrick vector_look_at_fields();

/// Plain loops, any size.
MoveDragged plain_move_dragged();
/// Vector instructions, the best that this processor supports. @pre count is a multiple of 16
MoveDragged vector_move_dragged();

}  // namespace pliant
