// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dragging. While the same elements stay grabbed, the distance that every other element must follow
// depends on links and materials alone, not on the path of the tool. So it is computed once, at the
// pick.
//
// Let the pick raise component a by the reach R, in both directions, and store the remainder of the
// reach at each element, v⁺ and v⁻ (drag_fields.h); a⁺ and a⁻ are the positions of the
// farthest grabbed elements. When they have been moved by t since the pick, the least move is
//
//   t_a grows:    u'(j) = max( u(j),   v⁺(j) + a⁺ − (R − t_a) )
//   t_a shrinks:  u'(j) = min( u(j), −(v⁻(j) + a⁻ − (R + t_a)) )
//
// one pass over the bricks whose bounds allow a motion of their elements. These bounds are stored
// apart from all other data, one cache line per brick.
//
// The solves look only as far as the reach, from the positions of elements at the pick. That is
// sufficient as long as all values of t_a since the pick lie within R of each other; a drag that
// leaves that range renews the pick.
//
// Bone that would have to move bounds the travel in each direction, known from the pick on.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "propagate/drag_fields.h"
#include "propagate/drag_kernel.h"
#include "propagate/propagation.h"
#include "propagate/step.h"

namespace pliant {

/// The fields of one pick, and the state of the drag.
class Drag {
  public:
    /// Computes the fields. @param reach  [units] > 0
    /// @returns false if more than max_bricks would be needed; then nothing is grabbed
    [[nodiscard]] bool pick(Lattice& lattice, std::span<const ElementRef> grabbed, Fixed reach,
                            const SweepKernels& kernels, LookAtBrick look, const TaskArena& arena,
                            int max_bricks, SweepWork& work);
    /// Whether the fields hold for a further step.
    bool covers(Vec3<Fixed> step) const;
    /// Largest fraction of a step that bone and movement limits allow.
    /// Tells the lattice's observer of all bricks that may move in it.
    StepLimit limit(const Lattice& lattice, Vec3<Fixed> step, const TaskArena& arena);
    /// Moves all elements for a step of the grabbed ones. Until the fields are released, the bounds
    /// of bricks may be wider than their contents.
    /// @pre the limits allow it  @returns the number of elements that moved
    std::int64_t move(Lattice& lattice, Vec3<Fixed> step, MoveDragged move_dragged,
                      const TaskArena& arena);
    /// Releases the fields, and drops bricks that only they kept.
    void let_go(Lattice& lattice) noexcept;

    Fixed reach() const { return m_reach; }
    std::int64_t reach_elements() const { return m_reach_elements; }
    /// Memory of the fields alone.
    std::size_t bytes() const;

  private:
    /// Data of a brick that each frame reads.
    struct alignas(64) FieldBrick {
        Brick* brick;
        Fixed least_movement = 0;
        bool has_wide_bounds = false;                ///< the displacements' bounds are wide
        bool was_at_rest = false;                    ///< at the pick, with one array for all fields
        bool is_told = false;                        ///< the observer knows that it moves
        std::array<Fixed, 6> highest{};              ///< largest value, by field
        Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};  ///< like the brick's: no other code moves it
    };
    static_assert(sizeof(FieldBrick) == 64);
    /// A step, as seen by the fields.
    struct Frame {
        std::array<std::size_t, 3> direction;
        std::array<Fixed, 3> sign, left;
        std::array<bool, 3> moves;
    };

    void look_at_bricks(Lattice& lattice, LookAtBrick look, const TaskArena& arena);
    void bound_travel(const Lattice& lattice, const Brick& brick, const FieldArrays& fields,
                      std::array<Fixed, 6>& bone) const;
    Frame frame_of(Vec3<Fixed> step) const;
    /// A lower bound of sign·u.
    static Fixed lowest_of(const FieldBrick& field, const Frame& frame, int axis);
    /// Axes along which an element of the brick may move: bits, the lowest for i.
    static unsigned moving(const FieldBrick& field, const Frame& frame);
    /// Largest distance from rest that the brick's elements may reach along each axis.
    static Vec3d farthest(const FieldBrick& field, const Frame& frame, unsigned axes);
    BrickMotion motion_of(std::size_t index, const Frame& frame, unsigned axes) const;
    /// @param next  position of the brick whose arrays are prefetched meanwhile
    int move_brick(Lattice& lattice, std::size_t index, const Frame& frame, unsigned axes,
                   std::size_t next, MoveDragged move_dragged);

    Fixed m_reach = 0;
    Vec3<Fixed> m_offset{0, 0, 0};                      ///< of the grabbed elements since the pick
    Vec3<Fixed> m_lowest{0, 0, 0}, m_highest{0, 0, 0};  ///< of m_offset since the pick
    std::array<DragTurns, 3> m_turns;                   ///< of each component since the pick
    std::vector<FieldBrick> m_bricks;
    DragFields m_fields;
    std::vector<FieldArrays> m_arrays;  ///< of each of them
    std::vector<int> m_indices;         ///< of each of them, in the lattice
    /// [direction]: raise of a fixed element for the whole reach; 0: none.
    std::array<Fixed, 6> m_bone{};
    std::int64_t m_reach_elements = 0;
    std::uint64_t m_told_step = 0;  ///< the observer's, for is_told
};

}  // namespace pliant
