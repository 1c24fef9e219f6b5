// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Polyhedra of material inside of one tetrahedron, and how they are split.
//
// A split separates groups of points along crossed edges. Each face between them is divided by
// chords from crossing to crossing, which close to loops inside of the tetrahedron; a fan of
// triangles caps each loop, on both sides alike:
//
//           2                    2
//          ╱ ╲                  ╱ ╲
//         ╱   ╲       →        ×───×         × crossing, ── chord
//        ╱     ╲              ×─────×
//       0───────1            0───────1
//
// Faces remain flat and convex. Two tetrahedra divide their common face alike, because chords
// depend on nothing but the crossings.

#pragma once

#include <pliant/models/cut_mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// The whole tetrahedron.
CutPart whole_part();

/// Fraction of the tetrahedron's volume: exact clipping, since the polyhedron is given.
double share_of(const CutPart& part);

/// Total area of the faces on one side, as a fraction of the tetrahedron's face.
double side_area(const CutPart& part, int side);

/// Whether two faces of a pair of parts have more than kSmallestShare of the tetrahedra's common
/// face in common.
/// @param p_corners, q_corners  the face's corners in each tetrahedron, in the same order of nodes
bool have_common_area(const CutPart& p, int p_side, const std::array<int, 3>& p_corners,
                      const CutPart& q, int q_side, const std::array<int, 3>& q_corners);

/// Winding number of the polyhedron's surface around a point: 1 inside, 0 outside.
/// @param weights  barycentric
double winding_number(const CutPart& part, const std::array<double, 4>& weights);

/// Number of each point's component over edges without a crossing, from 0 in the order of their
/// first points. @returns the number of components
int find_components(const CutPart& part, std::vector<std::int32_t>& component_of);

/// Splits a part into its components.
/// @returns an empty list if the polyhedron is too degenerate for that
std::vector<CutPart> split(CutPart part);

}  // namespace pliant
