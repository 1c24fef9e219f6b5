// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stencils of a lattice tetrahedron by the signs of its corners [Labelle2007, figure 3]. Corners 0
// and 1 are joined by a long edge, 2 and 3 by the other one; the remaining four edges are short.
//
// A face with two positive corners p, q and a negative one is cut to a quadrilateral, and both
// tetrahedra at the face must split it alike. If pq is long, the diagonal starts at the even one of
// the two (parity rule). Otherwise one of the cut edges is long, and the diagonal ends at its cut.
// (The opposite choice gives a minimum angle of 8.5° instead of 10.7°.)

#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace pliant::mesh {

/// A corner (both equal), or the cut on the edge between two corners.
struct StencilCorner {
    std::int8_t first, second;
};
using StencilTet = std::array<StencilCorner, 4>;

struct Stencil {
    /// Positively oriented.
    std::vector<StencilTet> tetrahedra;
    /// Alternative split if a quadrilateral on the surface may be split either way, with the two
    /// diagonals to choose from.
    std::vector<StencilTet> other;
    StencilCorner diagonal[2]{}, other_diagonal[2]{};
};

/// @param signs  −1, 0, 1 of each corner
/// @param even   whether corner 0 (not 1) is even, and corner 2 (not 3)
const Stencil& stencil_of(const std::array<std::int8_t, 4>& signs, bool even_01, bool even_23);

}  // namespace pliant::mesh
