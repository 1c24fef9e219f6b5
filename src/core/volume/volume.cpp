// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/volume.h>

#include <cmath>

namespace pliant {

float sample_linear(const Volume& volume, Vec3d ijk) {
    const Vec3i size = volume.grid.size;
    Vec3i first{};
    Vec3d part{};
    for (int a = 0; a < 3; ++a) {
        // Background from one voxel beyond the border on; NaN returns here too.
        if (!(ijk[a] > -1 && ijk[a] < size[a])) return volume.background;
        first[a] = std::int32_t(std::floor(ijk[a]));
        part[a] = ijk[a] - first[a];
    }
    const Box3i inside = voxel_box(volume.grid);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3i step{corner & 1, corner >> 1 & 1, corner >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= step[a] ? part[a] : 1 - part[a];
        if (weight == 0) continue;
        const Vec3i voxel = first + step;
        sum += weight *
               (contains(inside, voxel) ? double(volume.at(voxel)) : double(volume.background));
    }
    return float(sum);
}

}  // namespace pliant
