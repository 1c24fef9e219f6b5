// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A warp against plain loops: values, labels, points, the smallest Jacobian.
// Covers: warp/*.cpp.

#include <gtest/gtest.h>
#include <pliant/data/warp.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "resample/random_tissue.h"

namespace pliant::test {
namespace {

std::uint64_t new_seed() {
    const std::uint64_t seed = std::random_device()();
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    return seed;
}

/// A pushed tissue of noise whose limits rule out folds, and its warp.
struct Pushed {
    explicit Pushed(Random& random)
        : scan(turned_noise(random, {24, 20, 17}, {1.0, 1.3, 0.8})),
          tissue(make_tissue(scan, arena)) {
        std::int64_t moved = 0;
        for (int n = 0; n < 4 || moved < 2000; ++n) {
            Push push = random_push(random, scan.grid, 6);
            push.sphere_radius_mm = 3;
            const auto report = tissue.push(push);
            EXPECT_TRUE(report.ok());
            moved = std::max(moved, report->moved_elements);
        }
        auto made = Warp::create(tissue, &deformed);
        EXPECT_TRUE(made.ok());
        warp.emplace(std::move(*made));
    }
    static ChainMail make_tissue(const Volume& scan, const TaskArena& arena) {
        ChainMailSettings settings;
        settings.offset = 0.3;
        settings.bone_threshold_hu = 2000;
        settings.air_enabled = false;
        return std::move(ChainMail::create(scan, settings, arena)).value();
    }

    TaskArena arena{1};
    Volume scan, deformed;
    ChainMail tissue;
    std::optional<Warp> warp;
};

template <class Visit>
void for_each_voxel(const Grid& grid, const Visit& visit) {
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 0; i < grid.size.x; ++i) visit(Vec3i{i, j, k});
}

/// The eight corners around a continuous index with their weights.
template <class Visit>
void for_each_corner(Vec3d at, const Visit& visit) {
    const Vec3d low{std::floor(at.x), std::floor(at.y), std::floor(at.z)};
    for (int n = 0; n < 8; ++n) {
        Vec3i corner;
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            const double f = at[a] - low[a];
            corner[a] = int(low[a]) + (n >> a & 1);
            weight *= n >> a & 1 ? f : 1 - f;
        }
        visit(corner, weight);
    }
}

template <class T>
T value_at(const std::vector<T>& values, const Grid& grid, Vec3i p, T beyond) {
    return contains(voxel_box(grid), p) ? values[voxel_index(grid, p)] : beyond;
}

/// Labels of blocks of three voxels, and a value for each voxel.
std::vector<std::int32_t> random_labels(Random& random, const Grid& grid) {
    std::map<std::array<int, 3>, int> blocks;
    std::vector<std::int32_t> labels;
    for_each_voxel(grid, [&](Vec3i p) {
        const auto [at, is_new] = blocks.try_emplace({p.x / 3, p.y / 3, p.z / 3}, 0);
        if (is_new) at->second = random.whole(1, 4);
        labels.push_back(at->second);
    });
    return labels;
}

