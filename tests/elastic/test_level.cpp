// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One window of a lattice: folded cells by determinants, what smoothing does to them, and the
// blocks of nodes that slide.
// Covers: elastic/level.cpp, elastic/level.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "elastic/lattices.h"
#include "elastic/level.h"
#include "support/random.h"

namespace pliant::test {
namespace {

class Window {
  public:
    Window(Vec3i size, Vec3d spacing_mm, std::uint64_t seed,
           const ElasticScanSettings& settings = plain_settings(0.4))
        : m_random(seed) {
        m_scan = scan_of(size, spacing_mm, [&](Vec3i) { return m_random.whole(1000, 3000); });
        m_map.emplace(m_scan, settings, m_arena);
        m_level.emplace(*m_map, 0, Vec3i{0, 0, 0}, m_map->cells(0) + Vec3i{1, 1, 1}, m_arena);
    }
    ElasticLevel& level() { return *m_level; }
    const StiffnessMap& map() const { return *m_map; }
    Random& random() { return m_random; }

    Vec3d displacement(Vec3i node) const {
        const std::size_t at = m_level->index(node);
        return {m_level->u[0][at], m_level->u[1][at], m_level->u[2][at]};
    }
    void set(Vec3i node, Vec3d u) {
        for (int a = 0; a < 3; ++a) m_level->u[std::size_t(a)][m_level->index(node)] = float(u[a]);
    }
    /// The smallest determinant of the deformation gradient at a corner of a cell.
    double least_determinant(Vec3i cell) const {
        double least = HUGE_VAL;
        for (int c = 0; c < 8; ++c) {
            Mat3d gradient = kIdentity3;
            for (int b = 0; b < 3; ++b) {
                Vec3i low = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}, high = low;
                low[b] = cell[b];
                high[b] = cell[b] + 1;
                gradient.columns[b] =
                    gradient.columns[b] +
                    (1 / m_scan.grid.spacing_mm[b]) * (displacement(high) - displacement(low));
            }
            least = std::min(least, determinant(gradient));
        }
        return least;
    }

  private:
    Random m_random;
    TaskArena m_arena{1};
    Volume m_scan;
    std::optional<StiffnessMap> m_map;
    std::optional<ElasticLevel> m_level;
};

TEST(Level, CellsAreFoldedByTheirDeterminants) {
    constexpr double kLimit = 0.15;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Vec3i size = seed % 2 ? Vec3i{12, 7, 6} : Vec3i{140, 4, 5};
        const Vec3d spacing{0.8, 1.1, 1.7};
        Window window(size, spacing, seed);
        ElasticLevel& level = window.level();
        level.covered = {{2, 1, 1}, {5, 3, 4}};
        const double most = 0.25 + 0.05 * double(seed);
        level.for_each_node([&](Vec3i node, std::size_t) {
            Vec3d u = window.random().vector(1);
            for (int a = 0; a < 3; ++a) u[a] *= most * spacing[a];
            window.set(node, u);
        });
        int folded = 0;
        for (int k = 0; k + 1 < size.z; ++k) {
            std::vector<Vec3i> found, expected;
            EXPECT_EQ(level.has_folded(k, float(kLimit), &found),
                      level.has_folded(k, float(kLimit), nullptr));
            for (int j = 0; j + 1 < size.y; ++j)
                for (int i = 0; i + 1 < size.x; ++i) {
                    const Vec3i cell{i, j, k};
                    if (!contains(level.covered, cell) && window.least_determinant(cell) < kLimit)
                        expected.push_back(cell);
                }
            EXPECT_EQ(found, expected);
            folded += int(found.size());
        }
        EXPECT_GT(folded, 0);
    }
}

TEST(Level, ANodeLiesInTheMeanOfItsParents) {
    const TaskArena arena(1);
    for (const Vec3d spacing_mm : {Vec3d{1, 1, 1}, Vec3d{1, 1, 3}}) {
        const Volume scan = scan_of({17, 19, 21}, spacing_mm, [](Vec3i) { return 1000; });
        const StiffnessMap map(scan, plain_settings(0.4), arena);
        const ElasticLevel fine(map, 0, {1, 2, 3}, {9, 8, 7}, arena);
        const ElasticLevel coarse(map, 1, {0, 0, 0}, map.cells(1) + Vec3i{1, 1, 1}, arena);
        std::map<std::size_t, Vec3i> at_index;
        for (int n = 0; n < coarse.nodes.x * coarse.nodes.y * coarse.nodes.z; ++n) {
            const Vec3i local{n % coarse.nodes.x, n / coarse.nodes.x % coarse.nodes.y,
                              n / coarse.nodes.x / coarse.nodes.y};
            at_index[coarse.index(local)] = local;
        }
        for (int n = 0; n < fine.nodes.x * fine.nodes.y * fine.nodes.z; ++n) {
            const Vec3i local{n % fine.nodes.x, n / fine.nodes.x % fine.nodes.y,
                              n / fine.nodes.x / fine.nodes.y};
            double weights = 0;
            int first_ones = 0;
            Vec3d mean{0, 0, 0};
            std::set<std::size_t> parents;
            coarse.with_parents(fine, local, [&](std::size_t at, float weight, bool is_first) {
                ASSERT_TRUE(at_index.contains(at));
                parents.insert(at);
                weights += double(weight);
                first_ones += is_first;
                for (int a = 0; a < 3; ++a)
                    mean[a] += double(weight) * ((coarse.first[a] + at_index[at][a])
                                                 << (coarse.shift[a] - fine.shift[a]));
            });
            EXPECT_EQ(weights, 1);
            EXPECT_EQ(first_ones, 1);
            const auto count = double(parents.size());
            EXPECT_EQ(count, std::exp2(std::round(std::log2(count))));
            for (int a = 0; a < 3; ++a) EXPECT_EQ(mean[a], fine.first[a] + local[a]);
        }
    }
}

