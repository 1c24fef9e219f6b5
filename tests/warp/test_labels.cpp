// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Label maps on a scan's grid, at rest and deformed, against plain loops.
// Covers: resample/labels.cpp.

#include <gtest/gtest.h>
#include <pliant/data/warp.h>
#include <pliant/resample.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "resample/random_tissue.h"

namespace pliant::test {
namespace {

Volume random_map(Random& random, const Grid& grid) {
    std::vector<std::int16_t> values(voxel_count(grid));
    for (std::int16_t& value : values) value = std::int16_t(random.whole(0, 5));
    return {grid, VoxelArray<std::int16_t>(values), {}, 0};
}

/// The label of the nearest voxel, or 0.
int nearest_label(const Volume& labels, Vec3d position_mm) {
    const Vec3d ijk = voxel_from_world(labels.grid, position_mm);
    const Vec3i at{int(std::lround(ijk.x)), int(std::lround(ijk.y)), int(std::lround(ijk.z))};
    return contains(voxel_box(labels.grid), at) ? int(labels.at(at)) : 0;
}

/// Whether a position is so near to the border of two voxels that rounding decides.
bool is_between(const Grid& grid, Vec3d position_mm, double margin) {
    const Vec3d ijk = voxel_from_world(grid, position_mm);
    for (int a = 0; a < 3; ++a)
        if (std::abs(ijk[a] - std::floor(ijk[a]) - 0.5) < margin) return true;
    return false;
}

template <class Visit>
void for_all(const Grid& grid, const Visit& visit) {
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) visit(Vec3i{i, j, k});
}

Vec3d centre(const Grid& grid, Vec3i p) {
    return world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)});
}

TEST(LabelsOnAGrid, AreThoseOfTheNearestVoxelsWhereverTheMapIs) {
    Random random(5);
    const TaskArena arena(2);
    const Volume scan = turned_noise(random, {11, 9, 7}, {1.0, 1.3, 0.8});
    const Grid& grid = scan.grid;
    std::vector<Grid> grids(6, grid);
    // Rows reversed.
    grids[0].origin_mm = centre(grid, {10, 0, 0});
    grids[0].direction.columns[0] = -1.0 * grid.direction.columns[0];
    // Axes permuted.
    grids[1].size = {7, 11, 9};
    grids[1].spacing_mm = {0.8, 1.0, 1.3};
    for (std::size_t a = 0; a < 3; ++a)
        grids[1].direction.columns[a] = grid.direction.columns[(a + 2) % 3];
    // Cropped.
    grids[2].size = {5, 4, 3};
    grids[2].origin_mm = centre(grid, {3, 2, 1});
    // Coarser, finer, and oblique.
    grids[3].size = {5, 4, 3};
    grids[3].spacing_mm = {2.1, 2.7, 1.9};
    grids[4].size = {30, 20, 20};
    grids[4].spacing_mm = {0.37, 0.61, 0.29};
    grids[5].direction = {{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}};
    for (const Grid& own : grids) {
        SCOPED_TRACE(&own - grids.data());
        const Volume labels = random_map(random, own);
        const auto on_scan = labels_on(labels, grid, arena);
        ASSERT_TRUE(on_scan.ok()) << on_scan.error().message;
        EXPECT_EQ(on_scan->grid, grid);
        int compared = 0;
        for_all(grid, [&](Vec3i p) {
            const Vec3d at = centre(grid, p);
            if (is_between(own, at, 1e-9)) return;
            EXPECT_EQ(int(on_scan->at(p)), nearest_label(labels, at));
            ++compared;
        });
        EXPECT_GT(compared, 600);
    }
    // Both types of voxels, and a map that is on the grid already.
    Volume labels = random_map(random, grid);
    EXPECT_EQ(labels_on(labels, grid, arena)->voxels, labels.voxels);
    labels.grid.origin_mm.x += 0.005;
    EXPECT_EQ(labels_on(labels, grid, arena)->grid.origin_mm, labels.grid.origin_mm);
    labels.grid = grids[0];
    labels.voxels = VoxelArray<float>(std::vector<float>(voxel_count(grid), 70000.0f));
    EXPECT_EQ(labels_on(labels, grid, arena)->at({2, 3, 4}), 70000.0f);
    // A map elsewhere.
    labels.grid.origin_mm = {500, 0, 0};
    const auto none = labels_on(labels, grid, arena);
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().message,
              "labels: expected a label map with labels inside of the scan, found none");
}

