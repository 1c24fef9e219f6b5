// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which voxels a deformation can change, and which cells it moves: one bit each, brick by brick.
//
// A cell is touched if one of its corners moved or is void. The cells that aren't stay where they
// are, so the touched ones together cover at most the place that they covered at rest: a voxel can
// change only if all eight cells around it are touched.

#pragma once

#include "resample/snapshot.h"

namespace pliant {

/// Voxels of a brick that can change. @param[out] rows  brick_size² rows, y faster than z
/// @returns whether there are any
bool changeable_rows(const Snapshot& snapshot, int brick_size, Vec3i coord, RowBits* rows);

/// Touched cells of a brick, named by their lowest corner. @param[out] rows  likewise
/// @returns whether there are any
bool touched_rows(const Snapshot& snapshot, int brick_size, Vec3i coord, RowBits* rows);

}  // namespace pliant
