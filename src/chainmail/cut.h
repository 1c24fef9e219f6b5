// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which links a blade cuts: those whose straight segment between the present places of their two
// elements crosses one of the ribbon's triangles.
//
// Places and triangles are whole numbers of fixed-point units, so the signs of all volumes are
// exact in 128 bits. A lattice has many points that lie exactly on a plane that a person types, so
// ties need a rule, and the rule must be the same for every link and triangle: the whole ribbon is
// thought to be moved by an infinitely small vector (ε, ε², ε³) [Edelsbrunner1990]. Then nothing
// lies on it, neighbouring triangles still share their edges, and a path of links that ends on the
// other side of a surface without a border has crossed it.

#pragma once

#include <pliant/chainmail_edits.h>
#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/tasks.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "chainmail/lattice.h"

namespace pliant {

/// A point along the lattice's axes, from element (0,0,0) at rest [fixed-point units].
using Place = Vec3<std::int64_t>;
using Triangle = std::array<Place, 3>;

/// Where an element is at rest.
Place rest_place(const Grid& grid, Vec3i ijk);
inline Place moved_place(Place rest, Vec3<Fixed> u) {
    return {rest.x + u.x, rest.y + u.y, rest.z + u.z};
}

/// Whether the segment from p to q crosses the triangle moved by (ε, ε², ε³).
bool crosses(const Triangle& triangle, Place p, Place q);

/// Two triangles for each piece of the line; pieces along the depth vector have none.
/// @returns InvalidArgument if the line, the depth or all of the ribbon are of no use
Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface);

/// Cuts the links that cross one of the triangles; those at void elements don't count.
/// @param max_elements  how many may be looked at
/// @returns the number of links that were not cut before, or LimitExceeded with nothing changed
Result<std::int64_t> cut_links(Lattice& lattice, std::span<const Triangle> ribbon,
                               std::int64_t max_elements, const TaskArena& arena);

}  // namespace pliant
