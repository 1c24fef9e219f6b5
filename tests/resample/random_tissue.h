// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissue of noise on a rotated grid, and random operations on it.

#pragma once

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <vector>

#include "resample/lattices.h"
#include "support/random.h"

namespace pliant::test {

inline Volume turned_noise(Random& random, Vec3i size, Vec3d spacing_mm) {
    Volume volume =
        make_volume(size, spacing_mm, [&](Vec3d) { return std::int16_t(random.whole(-900, 900)); });
    // Neither along the world's axes nor at its origin.
    volume.grid.direction = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    volume.grid.origin_mm = {10, -20, 5};
    return volume;
}

inline ChainMail tissue_of(const Volume& volume, const TaskArena& arena, int brick_size = 8,
                           bool bounded = false) {
    ChainMailSettings settings;
    settings.brick_size = brick_size;
    settings.bone_threshold_hu = 2000;
    settings.bounded = bounded;
    return std::move(ChainMail::create(volume, settings, arena)).value();
}

inline Push random_push(Random& random, const Grid& grid, double longest) {
    const Vec3d ijk{random.real(0, grid.size.x - 1), random.real(0, grid.size.y - 1),
                    random.real(0, grid.size.z - 1)};
    return {.point_mm = world_from_voxel(grid, ijk),
            .push_mm = random.vector(random.ratio(0.2, longest)),
            .sphere_radius_mm = random.whole(0, 1) ? 3.0 : 0.0};
}

inline void cut_or_carve(Random& random, ChainMail& tissue) {
    const Grid& grid = tissue.volume().grid;
    const Vec3d middle =
        world_from_voxel(grid, {0.5 * grid.size.x, 0.5 * grid.size.y, 0.5 * grid.size.z});
    const Vec3d at = middle + random.vector(6);
    if (random.whole(0, 1)) {
        ASSERT_TRUE(
            tissue.cut({.line_mm = {at, at + random.vector(12)}, .depth_mm = random.vector(10)})
                .ok());
    } else {
        ASSERT_TRUE(tissue.carve({.from_mm = at, .to_mm = at, .radius_mm = 2.5}).ok());
    }
}

}  // namespace pliant::test