TEST(Warp, ImagesAndLabelsAreThoseAtTheInverse) {
    Random random(new_seed());
    for (int n = 0; n < 5; ++n) {
        const Pushed pushed(random);
        const Grid& grid = pushed.scan.grid;
        std::vector<float> image, moved(voxel_count(grid));
        for_each_voxel(grid, [&](Vec3i) { image.push_back(float(random.real(-100, 100))); });
        const auto labels = random_labels(random, grid);
        std::vector<std::int32_t> nearest(labels.size()), majority(labels.size());
        pushed.warp->warp_image<float>(image, moved, -7.f);
        pushed.warp->warp_labels<std::int32_t>(labels, nearest, LabelSampling::Nearest, 9);
        pushed.warp->warp_labels<std::int32_t>(labels, majority, LabelSampling::Majority, 9);
        const auto inverse = pushed.warp->inverse_field();
        ASSERT_TRUE(inverse.ok());
        int compared = 0;
        for_each_voxel(grid, [&](Vec3i p) {
            const std::size_t at = voxel_index(grid, p);
            const Vec3f back = inverse->vectors_mm[at];
            const Vec3d from = voxel_from_world(
                grid, world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)}) +
                          Vec3d{back.x, back.y, back.z});
            double value = 0;
            std::map<int, double> weights;
            for_each_corner(from, [&](Vec3i corner, double weight) {
                value += weight * value_at(image, grid, corner, -7.f);
                weights[value_at(labels, grid, corner, 9)] += weight;
            });
            EXPECT_NEAR(moved[at], value, 2e-3);
            double most = 0, second = 0;
            for (const auto& [label, weight] : weights)
                if (weight > most)
                    second = std::exchange(most, weight);
                else
                    second = std::max(second, weight);
            if (most - second > 1e-4) {
                EXPECT_NEAR(weights[majority[at]], most, 1e-9);
                ++compared;
            }
            const Vec3i near{int(std::lround(from.x)), int(std::lround(from.y)),
                             int(std::lround(from.z))};
            const bool is_clear = std::abs(from.x - near.x) < 0.499 &&
                                  std::abs(from.y - near.y) < 0.499 &&
                                  std::abs(from.z - near.z) < 0.499;
            if (is_clear) {
                EXPECT_EQ(nearest[at], value_at(labels, grid, near, 9));
            }
        });
        EXPECT_GT(compared, 1000);
    }
}

TEST(Warp, TheScanItselfIsThatOfTheTissue) {
    Random random(new_seed());
    const Pushed pushed(random);
    const auto& scan = *std::get_if<0>(&pushed.scan.voxels);
    const auto& deformed = *std::get_if<0>(&pushed.deformed.voxels);
    std::vector<std::int16_t> moved(scan.size());
    pushed.warp->warp_image<std::int16_t>({scan.data(), scan.size()}, moved,
                                          std::int16_t(pushed.scan.background));
    int changed = 0;
    for (std::size_t n = 0; n < moved.size(); ++n) {
        EXPECT_NEAR(moved[n], deformed[n], 1);
        changed += scan[n] != deformed[n];
    }
    EXPECT_GT(changed, 300);
}

TEST(Warp, PointsGoThereAndBack) {
    Random random(new_seed());
    for (int n = 0; n < 5; ++n) {
        const Pushed pushed(random);
        const Grid& grid = pushed.scan.grid;
        double farthest = 0;
        for (int p = 0; p < 200; ++p) {
            const Vec3d point = world_from_voxel(
                grid, {random.real(-3, 26), random.real(-3, 22), random.real(-3, 19)});
            const Vec3d ijk = voxel_from_world(grid, point);
            Vec3d expected = point;
            for_each_corner(ijk, [&](Vec3i corner, double weight) {
                expected = expected + weight * pushed.tissue.displacement_mm(corner);
            });
            const Vec3d moved = pushed.warp->forward(point);
            EXPECT_LT(norm(moved - expected), 1e-9);
            const auto back = pushed.warp->inverse(moved);
            ASSERT_TRUE(back);
            EXPECT_LT(norm(*back - point), 1e-8);
            farthest = std::max(farthest, norm(moved - point));
        }
        EXPECT_GT(farthest, 0.05);
    }
}

TEST(Warp, TheWayBackIsTheForwardField) {
    Random random(new_seed());
    const Pushed pushed(random);
    const Grid& grid = pushed.scan.grid;
    // A linear image has its own value at φ(X).
    std::vector<double> image, back(voxel_count(grid));
    for_each_voxel(grid, [&](Vec3i p) { image.push_back(p.x + 2 * p.y - 3 * p.z); });
    pushed.warp->unwarp_image<double>(image, back, 1e9);
    const auto forward = pushed.warp->forward_field();
    ASSERT_TRUE(forward.ok());
    int inside = 0;
    for_each_voxel(grid, [&](Vec3i p) {
        const std::size_t at = voxel_index(grid, p);
        const Vec3f u = forward->vectors_mm[at];
        const Vec3d to =
            voxel_from_world(grid, world_from_voxel(grid, {double(p.x), double(p.y), double(p.z)}) +
                                       Vec3d{u.x, u.y, u.z});
        for (int a = 0; a < 3; ++a)
            if (to[a] < 0 || to[a] > grid.size[a] - 1) return;
        EXPECT_NEAR(back[at], to.x + 2 * to.y - 3 * to.z, 1e-4);
        ++inside;
    });
    EXPECT_GT(inside, 1000);
}

