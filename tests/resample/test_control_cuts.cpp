// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts of a control lattice, against plain loops in which every triangle is asked about every line.

#include "resample/control_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "support/random.h"
#include "volume/boxes.h"

namespace pliant::test {
namespace {

Position whole(Vec3d voxel) {
    Position p;
    for (int a = 0; a < 3; ++a) p[a] = std::llround(std::ldexp(voxel[a], 20));
    return p;
}

Vec3i corner_at(int c) {
    return {c & 1, c >> 1 & 1, c >> 2};
}

/// A scan, a control lattice on it, and a random blade of a few triangles.
struct Scene {
    Grid scan;
    ControlGrid control;
    std::vector<CutTriangle> triangles_mm;
    std::vector<Triangle> triangles;
    ControlCuts cuts;
    TaskArena arena{1};

    explicit Scene(std::uint64_t seed) {
        Random random(seed);
        scan.size = {40, 40, 40};
        scan.spacing_mm = {0.5, 2, 1};
        scan.origin_mm = {-8, 16, 4};
        for (int a = 0; a < 3; ++a) {
            control.first[a] = random.whole(0, 4);
            control.cell[a] = random.whole(1, 4);
            control.size[a] = random.whole(2, 4);
        }
        const auto inside = [&] {
            Vec3d voxel;
            for (int a = 0; a < 3; ++a) {
                const double wide = control.cell[a] * (control.size[a] - 1);
                voxel[a] = control.first[a] + random.real(-0.3 * wide, 1.3 * wide);
                // On planes of elements, too.
                if (random.whole(0, 3) == 0) voxel[a] = std::round(voxel[a]);
            }
            return voxel;
        };
        Vec3d a = inside(), b = inside();
        for (int n = random.whole(1, 3); n > 0; --n) {
            const Vec3d c = inside();
            triangles.push_back({whole(a), whole(b), whole(c)});
            triangles_mm.push_back(
                {world_from_voxel(scan, a), world_from_voxel(scan, b), world_from_voxel(scan, c)});
            a = b;
            b = c;
        }
        auto made = ControlCuts::create(scan, control, triangles_mm, kBrickSize, arena);
        EXPECT_TRUE(made.ok());
        cuts = std::move(made).value();
    }

    static constexpr int kBrickSize = 5;

    bool crossed(Position p, Position q) const {
        return std::any_of(triangles.begin(), triangles.end(),
                           [&](const Triangle& t) { return crosses(t, p, q); });
    }
    Vec3i voxel_of(Vec3i node) const {
        Vec3i voxel;
        for (int a = 0; a < 3; ++a) voxel[a] = control.first[a] + control.cell[a] * node[a];
        return voxel;
    }
    static Position at(Vec3i voxel) {
        return whole({double(voxel.x), double(voxel.y), double(voxel.z)});
    }
    bool nodes_see(Vec3i p, Vec3i q) const { return !crossed(at(voxel_of(p)), at(voxel_of(q))); }
    int number(Vec3i node) const { return int(dense_index(node, control.size)); }

    /// Nodes beside a node, hidden from it, and connected to one of them: the nearest of these.
    std::vector<std::int32_t> like(Vec3i node, Vec3i one) const {
        std::vector<Vec3i> hidden;
        for_each_in({{-1, -1, -1}, {2, 2, 2}}, [&](Vec3i away) {
            const Vec3i other = node + away;
            if (contains({{0, 0, 0}, control.size}, other) && !nodes_see(node, other))
                hidden.push_back(other);
        });
        std::vector<Vec3i> group{one};
        for (std::size_t n = 0; n < group.size(); ++n)
            for (const Vec3i other : hidden) {
                const Vec3i away = other - group[n];
                if (std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)}) <= 1 &&
                    std::find(group.begin(), group.end(), other) == group.end() &&
                    nodes_see(group[n], other))
                    group.push_back(other);
            }
        const auto steps = [&](Vec3i other) {
            const Vec3i away = other - node;
            return std::abs(away.x) + std::abs(away.y) + std::abs(away.z);
        };
        int fewest = 3;
        for (const Vec3i other : group) fewest = std::min(fewest, steps(other));
        std::vector<std::int32_t> nearest;
        for (const Vec3i other : group)
            if (steps(other) == fewest) nearest.push_back(number(other));
        std::sort(nearest.begin(), nearest.end());
        return nearest;
    }
};

