// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of a scan at rest: air, soft tissue, walls and bone, and distances to them.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/data/truth.h>
#include <pliant/models/material.h>
#include <pliant/volume.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace pliant::truth {

/// Distance of every voxel to the nearest source, from centre to centre [mm]; infinite without one.
/// Exact: lower envelopes of parabolas, axis by axis [Felzenszwalb2012].
/// @param is_source  [voxel]
/// @throws std::bad_alloc
std::vector<float> distances_mm(const Grid& grid, const std::vector<std::uint8_t>& is_source,
                                const TaskArena& arena);

struct Regions {
    std::vector<std::int16_t> labels;  ///< TruthLabel: air, interior, bone, wall
    std::vector<std::uint32_t> walls;  ///< soft-tissue voxels beside air, away from the border
    std::vector<std::uint32_t> soft;   ///< other soft-tissue voxels there
    std::vector<float> rigid_mm;       ///< distance to bone and the border; may be empty
};

/// @param with_distances  whether rigid_mm is needed
/// @throws std::bad_alloc
Regions find_regions(const Volume& scan, const ChainMailSettings& materials, double band_mm,
                     bool with_distances, const TaskArena& arena);

/// Unit vector into the tissue at a wall [LPS], from the tissue voxels around it; zero where they
/// are around it evenly.
Vec3d inward_normal(const Grid& grid, const std::vector<std::int16_t>& labels, Vec3i voxel);

/// Gives soft tissue around some voxels a label.
/// @param voxels  their indices
void label_around(const Grid& grid, const std::vector<std::uint32_t>& voxels, double band_mm,
                  TruthLabel label, std::vector<std::int16_t>& labels);

}  // namespace pliant::truth
