// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Search of the elements that tools edit: links that a blade cuts, and elements that a capsule
// carves. A link is cut where the straight segment between the present positions of its two
// elements crosses one of the ribbon's triangles.
//
// Positions are along the lattice's axes, from element (0,0,0) at rest, in fixed-point units; ties
// are decided as in mesh/blade.h.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/result.h>
#include <pliant/tool.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "field/field.h"
#include "mesh/blade.h"

namespace pliant {

/// What a model says of its elements.
struct ElementFacts {
    std::function<bool(Vec3i)> is_void;      ///< no link, and nothing to carve
    std::function<bool(Vec3i)> is_tissue;    ///< a voxel of the scan that isn't air
    std::function<bool(Vec3i)> never_moves;  ///< bone
    std::int64_t max_elements = 0;           ///< to examine
    const char* remedy = "";                 ///< end of the message if there are more
};

/// New edits, complete before any of them is made.
struct NewEdits {
    EditMap bricks{};        ///< all edits of each changed brick
    std::int64_t count = 0;  ///< links, or elements
    bool in_tissue = false;  ///< whether some of them are tissue
};

/// Two triangles for each piece of the line; pieces along the depth vector have none.
/// @returns InvalidArgument if the line, the depth or the whole ribbon is degenerate
Result<std::vector<Triangle>> ribbon_of(const Grid& grid, const CutSurface& surface);

/// Finds the links that cross one of the triangles; links at void elements don't count.
/// @returns LimitExceeded for a larger blade
Result<NewEdits> find_cuts(const Field& field, const ElementFacts& facts,
                           std::span<const Triangle> ribbon, const TaskArena& arena);

/// Finds the elements whose present position lies inside of a tool.
/// @returns InvalidArgument for a tool out of range, LimitExceeded for one that is too large
Result<NewEdits> find_carved(const Field& field, const ElementFacts& facts, const CarveTool& tool);

}  // namespace pliant
