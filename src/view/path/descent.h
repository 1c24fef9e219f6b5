// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Descends the arrival times of a March from the front's end to its start, along the shortest path.
// Midpoint steps of half a voxel against the gradient. If they fail (beside a wall, in a corridor
// one voxel wide), steps from voxel to voxel: these always descend along an edge of a cell with
// both ends in the lumen, and so never cross a wall.

#pragma once

#include <optional>
#include <span>
#include <vector>

#include "path/lumen_tiles.h"

namespace pliant::render {

/// Whether the trilinear field is in the lumen all along a line; false if the wall is so near that
/// rounding would decide.
/// @param a, b  voxel space, inside the volume
bool is_clear(const LumenTiles& tiles, Vec3d a, Vec3d b);

/// Voxels around a position in the lumen, with a free line to it: starting points of a path.
std::vector<Vec3i> clear_corners(const LumenTiles& tiles, Vec3d position);

/// @param from, to  voxel space; the front has come from clear_corners(to) to clear_corners(from)
/// @returns from, …, to in voxel space, each with a free line to the previous one; empty if there
///          is no path
std::vector<Vec3d> descend(const LumenTiles& tiles, Vec3d from, Vec3d to);

/// Moves inner points towards the middle of their neighbours, as far as the lumen allows.
void smooth_inside(const LumenTiles& tiles, int rounds, std::vector<Vec3d>& points);

}  // namespace pliant::render
