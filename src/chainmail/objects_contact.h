// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// When boxes meet.
//
// While the fraction f of a push δ grows, component a of an element stands still until
// f = 1 − raise_a/|δ_a| and then moves along (step.h): on each axis it moves one way only. So the
// fractions at which two boxes overlap on one axis are an open interval, and those at which they
// overlap at all are the intersection of three. Its ends are ratios of whole numbers: the first
// impact is exact, and however fast something moves, it can't pass.
//
//   axis x   --------(=================---------> f
//   axis y   (=============)-------------------->
//   axis z   ----(=====================)-------->
//                    |     |
//                    impact (none where this is empty)

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "chainmail/cut.h"

namespace pliant {

/// num/den, exactly. @pre den > 0, both below 2³¹ in size
struct Ratio {
    std::int64_t num = 1, den = 1;

    friend constexpr bool operator<(Ratio p, Ratio q) { return p.num * q.den < q.num * p.den; }
    friend constexpr bool operator==(Ratio p, Ratio q) { return p.num * q.den == q.num * p.den; }
    double value() const { return double(num) / double(den); }
};
inline constexpr Ratio kBefore{-1, 1};  ///< every fraction of a push
inline constexpr Ratio kAfter{2, 1};

/// What overlaps on one axis while enter < f < leave.
struct OverlapTime {
    Ratio enter = kAfter, leave = kAfter;  ///< never
};

/// @param distance  from a box that stands still to one that moves, centre to centre [units]
/// @param reach     half of both boxes' extents: they overlap where they are nearer than that
/// @param raise     how far the moving one is moved by the whole push, 0…|shift|
OverlapTime overlap_time(std::int64_t distance, std::int64_t reach, Fixed raise, Fixed shift);

/// When three axes overlap at the same time.
struct Impact {
    Ratio enter, leave;  ///< largest enter, smallest leave; no impact unless enter < leave
    int leave_axis = 0;

    bool happens() const { return enter < leave && enter < Ratio{1, 1}; }
};
Impact impact_of(const Place& distance, const Place& reach, Vec3<Fixed> raise, Vec3<Fixed> shift);

/// When a moving box's face reaches a plane; kAfter: it doesn't.
/// @param gap   from the box to the plane, ≥ 0
/// @param side  +1: the box must stay above the plane
Ratio wall_time(std::int64_t gap, int side, Fixed raise, Fixed shift);

/// Of a shift, each component rounded towards zero.
Vec3<Fixed> ratio_of(Vec3<Fixed> shift, Ratio fraction);

}  // namespace pliant
