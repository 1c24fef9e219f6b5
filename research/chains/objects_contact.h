// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Times at which moving boxes overlap.
//
// While the fraction f of a push δ grows, component a of an element stands still until
// f = 1 − raise_a/|δ_a| and then moves along (step.h): on each axis it moves in one direction only.
// So the fractions at which two boxes overlap on one axis are an open interval, and the fractions
// at which they overlap in space are the intersection of three. Its ends are ratios of whole
// numbers: the first impact is exact, and no speed is high enough to tunnel.
//
//   axis x   --------(=================---------> f
//   axis y   (=============)-------------------->
//   axis z   ----(=====================)-------->
//                    |     |
//                    impact (none if the intersection is empty)

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "field/brick_search.h"

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

/// Overlap on one axis: enter < f < leave.
struct OverlapTime {
    Ratio enter = kAfter, leave = kAfter;  ///< never
};

/// @param distance  from the stationary box to the moving one, centre to centre [units]
/// @param reach     half of both boxes' extents: they overlap at smaller distances
/// @param raise     motion of the moving box for the whole push, 0…|shift|
OverlapTime overlap_time(std::int64_t distance, std::int64_t reach, Fixed raise, Fixed shift);

/// Time at which all three axes overlap.
struct Impact {
    Ratio enter, leave;  ///< largest enter, smallest leave; no impact unless enter < leave
    int leave_axis = 0;

    bool happens() const { return enter < leave && enter < Ratio{1, 1}; }
};
Impact impact_of(const Position& distance, const Position& reach, Vec3<Fixed> raise,
                 Vec3<Fixed> shift);

/// Time at which a moving box's face reaches a plane; kAfter: never.
/// @param gap   from the box to the plane, ≥ 0
/// @param side  +1: the box must stay above the plane
Ratio wall_time(std::int64_t gap, int side, Fixed raise, Fixed shift);

/// Fraction of a shift, each component rounded towards zero.
Vec3<Fixed> ratio_of(Vec3<Fixed> shift, Ratio fraction);

}  // namespace pliant