TEST(Level, AFoldedCellsNodesGoHalfwayToTheMeanOfTheirNeighbours) {
    for (int axis = 0; axis < 3; ++axis)
        for (const double away : {1.2, -1.2}) {
            Window window({9, 9, 9}, {1, 1, 1}, 1);
            ElasticLevel& level = window.level();
            const Vec3i centre{4, 4, 4};
            Vec3d u{0, 0, 0};
            u[axis] = away;
            window.set(centre, u);
            ASSERT_TRUE(level.untangle(window.map(), 0.1F));
            level.for_each_node([&](Vec3i node, std::size_t) {
                // The node itself has neighbours at rest, and is one of six of each of them.
                const Vec3i d = node - centre;
                const int steps = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
                // Folded are the cells before the node along the axis in which it went.
                const bool moves =
                    steps == 0 || (steps == 1 && (d[axis] == 0 || d[axis] * away > 0));
                const double expected = !moves ? 0 : steps == 0 ? away / 2 : away / 12;
                for (int a = 0; a < 3; ++a)
                    ASSERT_NEAR(window.displacement(node)[a], a == axis ? expected : 0, 1e-6)
                        << node.x << " " << node.y << " " << node.z;
            });
        }
}

TEST(Level, FarMovedNodesAreUntangledByMoreOfTheirNeighbours) {
    Window window({21, 21, 21}, {1, 1, 1}, 1);
    ElasticLevel& level = window.level();
    level.for_each_node([&](Vec3i node, std::size_t) {
        if (node.x == 10 && node.y == 10 && node.z > 5 && node.z < 15)
            window.set(node, {0, 0, node.z < 10 ? 9.0 : -9.0});
    });
    EXPECT_TRUE(level.untangle(window.map(), 0.1F));
    for (int k = 0; k < 20; ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 0; i < 20; ++i) ASSERT_GT(window.least_determinant({i, j, k}), 0.0999);
}

TEST(Level, CellsAtEachSideOfTheWindowAreUntangled) {
    for (int side = 0; side < 6; ++side) {
        Window window({7, 7, 7}, {1, 1, 1}, 1);
        ElasticLevel& level = window.level();
        Vec3i corner{3, 3, 3};
        Vec3d into{0, 0, 0};
        corner[side / 2] = side % 2 ? 0 : 6;
        into[side / 2] = side % 2 ? 1.5 : -1.5;
        window.set(corner, into);
        ASSERT_TRUE(level.untangle(window.map(), 0.1F));
        for (int n = 0; n < 216; ++n)
            ASSERT_GT(window.least_determinant({n % 6, n / 6 % 6, n / 36}), 0.0999) << side;
    }
}

TEST(Level, NodesThatNeverMoveCanKeepACellFolded) {
    auto settings = plain_settings(0.4);
    settings.held_sides = {"-x"};
    Window window({7, 7, 7}, {1, 1, 1}, 1, settings);
    ElasticLevel& level = window.level();
    window.set({0, 3, 3}, {0, 1.5, 0});  // beyond its neighbour, which is held as well
    EXPECT_FALSE(level.untangle(window.map(), 0.1F));
    EXPECT_EQ(window.displacement({0, 3, 3}), (Vec3d{0, 1.5, 0}));
}

TEST(Level, ABlockOfANodeThatSlidesIsTheInverseAcrossItsDirection) {
    Window window({8, 8, 8}, {1, 1.3, 0.7}, 3);
    ElasticLevel& level = window.level();
    const auto block = [&](std::size_t at) {
        std::array<double, 6> m;
        for (std::size_t n = 0; n < 6; ++n) m[n] = double(level.block[n][at]);
        return Mat3d{{Vec3d{m[0], m[1], m[2]}, Vec3d{m[1], m[3], m[4]}, Vec3d{m[2], m[4], m[5]}}};
    };
    for (int turn = 0; turn < 20; ++turn) {
        const Vec3i node{window.random().whole(0, 7), window.random().whole(0, 7),
                         window.random().whole(0, 7)};
        const Vec3d normal = normalized(window.random().vector(1));
        const std::size_t at = level.index(node);
        const Mat3d stiffness = inverse(block(at));
        level.hold(window.map(), {node, {0, 0, 0}, normal});
        const Mat3d across = block(at);
        const double size = norm(inverse(stiffness) * Vec3d{1, 1, 1});
        EXPECT_LT(norm(across * normal), 1e-5 * size);
        // P M P D v = v for v across the normal.
        const Vec3d v = normalized(cross(normal, window.random().vector(1)));
        const Vec3d forces = stiffness * (across * v);
        EXPECT_LT(norm(forces - dot(forces, normal) * normal - v), 1e-4);
        level.let_go(window.map());
        EXPECT_LT(norm(block(at) * v - inverse(stiffness) * v), 1e-5 * size);
    }
}

}  // namespace
}  // namespace pliant::test
