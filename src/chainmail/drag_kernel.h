// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of a drag, of its frames and of the look at a pick's fields, twice: plain, and
// with vector instructions. Both give the same bits.
//
// A frame waits for memory, so it doesn't touch what it needn't: a brick is cut into lines of 16
// elements, 64 bytes of each array. A line whose fields ask for no place above the brick's lowest
// is passed over, its displacements unread.
//
//     field   . . . . . . . . | o O O O O O O o | o O O O O O O o      O: above the lowest place
//     u       not read          read, written     read, written
//
// Where all was at rest at the pick, and one field holds for all directions, displacements follow
// from the field and the turns of the drag since. If the caches can't hold them anyway, they are
// not read then, and written past the caches: what is written through those is read first.

#pragma once

#include <array>
#include <span>

#include "chainmail/sweep_kernels.h"

namespace pliant {

/// So far one component went in one direction: w = sign·u rose to max(w, raised − left).
struct DragTurn {
    Fixed left, sign;
};

/// The turns of one component since the pick that still tell where elements are, in their order.
/// Directions alternate, and of two turns in the same direction the later one went less far: else
/// the earlier one would no longer matter, nor what was between them.
class DragTurns {
  public:
    static constexpr std::size_t kMost = 4;

    void clear() { m_count = 0, m_is_lost = false; }
    /// Adds a move. @pre turn.left is no larger than that of the move before, if that went the same
    /// way
    void add(DragTurn turn);
    std::span<const DragTurn> turns() const { return {m_turns.data(), m_count}; }
    /// There were too many.
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
    Fixed lowest;  ///< in and out: a lower bound of w
    /// The same arrays of the brick that comes next, or these once more: asked for line by line
    /// meanwhile.
    const Fixed* next_u;
    const Fixed* next_raised;
    std::span<const DragTurn> turns{};  ///< where u is, from 0 on; if it is known
};
struct DraggedBrick {
    int moved = 0;  ///< elements
    /// Lines were passed over, so that there may be nothing as low as the bounds.
    bool has_wide_bounds = false;
};

/// Moves the elements of a brick. @param components  1…3  @param count  elements in each array;
/// arrays are aligned to 64 bytes. @param known  what u is follows from the turns, and `raised` is
/// the same for all
using MoveDragged = DraggedBrick (*)(std::span<DraggedComponent> components, int count, bool known);

/// What a pick wants to know of the fields of a brick (drag_fields.h).
struct FieldsOfBrick {
    std::array<const Fixed*, 6> of;  ///< by direction: 2·axis, + 1 for the positive one
    std::array<const Fixed*, 3> u;
    std::array<Fixed, 6> ahead;  ///< a field raises an element to field + ahead
    bool at_rest;                ///< all u are 0
};
struct LookAtFields {
    std::array<Fixed, 6> highest;
    int reached;  ///< elements that any field would raise
};
using LookAtBrick = LookAtFields (*)(const FieldsOfBrick& fields, int count);

/// To be called by each thread after its moves, or other threads might see what it does next before
/// what was written past the caches.
void finish_moves();

/// Plain loops, any size.
LookAtBrick plain_look_at_fields();
/// Vector instructions, the best that this processor has. @pre count is a multiple of 16
LookAtBrick vector_look_at_fields();

/// Plain loops, any size.
MoveDragged plain_move_dragged();
/// Vector instructions, the best that this processor has. @pre count is a multiple of 16
MoveDragged vector_move_dragged();

}  // namespace pliant