TEST(Warp, TheSmallestJacobianIsThatOfAllCorners) {
    Random random(new_seed());
    for (int n = 0; n < 5; ++n) {
        const Pushed pushed(random);
        const Grid& grid = pushed.scan.grid;
        const Box3i box = pushed.warp->state().box;
        double smallest = 1;
        for (int k = box.begin.z - 1; k < box.end.z; ++k)
            for (int j = box.begin.y - 1; j < box.end.y; ++j)
                for (int i = box.begin.x - 1; i < box.end.x; ++i)
                    for (int corner = 0; corner < 8; ++corner) {
                        Mat3d gradient = kIdentity3;
                        for (int b = 0; b < 3; ++b) {
                            Vec3i low{i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)};
                            low[b] = Vec3i{i, j, k}[b];
                            Vec3i high = low;
                            ++high[b];
                            const Vec3d step = pushed.warp->displacement_mm(high) -
                                               pushed.warp->displacement_mm(low);
                            auto& column = gradient.columns[std::size_t(b)];
                            column = column + (1 / grid.spacing_mm[b]) * step;
                        }
                        smallest = std::min(smallest, determinant(gradient));
                    }
        EXPECT_NEAR(pushed.warp->smallest_jacobian(), smallest, 1e-5);
        EXPECT_LT(smallest, 0.9);
        EXPECT_GE(smallest, 1 - 3 * 0.3);
    }
}

TEST(Warp, AStateGivesTheSameBits) {
    Random random(new_seed());
    const Pushed pushed(random);
    const auto again = Warp::create(pushed.warp->state(), pushed.arena);
    ASSERT_TRUE(again.ok()) << again.error().message;
    const auto labels = random_labels(random, pushed.scan.grid);
    std::vector<std::int32_t> first(labels.size()), second(labels.size());
    pushed.warp->warp_labels<std::int32_t>(labels, first, LabelSampling::Majority, 0);
    again->warp_labels<std::int32_t>(labels, second, LabelSampling::Majority, 0);
    EXPECT_EQ(first, second);
    EXPECT_NE(first, labels);
    EXPECT_EQ(pushed.warp->state().units, again->state().units);
    EXPECT_EQ(pushed.warp->inverse_field()->vectors_mm, again->inverse_field()->vectors_mm);
    EXPECT_EQ(again->moved_elements(), pushed.tissue.state().moved_elements);
}

TEST(Warp, IntegersAreRoundedAndKeptInTheirRange) {
    const TaskArena arena(1);
    const Grid grid{{4, 2, 2}, {1, 1, 1}, {0, 0, 0}, kIdentity3};
    WarpState state{grid, {{1, 0, 0}, {2, 2, 2}}, std::vector<std::int32_t>(12, 0)};
    for (std::size_t n = 0; n < 4; ++n) state.units[n] = 1 << 18;  // a quarter of a voxel along i
    const auto warp = Warp::create(state, arena);
    ASSERT_TRUE(warp.ok());
    const std::vector<std::uint8_t> image(16, 255);
    std::vector<std::uint8_t> moved(16);
    warp->warp_image<std::uint8_t>(image, moved, 0);
    EXPECT_EQ(moved, image);
    EXPECT_NEAR(warp->forward({1, 0.5, 0.5}).x, 1.25, 1e-12);
}

TEST(Warp, CutTissueAndOtherStatesAreRefused) {
    Random random(new_seed());
    Pushed pushed(random);
    const Vec3d middle = world_from_voxel(pushed.scan.grid, {12, 10, 8});
    ASSERT_TRUE(
        pushed.tissue.cut({.line_mm = {middle, middle + Vec3d{4, 0, 0}}, .depth_mm = {0, 4, 0}})
            .ok());
    const auto cut = Warp::create(pushed.tissue);
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.error().code, ErrorCode::InvalidArgument);
    WarpState state = pushed.warp->state();
    state.units.pop_back();
    EXPECT_FALSE(Warp::create(state, pushed.arena).ok());
}

}  // namespace
}  // namespace pliant::test
