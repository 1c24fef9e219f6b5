// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A segment of a catheter of tetrahedra: a square prism between two rings of four nodes on the
// catheter's surface, cut into six tetrahedra. Its constraints are those of [VesselPbd2016]: the
// length of each edge and the volume of each tetrahedron.
//
//      7─────6        nodes 0…3 are the ring behind, 4…7 the ring ahead; nodes k and k + 4 are
//     ╱│    ╱│        k quarters of a turn from the first axis
//    4─────5 │
//    │ 3╌╌╌│╌2        sides are cut from 0 and 2 to 5 and 7, in the next segment from 1 and 3 to
//    │╱    │╱         4 and 6, and so on: diagonals lean alternately to the left and right, so
//    0─────1          tension causes no twist; the next segment balances their forces at a node
//
// Tetrahedra of constant strain would be several times too stiff in bending. Bars along edges are
// accurate: they lengthen like the wire's surface. The stiffness of bars and volumes is computed
// from EI and GJ, for rings that stay flat and keep their shape. Inner diagonals have no bar,
// because it would make the stiffness anisotropic.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pliant::catheter {

inline constexpr std::size_t kRing = 4;    ///< nodes of a ring
inline constexpr std::size_t kAcross = 8;  ///< bars between two rings
inline constexpr std::size_t kInRing = 5;  ///< bars of a ring
inline constexpr std::size_t kTets = 6;    ///< tetrahedra of a segment

using Corners = std::array<Vec3d, 2 * kRing>;
struct Bar {
    std::uint8_t a, b;
    bool is_along;  ///< axial; otherwise diagonal
};
/// @param odd  whether the segment's number is odd
std::array<Bar, kAcross> bars_across(bool odd);
std::array<std::array<std::uint8_t, 2>, kInRing> bars_in_ring();
std::array<std::array<std::uint8_t, 4>, kTets> tetrahedra(bool odd);

/// Corners centred along the third axis. @param turned  rotation of the ring ahead against the ring
/// behind
Corners corners_at_rest(double radius, double length, Vec3d turned);

double volume_of(const std::array<std::uint8_t, 4>& tet, const Corners& x);
/// ∂V/∂x of its four nodes [VesselPbd2016, Eq. 7].
std::array<Vec3d, 4> volume_gradient(const std::array<std::uint8_t, 4>& tet, const Corners& x);

/// Stiffness of bars (force per length), and bulk modulus.
struct SegmentStiffness {
    double along = 0, aslant = 0, ring = 0, bulk = 0;
};
/// @pre twist within twist_bounds()
SegmentStiffness stiffness_for(double bend, double twist, double radius, double length);
/// Range of a segment's GJ.
struct TwistBounds {
    double least, most;
};
TwistBounds twist_bounds(double bend, double radius, double length);

}  // namespace pliant::catheter
