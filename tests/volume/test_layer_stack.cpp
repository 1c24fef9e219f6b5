// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sampling of shapes: the share of a voxel that a shape fills, against sums over many points.

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"
#include "volume/layer_stack.h"
#include "volume/phantom_noise.h"

namespace pliant::phantom {
namespace {

std::vector<std::int16_t> sample(const LayerStack& stack, const Grid& grid) {
    std::vector<std::int16_t> voxels(voxel_count(grid));
    sample_layers(stack, grid, TaskArena(1), {}, voxels);
    return voxels;
}

/// Share of the box around x where the shape is, by a lattice of 24³ points.
double counted_share(const ScalarField& shape, const Grid& grid, Vec3d x, double width_voxels) {
    constexpr int kPoints = 24;
    int inside = 0;
    for (int n = 0; n < kPoints * kPoints * kPoints; ++n) {
        const Vec3i at{n % kPoints, n / kPoints % kPoints, n / kPoints / kPoints};
        Vec3d offset;
        for (int a = 0; a < 3; ++a)
            offset[a] = width_voxels * grid.spacing_mm[a] * ((at[a] + 0.5) / kPoints - 0.5);
        if (shape(x + world_from_lattice_vector(grid, offset)) < 0) ++inside;
    }
    return inside / double(kPoints * kPoints * kPoints);
}

TEST(LayerStack, APlanesShareOfACubeIsTheCountedOne) {
    constexpr std::uint64_t kSeed = 1;
    test::Random random(kSeed);
    for (int n = 0; n < 60; ++n) {
        const Vec3d gradient = random.vector(1);
        const double value = random.real(-0.8, 0.8);
        const ScalarField plane = [=](Vec3d p) { return value + dot(gradient, p); };
        const double counted = counted_share(plane, Grid{}, {0, 0, 0}, 1);
        EXPECT_NEAR(plane_share(value, gradient), counted, 0.01) << "seed " << kSeed << " " << n;
    }
    EXPECT_EQ(plane_share(1, {0, 0, 0}), 0);
    EXPECT_EQ(plane_share(-1, {0, 0, 0}), 1);
    EXPECT_NEAR(plane_share(0.25, {1, 0, 0}), 0.25, 1e-3);
}

TEST(LayerStack, AnObliquePlaneGivesEachVoxelItsShare) {
    constexpr std::uint64_t kSeed = 2;
    test::Random random(kSeed);
    for (int n = 0; n < 4; ++n) {
        const Vec3d normal = normalized(random.vector(1));
        const ScalarField plane = [=](Vec3d p) { return dot(normal, p) - 0.3; };
        LayerStack stack;
        stack.footprint_voxels = n < 2 ? 1 : 2;
        stack.add(plane, uniform(1000));
        Grid grid{{9, 9, 9}, {0.7, 1.3, 2.1}, {0, 0, 0}, random.rotation(n % 2 == 1)};
        grid.origin_mm = -(grid.direction * Vec3d{2.8, 5.2, 8.4});
        const auto voxels = sample(stack, grid);
        for (int k = 0; k < 9; k += 2)
            for (int j = 0; j < 9; j += 2)
                for (int i = 0; i < 9; i += 2) {
                    const Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                    const double share = counted_share(plane, grid, x, stack.footprint_voxels);
                    EXPECT_NEAR(voxels[voxel_index(grid, {i, j, k})], kAirHu + 2000 * share, 25)
                        << "seed " << kSeed << ", plane " << n;
                }
    }
}

TEST(LayerStack, ThinSheetsKeepTheirWeight) {
    for (const double thickness_mm : {0.5, 0.8, 1.2, 2.5}) {
        LayerStack stack;
        stack.add([=](Vec3d p) { return std::abs(p.x - 0.13) - 0.5 * thickness_mm; },
                  uniform(1000));
        const Grid grid{{16, 4, 4}, {1, 1, 1}, {-7.5, -1.5, -1.5}, kIdentity3};
        const auto voxels = sample(stack, grid);
        double weight = 0;
        for (int i = 0; i < 16; ++i)
            weight += (voxels[voxel_index(grid, {i, 2, 2})] - kAirHu) / 2000.0;
        EXPECT_NEAR(weight, thickness_mm, 0.15 * thickness_mm) << thickness_mm << " mm";
    }
}

TEST(LayerStack, TheIsoSurfaceOfAPlaneEdgeIsWhereThePlaneIs) {
    LayerStack stack;
    const Vec3d normal = normalized({1, 0.07, 0.11});
    stack.add([=](Vec3d p) { return -dot(normal, p); }, uniform(0));
    const Grid grid{{24, 24, 24}, {1, 1, 1}, {-11.5, -11.5, -11.5}, kIdentity3};
    const auto voxels = sample(stack, grid);
    for (int k = 0; k < 24; ++k)
        for (int j = 0; j < 24; ++j)
            for (int i = 0; i + 1 < 24; ++i) {
                const double a = voxels[voxel_index(grid, {i, j, k})];
                const double b = voxels[voxel_index(grid, {i + 1, j, k})];
                if ((a < -500) == (b < -500)) continue;
                Vec3d x = world_from_voxel(grid, {double(i), double(j), double(k)});
                x.x += (-500 - a) / (b - a);
                EXPECT_NEAR(dot(normal, x), 0, 0.01);
            }
}

TEST(LayerStack, LaterLayersCoverEarlierOnes) {
    LayerStack stack;
    stack.add([](Vec3d p) { return sphere(p, {0, 0, 0}, 9); }, uniform(40));
    stack.add([](Vec3d p) { return sphere(p, {0, 0, 0}, 5); }, uniform(700));
    const Grid grid{{41, 41, 41}, {0.5, 0.5, 0.5}, {-10, -10, -10}, kIdentity3};
    const auto voxels = sample(stack, grid);
    for (std::size_t n = 0; n < voxels.size(); ++n) {
        const Vec3i at{int(n % 41), int(n / 41 % 41), int(n / 41 / 41)};
        const double r = norm(world_from_voxel(grid, {double(at.x), double(at.y), double(at.z)}));
        if (r < 4) {
            EXPECT_EQ(voxels[n], 700);
        } else if (r > 6 && r < 8) {
            EXPECT_EQ(voxels[n], 40);
        } else if (r > 10) {
            EXPECT_EQ(voxels[n], kAirHu);
        }
    }
}

/// A point between a and b where the sign changes. @pre it does
Vec3d surface_between(const ScalarField& distance, Vec3d a, Vec3d b) {
    const bool inside = distance(a) < 0;
    for (int n = 0; n < 40; ++n) {
        const Vec3d middle = 0.5 * (a + b);
        ((distance(middle) < 0) == inside ? a : b) = middle;
    }
    return a;
}

TEST(LayerStack, NoSurfaceIsNearerThanItsDistanceSays) {
    constexpr std::uint64_t kSeed = 5;
    test::Random random(kSeed);
    const std::pair<const char*, Model> models[] = {
        {"cube", make_cube_model()},     {"layers", make_layers_model()},
        {"airway", make_airway_model()}, {"sinus", make_sinus_model()},
        {"vessel", make_vessel_model()}, {"knee", make_knee_model()}};
    for (const auto& [name, model] : models) {
        std::size_t number = 0, found = 0;
        for (const Layer& layer : model.stack.layers) {
            double steepest = 0;
            for (int n = 0; n < 1500; ++n) {
                const Vec3d a = random.vector(0.5 * model.extent_mm.x);
                const Vec3d b = a + random.vector(random.ratio(0.5, 30));
                const double da = layer.distance(a), db = layer.distance(b);
                if ((da < 0) == (db < 0)) continue;
                const Vec3d surface = surface_between(layer.distance, a, b);
                ++found;
                for (const auto& [d, x] : {std::pair{da, a}, std::pair{db, b}})
                    if (norm(x - surface) > 1e-6)
                        steepest = std::max(steepest, std::abs(d) / norm(x - surface));
            }
            EXPECT_LE(steepest, layer.slope * 1.01)
                << name << ", layer " << number << ", seed " << kSeed;
            ++number;
        }
        EXPECT_GT(found, 50u) << name;
    }
}

}  // namespace
}  // namespace pliant::phantom