TEST(DeformedLabels, MoveWithTheScan) {
    Random random(11);
    const TaskArena arena(2);
    const Volume scan = turned_noise(random, {24, 20, 17}, {1.0, 1.3, 0.8});
    ChainMailSettings settings;
    settings.offset = 0.3;
    settings.bone_threshold_hu = 2000;
    settings.air_enabled = false;
    ChainMail tissue = std::move(ChainMail::create(scan, settings, arena)).value();
    for (int n = 0; n < 4; ++n) {
        Push push = random_push(random, scan.grid, 6);
        push.sphere_radius_mm = 3;
        ASSERT_TRUE(tissue.push(push).ok());
    }
    Grid own = scan.grid;  // rows reversed
    own.origin_mm = centre(scan.grid, {23, 0, 0});
    own.direction.columns[0] = -1.0 * own.direction.columns[0];
    const Volume labels = random_map(random, own);
    const auto deformed = deform_volume(tissue, Mapping::Cells, true);
    ASSERT_TRUE(deformed.ok());
    const auto moved = deform_labels(tissue, *deformed, labels);
    ASSERT_TRUE(moved.ok()) << moved.error().message;
    const auto warp = Warp::create(tissue);
    ASSERT_TRUE(warp.ok());
    int compared = 0, changed = 0;
    for_all(scan.grid, [&](Vec3i p) {
        const auto source = warp->inverse(centre(scan.grid, p));
        if (!source || is_between(own, *source, 1e-3)) return;
        EXPECT_EQ(int(moved->at(p)), nearest_label(labels, *source));
        ++compared;
        changed += int(moved->at(p)) != nearest_label(labels, centre(scan.grid, p));
    });
    EXPECT_GT(compared, 7500);
    EXPECT_GT(changed, 200);
}

TEST(DeformedLabels, AreGoneWhereTissueIsGone) {
    Random random(12);
    const TaskArena arena(1);
    const Volume scan = turned_noise(random, {24, 20, 17}, {1, 1, 1});
    ChainMail tissue = tissue_of(scan, arena);
    const Vec3i middle{12, 10, 8};
    const Vec3d at = centre(scan.grid, middle);
    ASSERT_TRUE(tissue.carve({.from_mm = at, .to_mm = at, .radius_mm = 3}).ok());
    Volume labels = random_map(random, scan.grid);
    labels.voxels = VoxelArray<std::int16_t>(std::vector<std::int16_t>(voxel_count(scan.grid), 4));
    const auto deformed = deform_volume(tissue, Mapping::Cells, true);
    ASSERT_TRUE(deformed.ok());
    ASSERT_GT(deformed->gap_voxels, 0);
    const auto left = deform_labels(tissue, *deformed, labels);
    ASSERT_TRUE(left.ok());
    for_all(scan.grid, [&](Vec3i p) {
        const double away = norm(centre(scan.grid, p) - at);
        if (away < 2 || away > 5) {
            EXPECT_EQ(left->at(p), away < 2 ? 0 : 4);
        }
    });
    const auto without = deform_volume(tissue);
    ASSERT_TRUE(without.ok());
    EXPECT_EQ(deform_labels(tissue, *without, labels).error().message,
              "deformed: expected a deformation with its inverse, found none");
}

}  // namespace
}  // namespace pliant::test
