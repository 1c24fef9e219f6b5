// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Search of the links that a blade cuts: the straight segment between the present positions of
// their two elements crosses one of the ribbon's triangles.
//
// Positions and triangles are whole numbers of fixed-point units, so the signs of all volumes are
// exact in 128 bits. A lattice has many points that lie exactly on a plane with typed coordinates,
// so ties need a rule, the same for every link and triangle: the whole ribbon is moved by an
// infinitely small vector (ε, ε², ε³) [Edelsbrunner1990]. Then no point lies on it, neighbouring
// triangles still share their edges, and a path of links that ends on the other side of a surface
// without a border has crossed it.

#pragma once

#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/tool.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace pliant {

/// A point along the lattice's axes, from element (0,0,0) at rest [fixed-point units].
using Place = Vec3<std::int64_t>;
using Triangle = std::array<Place, 3>;

/// Rest position of an element.
Place rest_place(const Grid& grid, Vec3i ijk);
inline Place moved_place(Place rest, Vec3<Fixed> u) {
    return {rest.x + u.x, rest.y + u.y, rest.z + u.z};
}

/// Whether the segment from p to q crosses the triangle moved by (ε, ε², ε³).
bool crosses(const Triangle& triangle, Place p, Place q);

/// Two triangles for each piece of the line; pieces along the depth vector have none.
/// @returns InvalidArgument if the line, the depth or the whole ribbon is degenerate
Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface);

/// Cuts the links that cross one of the triangles; links at void elements don't count.
/// @param max_elements  limit of the number of elements to examine
/// @returns the number of links that were not cut before, or LimitExceeded with nothing changed
Result<std::int64_t> cut_links(Lattice& lattice, std::span<const Triangle> ribbon,
                               std::int64_t max_elements, const TaskArena& arena);

}  // namespace pliant
