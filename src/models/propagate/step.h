// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The valid fraction of a push, and its execution.
//
// While the fraction f of a push δ grows from 0 to 1, component a of an element stays at its
// position until f = 1 − raise_a/|δ_a| and then moves along with δ_a. So bone bounds f by the first
// component that would move it, and a movement limit by the root of a quadratic on one of at most
// four straight pieces. The largest valid fraction is exact, without retries; the thesis shortens
// the push and tries again [Draeger2005, 3.5.5].

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/material.h>
#include <pliant/tool.h>

#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "propagate/propagation.h"

namespace pliant {

struct StepLimit {
    double fraction = 1;
    LimitedBy limited_by = LimitedBy::None;
};

/// Keeps the smaller fraction; bone before movement if they are equal.
void tighten(StepLimit& limit, StepLimit other);

/// Bound of one element; reads `fixed` and `max_movement` only.
/// @param raise  its motion for the whole shift, 0…|shift| for each component
/// @returns limited_by None if there is none
StepLimit limit_of_element(const HalfLimits& half, Vec3<Fixed> u, Vec3<Fixed> raise,
                           Vec3<Fixed> shift);

/// Bound of the grabbed elements alone: an upper bound for the solve, found without it.
StepLimit limit_of_grabbed(const Lattice& lattice, std::span<const ElementRef> grabbed,
                           Vec3<Fixed> shift);

/// Motion of one brick's elements in a whole step; `left` grows by the part that is not done.
using BrickMotion = std::array<MovingComponent, 3>;

/// Whether elements are within the movement limits of their brick if they come no farther than this
/// along each axis. @param least_movement  of the brick
bool stays_inside(Fixed least_movement, const Vec3d& farthest);
/// Bound of one brick's elements, one by one. @param with_fixed  includes bone; else movement alone
StepLimit limit_of_brick(const Lattice& lattice, const Brick& brick, const BrickMotion& motion,
                         Vec3<Fixed> shift, bool with_fixed);
/// Moves a brick's elements. @returns the number of moved elements
int move_brick(const Lattice& lattice, Brick& brick, BrickMotion motion, Vec3<Fixed> shift,
               Vec3<Fixed> done, const SweepKernels& kernels);

/// Largest fraction of the shift for which every state on the way is valid.
/// @pre work holds the raises of the whole shift
StepLimit limit_of_reached(const Lattice& lattice, const SweepWork& work,
                           const SweepKernels& kernels, Vec3<Fixed> shift, const TaskArena& arena);

/// Fixed elements that bound the shift to this fraction. @pre as for limit_of_reached
std::vector<Vec3i> bone_at_limit(const Lattice& lattice, const SweepWork& work, Vec3<Fixed> shift,
                                 double fraction);

/// The shift times the fraction, each component rounded towards zero.
Vec3<Fixed> fraction_of(Vec3<Fixed> shift, double fraction);

/// Lets the lattice's observer allocate its memory for all bricks that apply_shift may move. May
/// throw; apply_shift then doesn't.
void reserve_moves(Lattice& lattice, const SweepWork& work);

/// Moves the reached bricks' elements for `done` (a fraction of `shift`), and ends the solve.
/// @returns the number of elements that moved
std::int64_t apply_shift(Lattice& lattice, const SweepWork& work, const SweepKernels& kernels,
                         Vec3<Fixed> shift, Vec3<Fixed> done, const TaskArena& arena);

}  // namespace pliant
