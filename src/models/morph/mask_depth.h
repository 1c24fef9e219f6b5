// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Depth of a mask's voxels, its pieces, and its smoothed values.

#pragma once

#include <vector>

#include "morph/parts.h"

namespace pliant::morph {

/// Distance of each voxel to the nearest one outside of the mask [mm]; 0 outside.
std::vector<float> depth_mm(const Mask& mask);

/// Gaussian smoothing of a mask, on a box around it that is clipped to the grid. The border's
/// voxels continue beyond it.
class SmoothMask {
  public:
    SmoothMask(const Mask& mask, double deviation_mm);

    Vec3i size() const { return m_grid.size; }
    float at(Vec3i p) const { return m_values[voxel_index(m_grid, p)]; }
    /// Gradient along the grid's axes [1/mm], from central differences.
    Vec3d slope(Vec3i p) const;
    Vec3d world(Vec3i p) const {
        return world_from_voxel(m_grid, {double(p.x), double(p.y), double(p.z)});
    }

  private:
    Grid m_grid;
    std::vector<float> m_values;
};

}  // namespace pliant::morph
