// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/catheter.h>
#include <pliant/models/pbd.h>

#include <gtest/gtest.h>

#include <cmath>

#include "support/broken_volumes.h"

namespace pliant::test {
namespace {

/// 60 × 50 × 40 voxels of 1 × 1 × 1.5 mm with values that grow linearly along x, y and z.
Volume ramp() {
    Volume v;
    v.grid.size = {60, 50, 40};
    v.grid.spacing_mm = {1, 1, 1.5};
    v.grid.origin_mm = {-10, 5, 100};
    VoxelArray<float> values(voxel_count(v.grid));
    for (int k = 0; k < 40; ++k)
        for (int j = 0; j < 50; ++j)
            for (int i = 0; i < 60; ++i)
                values.data()[voxel_index(v.grid, {i, j, k})] = float(10 * i + 3 * j + 2 * k);
    v.voxels = std::move(values);
    return v;
}

TetMesh plate() {
    TetMesh mesh = five_tet_block({10, 10, 1}, 1.5);
    for (Vec3d& p : mesh.nodes_mm) p = p + Vec3d{12, 22, 129};
    return mesh;
}

TEST(CarriedScan, GoesWithTheWallNearItAndStaysFarFromIt) {
    const TaskArena arena(2);
    const Volume scan = ramp();
    const TetMesh wall = plate();
    auto carried = CarriedScan::create(scan, wall, {.reach_mm = 12, .cell_mm = 2}, arena);
    ASSERT_TRUE(carried.ok()) << carried.error().message;
    ASSERT_TRUE(carried->update(wall.nodes_mm).ok());
    EXPECT_TRUE(deform_volume(carried->scan()).value().written_voxels == 0);
    const Vec3d by{1.5, -0.5, 0};
    std::vector<Vec3d> moved = wall.nodes_mm;
    for (Vec3d& p : moved) p = p + by;
    ASSERT_TRUE(carried->update(moved).ok());
    const Deformed deformed = deform_volume(carried->scan()).value();
    EXPECT_GT(deformed.written_voxels, 1000);
    double near = 0, far = 0;
    int near_count = 0, far_count = 0;
    for (int k = 0; k < 40; ++k)
        for (int j = 0; j < 50; ++j)
            for (int i = 0; i < 60; ++i) {
                const Vec3d x = world_from_voxel(scan.grid, {double(i), double(j), double(k)});
                const double change =
                    double(deformed.volume.at({i, j, k})) - double(scan.at({i, j, k}));
                double least = 1e300;
                for (const Vec3d& p : wall.nodes_mm) least = std::min(least, norm(x - p));
                for (const Vec3d& p : moved) least = std::min(least, norm(x - p));
                // Inside the plate the values have moved with it: −∇ · by.
                const Vec3d m = x - moved.front();
                if (m.x > 2 && m.x < 13 && m.y > 2 && m.y < 13 && m.z > 0 && m.z < 1.5) {
                    near = std::max(near, std::abs(change + 10 * by.x + 3 * by.y));
                    ++near_count;
                }
                if (least > 12 + 4) {  // reach and a control cell
                    far = std::max(far, std::abs(change));
                    ++far_count;
                }
            }
    EXPECT_GT(near_count, 50);
    EXPECT_GT(far_count, 10000);
    EXPECT_LT(near, 0.1 * 13.5);
    EXPECT_EQ(far, 0);
    // And back.
    ASSERT_TRUE(carried->update(wall.nodes_mm).ok());
    EXPECT_EQ(deform_volume(carried->scan()).value().written_voxels, 0);
}

TEST(CarriedScan, SaysWhatIsWrong) {
    const TaskArena arena(1);
    const Volume scan = ramp();
    TetMesh wall = plate();
    EXPECT_FALSE(CarriedScan::create(scan, wall, {.reach_mm = 0}, arena).ok());
    EXPECT_FALSE(CarriedScan::create(scan, wall, {.cell_mm = -1}, arena).ok());
    auto carried = CarriedScan::create(scan, wall, {}, arena);
    ASSERT_TRUE(carried.ok());
    wall.nodes_mm.pop_back();
    EXPECT_FALSE(carried->update(wall.nodes_mm).ok());
    for (Vec3d& p : wall.nodes_mm) p.x += 1000;
    const auto beside = CarriedScan::create(scan, wall, {}, arena);
    ASSERT_FALSE(beside.ok());
    EXPECT_EQ(beside.error().message, "wall: expected inside of the scan, found beside it");
}

TEST(CarriedScan, AVolumeWithABrokenFieldIsRefused) {
    const TaskArena arena(1);
    TetMesh wall;
    wall.nodes_mm = {{0, 0, 0}};
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        expect_refused(CarriedScan::create(broken.volume, wall, {}, arena),
                       "volume." + broken.field);
    }
}

}  // namespace
}  // namespace pliant::test
