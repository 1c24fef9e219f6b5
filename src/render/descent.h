// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Down the arrival times of a March, from where the front came to where it started: the way that it
// took. Steps of half a voxel against the gradient, second order; where that fails (beside a wall,
// in a corridor one voxel wide), from voxel to voxel, which always leads down and along an edge of
// a cell whose ends are both in the lumen, and so never through a wall.

#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/lumen_tiles.h"

namespace pliant::render {

/// Whether the trilinear field is in the lumen all along a line; no where it comes so near to the
/// wall that rounding would decide.
/// @param a, b  voxel space, inside the volume
bool is_clear(const LumenTiles& tiles, Vec3d a, Vec3d b);

/// Voxels around a place, those in the lumen with nothing in between: where a way can begin.
std::vector<Vec3i> clear_corners(const LumenTiles& tiles, Vec3d place);

/// @param from, to  voxel space; the front has come from clear_corners(to) to clear_corners(from)
/// @returns from, …, to in voxel space, each clear from the one before; nothing if there is no way
std::vector<Vec3d> descend(const LumenTiles& tiles, Vec3d from, Vec3d to);

/// Moves points, but not the first and last, towards the middle between their neighbours, as far as
/// the lumen allows.
void smooth_inside(const LumenTiles& tiles, int rounds, std::vector<Vec3d>& points);

}  // namespace pliant::render
