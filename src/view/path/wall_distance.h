// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Distance of a box's voxels to the wall of the lumen. The wall is the set of threshold crossings
// between neighbouring voxels along an axis. The distance to this set is exact.

#pragma once

#include <pliant/render.h>

#include <vector>

namespace pliant::render {

/// Values in the lumen, as for first hits.
struct LumenSide {
    double iso_hu = -500;
    Polarity polarity = Polarity::Rising;

    bool contains(double value_hu) const {
        return (value_hu < iso_hu) == (polarity == Polarity::Rising);
    }
};

/// @param box  inside the volume, not empty
/// @param[out] wall_mm  one for each voxel of the box, i fastest: distance to the nearest crossing
///                      in the box, for voxels in the lumen and in the tissue; infinite: none
void wall_distance(const Volume& volume, const Box3i& box, const LumenSide& lumen,
                   const TaskArena& arena, std::vector<float>& wall_mm);

}  // namespace pliant::render
