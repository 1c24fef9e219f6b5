// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Search of the links that a blade cuts: the straight segment between the present positions of
// their two elements crosses one of the ribbon's triangles.
//
// Positions are along the lattice's axes, from element (0,0,0) at rest, in fixed-point units; ties
// are decided as in mesh/blade.h.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/result.h>
#include <pliant/tool.h>
#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "mesh/blade.h"

namespace pliant {

/// Rest position of an element.
Position rest_position(const Grid& grid, Vec3i ijk);
inline Position moved_position(Position rest, Vec3<Fixed> u) {
    return {rest.x + u.x, rest.y + u.y, rest.z + u.z};
}

/// Two triangles for each piece of the line; pieces along the depth vector have none.
/// @returns InvalidArgument if the line, the depth or the whole ribbon is degenerate
Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface);

/// Cuts the links that cross one of the triangles; links at void elements don't count.
/// @param max_elements  limit of the number of elements to examine
/// @returns the number of links that were not cut before, or LimitExceeded with nothing changed
Result<std::int64_t> cut_links(Lattice& lattice, std::span<const Triangle> ribbon,
                               std::int64_t max_elements, const TaskArena& arena);

}  // namespace pliant
