// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Simple scans, tissue over them, and random edits of it.

#pragma once

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <utility>
#include <vector>

#include "chainmail/instances.h"
#include "support/random.h"

namespace pliant::test {

template <class Visit>
void for_each_element(const Grid& grid, const Visit& visit) {
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) visit(Vec3i{x, y, z});
}

/// A scan from a formula. @param value  Vec3i → HU
template <class Value>
Volume volume_of(Vec3i size, const Value& value) {
    Volume volume;
    volume.grid.size = size;
    std::vector<std::int16_t> voxels;
    for_each_element(volume.grid, [&](Vec3i e) { voxels.push_back(std::int16_t(value(e))); });
    volume.voxels = voxels;
    return volume;
}

/// A scan of one value.
inline Volume block(Vec3i size, int value = 40, Vec3d spacing_mm = {1, 1, 1}) {
    Volume volume = volume_of(size, [=](Vec3i) { return value; });
    volume.grid.spacing_mm = spacing_mm;
    return volume;
}

inline ChainMail tissue_of(const Volume& volume, const TaskArena& arena,
                           const ChainMailSettings& settings = {}) {
    auto tissue = ChainMail::create(volume, settings, arena);
    EXPECT_TRUE(tissue.ok()) << (tissue.ok() ? "" : tissue.error().message);
    return std::move(*tissue);
}

inline ChainMail tissue_of(const Volume& volume, const MaterialLaw& law, const TaskArena& arena,
                           int brick_size = 8) {
    ChainMailSettings settings;
    settings.custom_law = law;
    settings.brick_size = brick_size;
    return tissue_of(volume, arena, settings);
}

inline ChainMail tissue_of(const Instance& instance, const TaskArena& arena,
                           ChainMailSolver solver = ChainMailSolver::Sweep) {
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    settings.solver = solver;
    return tissue_of(instance.volume, arena, settings);
}

inline Vec3d random_place(Random& random, const Grid& grid) {
    return world_from_voxel(grid, {random.real(0, grid.size.x), random.real(0, grid.size.y),
                                   random.real(0, grid.size.z)});
}

inline void random_cut(Random& random, ChainMail& tissue) {
    const Grid& grid = tissue.volume().grid;
    const CutSurface surface{{random_place(random, grid), random_place(random, grid)},
                             random.vector(10)};
    ASSERT_TRUE(tissue.cut(surface).ok());
}

inline void random_carve(Random& random, ChainMail& tissue) {
    const Grid& grid = tissue.volume().grid;
    const CarveTool tool{random_place(random, grid), random_place(random, grid),
                         random.real(0.2, 1.0)};
    ASSERT_TRUE(tissue.carve(tool).ok());
}

inline void random_push(Random& random, ChainMail& tissue, double reach_mm) {
    const std::vector<Vec3i> grabbed = random_grab(random, tissue.volume().grid);
    const Vec3d push_mm = random.vector(reach_mm);
    ASSERT_TRUE(tissue.push_elements(grabbed, push_mm).ok());
}

}  // namespace pliant::test
