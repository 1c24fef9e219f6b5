// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Closed surfaces of organs with a given number of nodes.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/volume.h>

#include <cstddef>

namespace pliant::results {

/// The largest part of a label, smoothed, with triangles of nearly one size: boundary of
/// tetrahedra on a lattice, whose shortest edges are then collapsed one by one.
/// @param smoothing_voxels  standard deviation; raised until the surface is a sphere topologically
/// @returns Unsupported if none is
Result<TriangleMesh> organ_surface(const Volume& labels, int label, double smoothing_voxels,
                                   std::size_t nodes, const TaskArena& arena);

}  // namespace pliant::results
