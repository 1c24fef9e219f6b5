// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Coarse hollow spaces of a scan: block means, connected parts, and distances to the nearest wall.

#pragma once

#include <pliant/render.h>

#include <cstdint>
#include <vector>

#include "volume/boxes.h"

namespace pliant::render {

struct CoarseVolume {
    Vec3i size{0, 0, 0};
    Vec3i step{1, 1, 1};         ///< voxels per cell and axis
    Vec3d spacing_mm{1, 1, 1};   ///< between cell centres
    std::vector<float> mean_hu;  ///< i fastest

    std::size_t index(Vec3i p) const { return dense_index(p, size); }
    Vec3i cell(std::size_t i) const {
        const auto x = std::size_t(size.x), y = std::size_t(size.y);
        return {int(i % x), int(i / x % y), int(i / (x * y))};
    }
};

/// Computes block means at the resolution that a few million cells allow.
CoarseVolume make_coarse(const Volume& volume, const TaskArena& arena);
/// Continuous voxel index of a cell's centre.
Vec3d voxel_of_cell(const CoarseVolume& coarse, const Grid& grid, std::size_t cell);

/// One byte per cell: 1 if the mean is on the lumen's side of the threshold. Parts with a large
/// share of the volume's border, like the air around a patient, are left out unless allowed.
std::vector<std::uint8_t> lumen_mask(const CoarseVolume& coarse, double threshold_hu,
                                     Polarity polarity, bool allow_outside);

/// Number of cells of the connected part to which each cell of the mask belongs; 0 outside of it.
std::vector<std::uint32_t> part_sizes(const CoarseVolume& coarse, std::vector<std::uint8_t> mask);

/// Share of the directions from a cell that lead through tissue of this thickness before they leave
/// the volume: 1 deep in a body, about a half between a patient and the table.
double share_behind_tissue(const CoarseVolume& coarse, Vec3i cell, double tissue_hu,
                           double thickness_mm);

/// Euclidean distance [mm] of each cell of the mask to the nearest cell outside of it; 0 outside of
/// the mask. The volume's border is no wall.
std::vector<float> wall_distance_mm(const CoarseVolume& coarse,
                                    const std::vector<std::uint8_t>& mask, const TaskArena& arena);

/// Unit vectors, evenly distributed on the sphere.
std::vector<Vec3d> sphere_directions(int count);

}  // namespace pliant::render
