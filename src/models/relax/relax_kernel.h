// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Moves the elements of one colour of one brick to their positions of least energy.
//
// Elements with an even and with an odd sum of coordinates are the two colours of a chessboard: all
// neighbours of one colour have the other. With its neighbours fixed, component a of an element has
// least energy at
//
//   u + x,   x = Σ weight_j · (e_j − e) / Σ weight_j        (e = u − imprint)
//
// and its energy is a parabola in the step δ, so any δ between 0 and 2x lowers it [Young1971]. The
// step is x rounded to the nearest unit plus (ω − 1)·x rounded towards zero, which is always below
// 2x. Where |x| is exactly half a unit, one unit towards the rest position leaves the energy
// unchanged, and is taken: so the last units decay, and no cycle is possible. The step is then
// clamped to the limits of the links, which always allow a step of zero.
//
// The quotient is exact enough to be a function of whole numbers alone: weights are below 2¹⁶,
// differences below 2³⁰, so both sums are exact doubles, and no quotient of such numbers rounds to
// a half unless it is one. Every element is computed separately: no sum depends on order or lanes.

#pragma once

#include <array>
#include <cstdint>

#include "lattice/lattice.h"
#include "relax/relax_links.h"

namespace pliant {

/// Restricts a move that the links allow.
class MoveGuard {
  public:
    virtual ~MoveGuard() = default;
    /// @param index  of the element in its brick
    /// @returns a position between `from` and `to`, component by component
    virtual Vec3<Fixed> admit(int index, Vec3<Fixed> from, Vec3<Fixed> to) const = 0;
};

/// A brick, and the data of its six neighbours that it needs. Null pointers: no data.
struct RelaxedBrick {
    int size;
    int parity;                                       ///< of its first element's coordinate sum
    std::array<Fixed*, 3> u;                          ///< by component
    std::array<std::array<const Fixed*, 6>, 3> side;  ///< u of the neighbours; null: at rest
    const BrickLinks* links;
    std::array<const Fixed*, 3> imprint;  ///< null: none
    std::array<const double*, 3> pull;  ///< Σ weight_j · (p − p_j) of the imprint p; null: none
    const std::uint8_t* held;           ///< by element, nonzero: stays; null: none
    const MoveGuard* guard;
    bool guard_all;              ///< calls the guard for every move, not only beyond that distance
    double free_radius_squared;  ///< squared distance from rest of free moves [units²]
};

/// @param colour  0 or 1
/// @returns the largest step of any component [units]; 0: nothing moved
Fixed relax_colour(const RelaxedBrick& brick, int colour, double over_relaxation);

/// The version for any processor, and the one for AVX2.
Fixed relax_colour_plain(const RelaxedBrick& brick, int colour, double over_relaxation);
Fixed relax_colour_avx2(const RelaxedBrick& brick, int colour, double over_relaxation);

}  // namespace pliant
