// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Lumens and walls while memory is short: an error for each allocation that fails.
// Covers: vessel/region.cpp, vessel/surface.cpp.

#include <pliant/models/vessel.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/each_allocation_of.h"
#include "support/made.h"

namespace pliant::test {
namespace {

const Centreline kShort{.branches = {{{{0, 0, 0}, 4}, {{0, 0, 12}, 4}}}};
const WallSettings kCoarse{.thickness_mm = 3};
constexpr EachAllocation kSome{.all_up_to = 30, .of_the_rest = 30};

/// A pipe of 200 in 0, along the first axis.
Volume pipe() {
    Volume v;
    v.grid.size = {14, 20, 20};
    VoxelArray<float> values(voxel_count(v.grid));
    for (int k = 0; k < 20; ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 0; i < 14; ++i)
                values.data()[voxel_index(v.grid, {i, j, k})] =
                    std::hypot(j - 9.5, k - 9.5) < 5 ? 200.0F : 0.0F;
    v.voxels = std::move(values);
    return v;
}

void tell(const char* name, const Failures& f) {
    std::printf("%s: %lld allocations, %d failed\n", name, static_cast<long long>(f.allocations),
                f.failed);
}

TEST(VesselOutOfMemory, EachAllocationOfAWallIsAnError) {
    const TaskArena one(1), two(2);
    tell("swept tube", fail_each_allocation_of(
                           [&] { return swept_tube(kShort.branches[0], {.sectors = 8}); }, kSome));
    tell("wall around a centreline",
         fail_each_allocation_of([&] { return wall_around_centreline(kShort, kCoarse, one); },
                                 kSome));
    tell("with two threads",
         fail_each_allocation_of([&] { return wall_around_centreline(kShort, kCoarse, two); },
                                 kSome));
    const VesselWall wall = made(wall_around_centreline(kShort, kCoarse, one));
    tell("check of a wall", fail_each_allocation_of([&] { return check_wall(wall); }, kSome));
    TriangleMesh lumen = wall.ghost;
    for (auto& t : lumen.cells) std::swap(t[1], t[2]);
    tell("wall around a surface", fail_each_allocation_of(
                                      [&]() -> Result<VesselWall> {
                                          // The copy is the caller's.
                                          TriangleMesh mine;
                                          try {
                                              mine = lumen;
                                          } catch (const std::bad_alloc&) {
                                              return Error{ErrorCode::LimitExceeded, ""};
                                          }
                                          return wall_around_surface(std::move(mine), {}, kCoarse,
                                                                     one);
                                      },
                                      kSome));
}

TEST(VesselOutOfMemory, EachAllocationOfALumenIsAnError) {
    const TaskArena arena(1);
    const Volume scan = pipe();
    const RegionSettings region{.seed_mm = {7, 9.5, 9.5}, .low = 100, .high = 300};
    tell("region",
         fail_each_allocation_of([&] { return lumen_of_region(scan, region, arena); }, kSome));
    const int labels[] = {200};
    tell("labels",
         fail_each_allocation_of([&] { return lumen_of_labels(scan, labels, 0.8, arena); }, kSome));
    MeshData line;
    line.nodes_mm = {{0, 0, 0}, {0, 0, 10}, {0, 0, 20}};
    line.lines = {{0, 1, 2}};
    line.node_fields.push_back({.name = "Radius", .components = 1, .values = {4, 4, 4}});
    tell("centreline", fail_each_allocation_of([&] { return centreline_of(line); }, kSome));
}

}  // namespace
}  // namespace pliant::test