TEST(ControlCuts, ALinkIsCutWhereATriangleCrossesIt) {
    int links = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Scene scene(seed);
        const Box3i box{scene.control.first,
                        scene.voxel_of(scene.control.size - Vec3i{1, 1, 1}) + Vec3i{1, 1, 1}};
        constexpr int kSize = Scene::kBrickSize, kCut[3] = {kCutX, kCutY, kCutZ};
        for (const auto& [brick, edits] : scene.cuts.edits())
            for_each_in({{0, 0, 0}, {kSize, kSize, kSize}}, [&, b = brick, &e = edits](Vec3i p) {
                if (e[dense_index(p, {kSize, kSize, kSize})]) {
                    EXPECT_TRUE(contains(box, kSize * b + p));
                }
            });
        for_each_in(box, [&](Vec3i voxel) {
            int expected = 0;
            for (int a = 0; a < 3; ++a) {
                Vec3i next = voxel;
                ++next[a];
                if (contains(box, next) && scene.crossed(Scene::at(voxel), Scene::at(next)))
                    expected |= kCut[a], ++links;
            }
            const Vec3i brick{voxel.x / kSize, voxel.y / kSize, voxel.z / kSize};
            const auto found = scene.cuts.edits().find(brick);
            const int flags =
                found == scene.cuts.edits().end()
                    ? 0
                    : found->second[dense_index(voxel - kSize * brick, {kSize, kSize, kSize})];
            ASSERT_EQ(flags, expected) << voxel.x << ' ' << voxel.y << ' ' << voxel.z;
        });
    }
    EXPECT_GT(links, 200);
}

TEST(ControlCuts, HiddenCornersAreGhostsThatMoveLikeTheNodesBesideThem) {
    int ghosts = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Scene scene(seed);
        const Vec3i cells = scene.control.size - Vec3i{1, 1, 1};
        const int nodes = int(dense_count(scene.control.size));
        std::set<int> used;
        for_each_in({{0, 0, 0}, cells}, [&](Vec3i cell) {
            for_each_in({{0, 0, 0}, scene.control.cell + Vec3i{1, 1, 1}}, [&](Vec3i at) {
                const Position from = Scene::at(scene.voxel_of(cell) + at);
                bool sees[8];
                for (int c = 0; c < 8; ++c)
                    sees[c] = !scene.crossed(from, Scene::at(scene.voxel_of(cell + corner_at(c))));
                const std::int32_t* follows = scene.cuts.corners(cell, at);
                for (int c = 0; c < 8; ++c) {
                    const Vec3i node = cell + corner_at(c);
                    int beside = -1;  // the nearest corner in sight from which it is hidden
                    for (int d = 0; d < 8 && !sees[c]; ++d)
                        if (sees[d] && !scene.nodes_see(node, cell + corner_at(d)) &&
                            (beside < 0 ||
                             std::popcount(unsigned(c ^ d)) < std::popcount(unsigned(c ^ beside))))
                            beside = d;
                    if (!follows) {
                        ASSERT_TRUE(sees[c]);
                        continue;
                    }
                    if (beside < 0) {
                        ASSERT_EQ(follows[c], scene.number(node));
                        continue;
                    }
                    ASSERT_GE(follows[c], nodes);
                    ASSERT_LT(follows[c], nodes + int(scene.cuts.ghosts().size()));
                    const auto& ghost = scene.cuts.ghosts()[std::size_t(follows[c] - nodes)];
                    ASSERT_EQ(ghost.node, scene.number(node));
                    ASSERT_EQ(ghost.like, scene.like(node, cell + corner_at(beside)));
                    used.insert(follows[c]);
                }
            });
        });
        ghosts += int(used.size());
    }
    EXPECT_GT(ghosts, 100);
}

TEST(ControlCuts, ALineIsCutWhereATriangleCrossesIt) {
    int between = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const Scene scene(seed);
        Random random(seed);
        for (int n = 0; n < 1000; ++n) {
            const Vec3d p{random.real(0, 15), random.real(0, 15), random.real(0, 15)};
            const Vec3d q = p + random.vector(random.whole(0, 1) ? 2 : 12);
            const bool expected = scene.crossed(whole(p), whole(q));
            ASSERT_EQ(scene.cuts.is_between(p, q), expected) << seed;
            between += expected;
        }
    }
    EXPECT_GT(between, 200);
}

TEST(ControlCuts, CornersAreAtMostAHundredThousandVoxelsAway) {
    const TaskArena arena(1);
    const auto takes = [&](double x) {
        const Grid scan{.size = {20, 20, 20}};
        const CutTriangle triangle{Vec3d{0, 0, 0}, {x, 0, 0}, {0, 1, 1}};
        return ControlCuts::create(scan, {}, {&triangle, 1}, 8, arena).ok();
    };
    for (const double sign : {-1.0, 1.0}) {
        EXPECT_TRUE(takes(sign * 1e5));
        EXPECT_FALSE(takes(sign * 1.000001e5));
        EXPECT_FALSE(takes(sign * std::numeric_limits<double>::infinity()));
    }
    EXPECT_FALSE(takes(std::nan("")));
}

}  // namespace
}  // namespace pliant::test
