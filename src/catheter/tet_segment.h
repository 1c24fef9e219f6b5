// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A segment of a catheter of tetrahedra: a square prism between two rings of four nodes on the
// catheter's surface, cut into six tetrahedra. Its constraints are those of [VesselPbd2016]: the
// length of each edge and the volume of each tetrahedron.
//
//      7─────6        nodes 0…3 are the ring behind, 4…7 the one ahead; nodes k and k + 4 are
//     ╱│    ╱│        k quarters of a turn from the first axis
//    4─────5 │
//    │ 3╌╌╌│╌2        sides are cut from 0 and 2 to 5 and 7, in the next segment from 1 and 3 to
//    │╱    │╱         4 and 6, and so on: one leans to the left, its neighbour to the right, so
//    that 0─────1          pulling doesn't turn; what they pull at a node is balanced by the next
//    segment
//
// Tetrahedra of constant strain would be several times too stiff in bending. Bars along edges are
// not: they lengthen as the wire's surface does. So how stiff bars and volumes are follows from EI
// and GJ, of rings that stay flat and keep their shape. Inner edges aslant have no bar: it would
// make one direction stiffer than another.

#pragma once

#include <pliant/vec.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pliant::catheter {

inline constexpr std::size_t kRing = 4;    ///< nodes of a ring
inline constexpr std::size_t kAcross = 8;  ///< bars between two rings
inline constexpr std::size_t kInRing = 5;  ///< bars of a ring
inline constexpr std::size_t kTets = 6;    ///< of a segment

using Corners = std::array<Vec3d, 2 * kRing>;
struct Bar {
    std::uint8_t a, b;
    bool is_along;  ///< else aslant
};
/// @param odd  of segments with an odd number
std::array<Bar, kAcross> bars_across(bool odd);
std::array<std::array<std::uint8_t, 2>, kInRing> bars_in_ring();
std::array<std::array<std::uint8_t, 4>, kTets> tetrahedra(bool odd);

/// Straight, or with the ring ahead turned against the one behind; centred, along the third axis.
Corners corners_at_rest(double radius, double length, Vec3d turned);

double volume_of(const std::array<std::uint8_t, 4>& tet, const Corners& x);
/// ∂V/∂x of its four nodes [VesselPbd2016, Eq. 7].
std::array<Vec3d, 4> volume_gradient(const std::array<std::uint8_t, 4>& tet, const Corners& x);

/// Force for a length, and bulk modulus.
struct SegmentStiffness {
    double along = 0, aslant = 0, ring = 0, bulk = 0;
};
/// @pre twist within twist_bounds()
SegmentStiffness stiffness_for(double bend, double twist, double radius, double length);
/// GJ that a segment may have.
struct TwistBounds {
    double least, most;
};
TwistBounds twist_bounds(double bend, double radius, double length);

}  // namespace pliant::catheter
