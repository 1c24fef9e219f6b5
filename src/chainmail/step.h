// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How much of a push is allowed, and doing it.
//
// While the fraction f of a push δ grows from 0 to 1, component a of an element stays where it is
// until f = 1 − raise_a/|δ_a| and then moves along with δ_a. So bone bounds f by the first
// component that would move it, and a movement limit by the root of a quadratic on one of at most
// four straight pieces. The largest valid fraction is exact, with no retries; the thesis shortens
// the push and tries again [Draeger2005, 3.5.5].

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tasks.h>

#include <cstdint>
#include <span>

#include "chainmail/lattice.h"

namespace pliant {

struct StepLimit {
    double fraction = 1;
    LimitedBy limited_by = LimitedBy::None;
};

/// The smaller fraction; bone before movement where they are equal.
void tighten(StepLimit& limit, StepLimit other);

/// The bound that one element sets, of which only `fixed` and `max_movement` are looked at.
/// @param raise  how far the whole shift would move it, 0…|shift| for each component
/// @returns limited_by None if it sets none
StepLimit limit_of_element(const HalfLimits& half, Vec3<Fixed> u, Vec3<Fixed> raise,
                           Vec3<Fixed> shift);

/// Limit that the grabbed elements set by themselves: a bound for the solve, found without it.
StepLimit limit_of_grabbed(const Lattice& lattice, std::span<const ElementRef> grabbed,
                           Vec3<Fixed> shift);

/// Largest fraction of the shift for which every state on the way is valid.
/// @pre the reached bricks hold the raises of the whole shift
StepLimit limit_of_reached(const Lattice& lattice, std::span<const int> bricks, Vec3<Fixed> shift,
                           const TaskArena& arena);

/// By how much the whole shift of the solve in progress moves an element, 0…|shift_a|.
Vec3<Fixed> raise_of(const Brick& brick, std::size_t index, Vec3<Fixed> shift);

/// The shift times the fraction, each component rounded towards zero.
Vec3<Fixed> fraction_of(Vec3<Fixed> shift, double fraction);

/// Moves the reached bricks' elements by what `done` (a fraction of `shift`) asks for, and ends
/// the solve. @returns the number of elements that moved
std::int64_t apply_shift(Lattice& lattice, std::span<const int> bricks, Vec3<Fixed> shift,
                         Vec3<Fixed> done, const TaskArena& arena);

/// Ends the solve without moving anything.
void discard_raises(Lattice& lattice, std::span<const int> bricks);

}  // namespace pliant
