// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Dragging: while the same elements stay grabbed, how far everything else must come along depends
// on links and materials alone, not on what happened on the way. So it is found once, at the pick.
//
// Let the pick raise component a by the reach R, in both directions, and keep what that leaves of
// the reach at each element, v⁺ and v⁻ (drag_fields.h); a⁺ and a⁻ is how far ahead the grabbed
// elements were. When these have been moved by t since the pick, the least move is
//
//   t_a grows:    u'(j) = max( u(j),   v⁺(j) + a⁺ − (R − t_a) )
//   t_a shrinks:  u'(j) = min( u(j), −(v⁻(j) + a⁻ − (R + t_a)) )
//
// one pass over the bricks whose bounds say that anything in them can move. What says so is kept
// apart from all else, a line of the caches for each brick.
//
// The solves look only as far as the reach, from where elements were at the pick. That is far
// enough as long as the places that t_a has had since the pick lie within R of each other; a drag
// that leaves that range renews the pick.
//
// Bone that would move bounds the travel in each direction, known from the pick on.

#pragma once

#include <pliant/tasks.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "chainmail/drag_fields.h"
#include "chainmail/drag_kernel.h"
#include "chainmail/propagation.h"
#include "chainmail/step.h"

namespace pliant {

/// The fields of one pick, and where the drag is.
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
    /// Tells the lattice's observer of all bricks that move may then move.
    StepLimit limit(const Lattice& lattice, Vec3<Fixed> step, const TaskArena& arena);
    /// Moves everything, as the grabbed elements move by the step. Until the fields are let go,
    /// the bounds of bricks may be wider than what is in them.
    /// @pre the limits allow it  @returns the number of elements that moved
    std::int64_t move(Lattice& lattice, Vec3<Fixed> step, MoveDragged move_dragged,
                      const TaskArena& arena);
    /// Forgets the fields, and drops bricks that they alone kept.
    void let_go(Lattice& lattice) noexcept;

    Fixed reach() const { return m_reach; }
    std::int64_t reach_elements() const { return m_reach_elements; }
    /// Memory that is there for the fields alone.
    std::size_t bytes() const;

  private:
    /// What each frame looks at of each brick.
    struct alignas(64) FieldBrick {
        Brick* brick;
        Fixed least_movement = 0;
        bool has_wide_bounds = false;                ///< of its displacements
        bool was_at_rest = false;                    ///< at the pick, and all fields are one
        bool is_told = false;                        ///< the observer knows that it moves
        std::array<Fixed, 6> highest{};              ///< largest value of each field
        Vec3<Fixed> u_min{0, 0, 0}, u_max{0, 0, 0};  ///< as in the brick: none else moves it now
    };
    static_assert(sizeof(FieldBrick) == 64);
    /// A step as the fields see it.
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
    /// How far from rest the brick's elements may come along each axis.
    static Vec3d farthest(const FieldBrick& field, const Frame& frame, unsigned axes);
    BrickMotion motion_of(std::size_t place, const Frame& frame, unsigned axes) const;
    /// @param next  place of the brick whose arrays are asked for meanwhile
    int move_brick(Lattice& lattice, std::size_t place, const Frame& frame, unsigned axes,
                   std::size_t next, MoveDragged move_dragged);

    Fixed m_reach = 0;
    Vec3<Fixed> m_offset{0, 0, 0};                      ///< of the grabbed elements since the pick
    Vec3<Fixed> m_lowest{0, 0, 0}, m_highest{0, 0, 0};  ///< that it has been
    std::array<DragTurns, 3> m_turns;                   ///< of each component since the pick
    std::vector<FieldBrick> m_bricks;
    DragFields m_fields;
    std::vector<FieldArrays> m_arrays;  ///< of each of them
    std::vector<int> m_indices;         ///< of each of them, in the lattice
    /// By direction: how much a fixed element would be raised by the whole reach; 0: none.
    std::array<Fixed, 6> m_bone{};
    std::int64_t m_reach_elements = 0;
    std::uint64_t m_told_step = 0;  ///< the observer's, for is_told
};

}  // namespace pliant
