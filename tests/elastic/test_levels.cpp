// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Equilibrium on nested lattices: forces by Gauss points vanish at free nodes, windows agree with
// one lattice, and states don't depend on the number of threads.
// Covers: elastic/levels.cpp, elastic/level.cpp, elastic/stiffness_map.cpp.

#include <gtest/gtest.h>

#include <limits>

#include "elastic/lattices.h"
#include "elastic/levels.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr int kWhole = 512;

/// Soft tissue with stiffer and void inclusions, held at its sides.
Volume body(Vec3i size, Vec3d spacing_mm, std::uint64_t seed) {
    Random random(seed);
    struct Ball {
        Vec3d centre;
        double radius;
        int value;
    };
    std::vector<Ball> balls;
    for (int n = 0; n < 8; ++n)
        balls.push_back({{random.real(0, size.x), random.real(0, size.y), random.real(0, size.z)},
                         random.real(2, 6),
                         n % 2 ? 0 : random.whole(500, 5000)});
    return scan_of(size, spacing_mm, [&](Vec3i at) {
        int value = 300;
        for (const Ball& ball : balls)
            if (norm(Vec3d{at.x * 1.0, at.y * 1.0, at.z * 1.0} - ball.centre) < ball.radius)
                value = ball.value;
        return value;
    });
}

ElasticScanSettings held_settings(double nu) {
    ElasticScanSettings settings = plain_settings(nu);
    settings.held_sides = {"-x", "+x", "-y", "+y", "-z", "+z"};
    return settings;
}

/// A ball of nodes, displaced.
std::vector<HeldNode> ball(const StiffnessMap& map, Vec3d centre, double radius, Vec3d shift_mm) {
    std::vector<HeldNode> nodes;
    const Vec3i size = map.grid().size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                if (norm(Vec3d{i * 1.0, j * 1.0, k * 1.0} - centre) <= radius)
                    nodes.push_back({{i, j, k}, shift_mm, {}});
    return nodes;
}

void solve(ElasticLevels& levels, int starts, int iterations) {
    for (int n = 0; n < starts; ++n) {
        (void)levels.start();
        for (int k = 0; k < iterations; ++k)
            if (levels.iterate() == 0) break;
    }
}

/// Relative L2 distance of the displacements of all voxels.
double distance(const ElasticLevels& a, const ElasticLevels& b, Vec3i size) {
    double difference = 0, all = 0;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const Vec3d x = displacement(a, {i, j, k}), y = displacement(b, {i, j, k});
                difference += dot(x - y, x - y);
                all += dot(y, y);
            }
    return std::sqrt(difference / all);
}

TEST(Levels, EachIterationReducesTheResidualFourfold) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const double nu = seed % 2 ? 0.45 : 0.2;
        const Vec3d spacing = seed < 4 ? Vec3d{1, 1, 1} : Vec3d{0.7, 0.7, 2};
        const Volume scan = body({29, 26, seed < 4 ? 31 : 12}, spacing, seed);
        const StiffnessMap map(scan, held_settings(nu), arena);
        for (const bool turns : {false, true}) {
            ElasticLevels levels(map, kWhole, turns, arena);
            levels.hold(ball(map, {14, 13, scan.grid.size.z / 2.0}, 3, {0.6, -0.3, 0.8}));
            const double first = levels.start();
            double residual = first;
            for (int n = 0; n < 6; ++n) residual = levels.iterate();
            EXPECT_LT(residual, std::pow(0.25, 6) * first);
        }
    }
}

TEST(Levels, FreeNodesAreInEquilibriumByGaussPoints) {
    const TaskArena arena(1);
    const Volume scan = body({17, 15, 13}, {1, 1.2, 0.9}, 3);
    const double nu = 0.4;
    const StiffnessMap map(scan, held_settings(nu), arena);
    ElasticLevels levels(map, kWhole, false, arena);
    const auto held = ball(map, {8, 7, 6}, 2.5, {0.5, 0.2, -0.4});
    levels.hold(held);
    solve(levels, 2, 12);
    const Vec3i size = scan.grid.size;
    std::vector<Vec3d> forces(voxel_count(scan.grid), Vec3d{0, 0, 0});
    double largest = 0;
    for (int k = 0; k + 1 < size.z; ++k)
        for (int j = 0; j + 1 < size.y; ++j)
            for (int i = 0; i + 1 < size.x; ++i) {
                float mu = 0;
                map.moduli(0, {{i, j, k}, {i + 1, j + 1, k + 1}}, 1, 1, &mu);
                const double lambda =
                    2 * nu / (1 - 2 * nu) * std::max(double(mu - map.void_mu()), 0.0);
                Corners u;
                for (std::size_t c = 0; c < 8; ++c)
                    u[c] = displacement(levels,
                                        {i + int(c & 1), j + int(c >> 1 & 1), k + int(c >> 2)});
                const Corners f = gauss_forces(scan.grid.spacing_mm, lambda, double(mu), u);
                for (std::size_t c = 0; c < 8; ++c) {
                    Vec3d& sum = forces[voxel_index(
                        scan.grid, {i + int(c & 1), j + int(c >> 1 & 1), k + int(c >> 2)})];
                    sum = sum + f[c];
                    largest = std::max(largest, norm(f[c]));
                }
            }
    double tool = 0;
    for (const HeldNode& node : held) tool += norm(forces[voxel_index(scan.grid, node.node)]);
    EXPECT_GT(tool, largest);
    for (int k = 1; k + 1 < size.z; ++k)
        for (int j = 1; j + 1 < size.y; ++j)
            for (int i = 1; i + 1 < size.x; ++i) {
                const Vec3i at{i, j, k};
                const bool is_held =
                    std::any_of(held.begin(), held.end(),
                                [&](const HeldNode& node) { return node.node == at; });
                if (is_held) continue;
                ASSERT_LT(norm(forces[voxel_index(scan.grid, at)]), 2e-4 * largest);
            }
}

TEST(Levels, WindowsAgreeWithOneLattice) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Volume scan = body({57, 54, 50}, {1, 1, 1}, seed);
        const StiffnessMap map(scan, held_settings(0.45), arena);
        ElasticLevels whole(map, kWhole, true, arena), windows(map, 24, true, arena);
        const Vec3d centre{30, 25, 27};
        windows.focus(centre);
        EXPECT_LT(windows.node_count(), whole.node_count() / 4);
        for (ElasticLevels* const levels : {&whole, &windows}) {
            levels->hold(ball(map, centre, 4, {1, -0.5, 1.5}));
            solve(*levels, 4, 6);
        }
        EXPECT_LT(distance(windows, whole, scan.grid.size), 0.08);
        Vec3d a{0, 0, 0}, b{0, 0, 0};
        std::vector<Vec3i> nodes;
        for (const HeldNode& node : ball(map, centre, 4, {})) nodes.push_back(node.node);
        for (const Vec3d f : windows.forces_un(nodes)) a = a + f;
        for (const Vec3d f : whole.forces_un(nodes)) b = b + f;
        EXPECT_LT(norm(a - b), 0.03 * norm(b));
    }
}

TEST(Levels, AThinLayerOfBoneHoldsBeyondTheFinestWindow) {
    const TaskArena arena(2);
    auto settings = plain_settings(0.45);
    settings.held_above_hu = 4999;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        // A closed shell of one voxel around soft tissue, at even and odd places, or a sphere.
        const Vec3i low{random.whole(4, 7), random.whole(4, 7), random.whole(4, 7)};
        const Vec3i high{random.whole(41, 44), random.whole(41, 44), random.whole(41, 44)};
        const double radius = random.real(19, 21);
        const Volume scan = scan_of({49, 49, 49}, {1, 1, 1}, [&](Vec3i at) {
            if (seed > 2) {
                const double r = norm(Vec3d{at.x - 24.0, at.y - 24.0, at.z - 24.0});
                return r >= radius && r < radius + 1 ? 5000 : 300;
            }
            bool is_inside = true, is_on = false;
            for (int a = 0; a < 3; ++a) {
                is_inside = is_inside && at[a] >= low[a] && at[a] <= high[a];
                is_on = is_on || at[a] == low[a] || at[a] == high[a];
            }
            return is_inside && is_on ? 5000 : 300;
        });
        const StiffnessMap map(scan, settings, arena);
        ElasticLevels whole(map, kWhole, true, arena), windows(map, 20, true, arena);
        const Vec3d centre{24, 24, 24};
        windows.focus(centre);
        for (ElasticLevels* const levels : {&whole, &windows}) {
            levels->hold(ball(map, centre, 4, {1, -0.5, 1.5}));
            solve(*levels, 4, 6);
        }
        EXPECT_LT(distance(windows, whole, scan.grid.size), 0.06);
    }
}

TEST(Levels, AMovedWindowKeepsTheDisplacement) {
    const TaskArena arena(1);
    const Volume scan = body({57, 54, 50}, {1, 1, 1}, 2);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, 24, true, arena);
    levels.focus({28, 27, 25});
    levels.hold(ball(map, {28, 27, 25}, 4, {0.5, 0, 1}));
    solve(levels, 3, 4);
    const Box3i before = levels.finest();
    ElasticLevels moved(map, 24, true, arena);
    std::vector<double> state;
    levels.copy_to(state);
    ASSERT_TRUE(moved.copy_from(state));
    EXPECT_EQ(distance(moved, levels, scan.grid.size), 0);
    moved.focus({34, 27, 25});
    EXPECT_NE(moved.finest().begin, before.begin);
    EXPECT_LT(distance(moved, levels, scan.grid.size), 0.08);
}

TEST(Levels, StatesDontDependOnThreads) {
    const Volume scan = body({45, 40, 42}, {1, 1, 1}, 5);
    std::vector<double> first;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        const StiffnessMap map(scan, held_settings(0.45), arena);
        ElasticLevels levels(map, 30, true, arena);
        levels.focus({25, 20, 21});
        levels.hold(ball(map, {25, 20, 21}, 4, {1, 1, 1}));
        solve(levels, 2, 2);
        std::vector<double> state;
        levels.copy_to(state);
        if (first.empty()) first = state;
        EXPECT_EQ(state, first);
    }
}

TEST(Levels, NodesThatSlideStayOnTheirPlanes) {
    const TaskArena arena(1);
    const Volume scan = body({29, 26, 31}, {1, 1, 1}, 4);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, kWhole, false, arena);
    const Vec3d normal{0.6, 0, 0.8};
    auto held = ball(map, {14, 13, 15}, 3, 0.8 * normal);
    for (HeldNode& node : held) node.only_along = normal;
    levels.hold(held);
    const double first = levels.start();
    double residual = first;
    for (int n = 0; n < 8; ++n) residual = levels.iterate();
    EXPECT_LT(residual, 1e-3 * first);
    double across = 0;
    for (const HeldNode& node : held) {
        const Vec3d u = displacement(levels, node.node);
        EXPECT_NEAR(dot(u, normal), 0.8, 1e-5);
        across = std::max(across, norm(u - dot(u, normal) * normal));
    }
    EXPECT_GT(across, 1e-3);
    std::vector<Vec3i> nodes;
    for (const HeldNode& node : held) nodes.push_back(node.node);
    for (const Vec3d f : levels.forces_un(nodes))
        EXPECT_LT(norm(f - dot(f, normal) * normal), 2e-3 * first);
}

TEST(Levels, BoneAndHeldSidesNeverMove) {
    const TaskArena arena(1);
    Volume scan = body({29, 26, 31}, {1, 1, 1}, 6);
    auto settings = held_settings(0.45);
    settings.held_above_hu = 4999;
    settings.held_sides = {"-x"};
    auto* voxels = std::get_if<0>(&scan.voxels);
    for (int n = 0; n < 200; ++n)
        (*voxels)[voxel_index(scan.grid, {20 + n % 3, n / 3 % 9, 10 + n / 27})] = 5000;
    const StiffnessMap map(scan, settings, arena);
    ElasticLevels levels(map, 16, true, arena);
    levels.focus({16, 12, 15});
    levels.hold(ball(map, {14, 12, 15}, 3, {1.5, 0, 0}));
    solve(levels, 3, 4);
    for (int j = 0; j < 26; ++j)
        for (int k = 0; k < 31; ++k) EXPECT_EQ(displacement(levels, {0, j, k}), (Vec3d{0, 0, 0}));
    const Box3i box = levels.finest();
    for (int n = 0; n < 200; ++n) {
        const Vec3i at{20 + n % 3, n / 3 % 9, 10 + n / 27};
        if (!contains(box, at)) continue;
        EXPECT_EQ(displacement(levels, at), (Vec3d{0, 0, 0}));
    }
}

TEST(Levels, AStateOfOtherSizesIsRefused) {
    const TaskArena arena(1);
    const Volume scan = body({29, 26, 31}, {1, 1, 1}, 4);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, 16, true, arena);
    std::vector<double> state;
    levels.copy_to(state);
    auto shorter = state;
    shorter.pop_back();
    EXPECT_FALSE(levels.copy_from(shorter));
    for (const double bad : {-1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
        auto other = state;
        other[0] = bad;
        EXPECT_FALSE(levels.copy_from(other));
    }
    EXPECT_TRUE(levels.copy_from(state));
}

TEST(Levels, TheResidualFallsFourfoldOnCellsThatAreLongAlongAnyAxis) {
    const TaskArena arena(1);
    for (int axis = 0; axis < 3; ++axis) {
        SCOPED_TRACE("axis " + std::to_string(axis));
        Vec3i size{29, 26, 27};
        Vec3d spacing{0.7, 0.7, 0.7};
        size[axis] = 12;
        spacing[axis] = 2;
        const Volume scan = body(size, spacing, 4);
        const StiffnessMap map(scan, held_settings(0.2), arena);
        ElasticLevels levels(map, kWhole, false, arena);
        levels.hold(ball(map, {size.x / 2.0, size.y / 2.0, size.z / 2.0}, 3, {0.6, -0.3, 0.8}));
        const double first = levels.start();
        double residual = first;
        for (int n = 0; n < 6; ++n) residual = levels.iterate();
        EXPECT_LT(residual, std::pow(0.25, 6) * first);
    }
}

TEST(Levels, WindowsLieAroundTheirPlaceAndWithinTheScan) {
    const TaskArena arena(1);
    // 64 cells of the finest level, whose nodes must be at even places; each window has 8 cells.
    const Volume scan = scan_of({65, 65, 65}, {1, 1, 1}, [](Vec3i) { return 300; });
    const StiffnessMap map(scan, plain_settings(0.4), arena);
    ElasticLevels levels(map, 8, true, arena);
    EXPECT_EQ(levels.finest(), (Box3i{{28, 28, 28}, {37, 37, 37}})) << "the scan's middle";
    levels.focus({-50, 100, 32});
    EXPECT_EQ(levels.finest(), (Box3i{{0, 56, 28}, {9, 65, 37}}));
    levels.focus({100, 20, -3});
    EXPECT_EQ(levels.finest(), (Box3i{{56, 16, 0}, {65, 25, 9}}));
    levels.focus({32, 32, 32});
    EXPECT_EQ(levels.finest(), (Box3i{{28, 28, 28}, {37, 37, 37}}));
    // Slices that are four times as far apart are not joined on the first two coarser levels: each
    // window has two cells less along z than the one around it.
    const Volume slices = scan_of({81, 81, 60}, {1, 1, 4}, [](Vec3i) { return 300; });
    const StiffnessMap of_slices(slices, plain_settings(0.4), arena);
    EXPECT_EQ(of_slices.shift(2), (Vec3i{2, 2, 0}));
    const ElasticLevels flat(of_slices, 8, true, arena);
    EXPECT_EQ(flat.finest().end - flat.finest().begin, (Vec3i{9, 9, 5}));
}

TEST(Levels, NewPartsOfAMovedWindowHaveTheCoarserDisplacement) {
    const TaskArena arena(1);
    const Volume scan = body({57, 54, 50}, {1, 1, 1}, 2);
    const StiffnessMap map(scan, plain_settings(0.45), arena);
    for (const Vec3d to : {Vec3d{34, 19, 25}, {22, 33, 21}}) {
        ElasticLevels levels(map, 24, true, arena);
        levels.focus({28, 27, 25});
        levels.hold(ball(map, {28, 27, 25}, 4, {0.5, -0.4, 1}));
        solve(levels, 1, 3);
        (void)levels.start();
        const Box3i before = levels.finest();
        std::vector<Vec3d> old;
        const auto for_each_voxel = [&](const auto& visit) {
            for (int k = 8; k < 40; ++k)
                for (int j = 6; j < 47; ++j)
                    for (int i = 9; i < 48; ++i) visit(Vec3i{i, j, k});
        };
        for_each_voxel([&](Vec3i at) { old.push_back(displacement(levels, at)); });
        levels.focus(to);
        std::size_t n = 0;
        int count = 0;
        for_each_voxel([&](Vec3i at) {
            const Vec3d was = old[n++];
            if (!contains(levels.finest(), at)) return;
            count += !contains(before, at);
            ASSERT_LT(norm(displacement(levels, at) - was), 1e-5)
                << at.x << " " << at.y << " " << at.z;
        });
        EXPECT_GT(count, 1000);
    }
}

TEST(Levels, AStateOfWiderWindowsIsRefused) {
    const TaskArena arena(1);
    const Volume scan = body({57, 54, 50}, {1, 1, 1}, 2);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, 16, true, arena), same(map, 16, true, arena);
    const ElasticLevels wider(map, 24, true, arena);
    std::vector<double> state;
    wider.copy_to(state);
    EXPECT_FALSE(levels.copy_from(state));
    same.focus({20, 20, 20});
    same.copy_to(state);
    EXPECT_TRUE(levels.copy_from(state));
    EXPECT_EQ(levels.finest(), same.finest());
}

TEST(Levels, CellsOfAStateThatTouchLieInTheirWindow) {
    const TaskArena arena(1);
    const Volume scan = body({29, 26, 31}, {1, 1, 1}, 4);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, 16, true, arena);
    std::vector<double> rest;
    levels.copy_to(rest);
    const auto count = std::size_t(map.level_count());
    for (std::size_t n = rest.size() - count; n < rest.size(); ++n) ASSERT_EQ(rest[n], 0);
    const auto takes = [&](Vec3d cell, double u) {
        std::vector<double> state(rest.begin(), rest.end() - std::ptrdiff_t(count));
        state.push_back(1);
        for (int a = 0; a < 3; ++a) state.push_back(cell[a]);
        state.insert(state.end(), 23, 0);
        state.push_back(u);
        state.insert(state.end(), count - 1, 0);
        return levels.copy_from(state);
    };
    const Vec3i nodes = levels.finest().end - levels.finest().begin;
    const Vec3d last{nodes.x - 2.0, nodes.y - 2.0, nodes.z - 2.0};
    EXPECT_TRUE(takes(last, 0));
    EXPECT_TRUE(takes({0, 0, 0}, 500));
    EXPECT_FALSE(takes({0, 0, 0}, 501));
    for (int a = 0; a < 3; ++a) {
        Vec3d beyond = last, before{0, 0, 0};
        beyond[a] += 1;
        before[a] = -1;
        EXPECT_FALSE(takes(beyond, 0));
        EXPECT_FALSE(takes(before, 0));
    }
}

TEST(Levels, GoingBackIsByAPartOfTheDistance) {
    const TaskArena arena(1);
    const Volume scan = body({29, 26, 31}, {1, 1, 1}, 4);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    ElasticLevels levels(map, 16, true, arena);
    std::vector<double> rest;
    levels.copy_to(rest);
    levels.hold(ball(map, {14, 13, 15}, 3, {1.5, 0.25, -0.5}));
    solve(levels, 1, 2);
    const double largest = levels.largest_mm();
    EXPECT_GE(largest, 1.5);
    EXPECT_EQ(levels.go_back(rest, 0), largest);
    EXPECT_EQ(levels.go_back(rest, 0.5), largest);
    EXPECT_NEAR(levels.largest_mm(), largest / 2, 1e-6);
    EXPECT_NEAR(levels.go_back(rest, 1), largest / 2, 1e-6);
    EXPECT_EQ(levels.largest_mm(), 0);
}

TEST(Levels, AResponseIsTheSolutionOfHeldNodesThatMove) {
    const TaskArena arena(2);
    const Vec3i size{33, 33, 33};
    const Volume scan = body(size, {1, 1, 1}, 11);
    const StiffnessMap map(scan, held_settings(0.4), arena);
    const Vec3d centre{16, 16, 16}, shift{0.3, -0.2, 0.1};
    for (const int window : {kWhole, 12}) {
        ElasticLevels levels(map, window, false, arena), solved(map, window, false, arena);
        std::vector<Vec3i> voxels;
        for (const HeldNode& node : ball(map, centre, 3, {})) voxels.push_back(node.node);
        levels.focus(centre);
        levels.hold(ball(map, centre, 3, {0, 0, 0}));
        HeldResponse response;
        levels.find_response(voxels, 30, response);
        ASSERT_TRUE(levels.respond(response, shift));
        solved.focus(centre);
        solved.hold(ball(map, centre, 3, shift));
        solve(solved, 1, 30);
        EXPECT_LT(distance(levels, solved, size), 0.01) << window;
        if (window == kWhole) continue;
        const Vec3d before = displacement(levels, {20, 16, 16});
        levels.focus({4, 16, 16});
        const Vec3d moved = displacement(levels, {20, 16, 16});
        EXPECT_FALSE(levels.respond(response, shift));
        EXPECT_EQ(displacement(levels, {20, 16, 16}), moved);
        EXPECT_GT(norm(before), 0.01);
    }
}

TEST(Levels, NodesThatMoveAlongAnyAxisCount) {
    const TaskArena arena(1);
    const Volume scan = scan_of({17, 17, 17}, {1, 1, 1}, [](Vec3i) { return 1000; });
    const StiffnessMap map(scan, held_settings(0.4), arena);
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d shift{0, 0, 0};
        shift[axis] = -0.5;
        const auto held = ball(map, {8, 8, 8}, 3, shift);
        ElasticLevels levels(map, kWhole, false, arena);
        levels.focus({8, 8, 8});
        levels.hold(held);
        EXPECT_EQ(levels.moved_voxels(0.4), std::int64_t(held.size())) << axis;
        EXPECT_EQ(levels.moved_voxels(0.5), 0) << axis;
    }
}

TEST(Levels, TheMovedBoxReachesTheScansBorders) {
    const TaskArena arena(1);
    const Volume scan = scan_of({17, 17, 17}, {1, 1, 1}, [](Vec3i) { return 1000; });
    const StiffnessMap map(scan, plain_settings(0.4), arena);
    for (const int side : {0, 16}) {
        const Vec3d corner{double(side), double(side), double(side)};
        const auto held = ball(map, corner, 3, {0.5, 0.5, 0.5});
        ElasticLevels levels(map, kWhole, false, arena);
        levels.focus(corner);
        levels.hold(held);
        const Box3i box = levels.moved_box(0.1);
        for (int a = 0; a < 3; ++a) {
            EXPECT_EQ(box.begin[a], side == 0 ? 0 : 13);
            EXPECT_EQ(box.end[a], side == 0 ? 4 : 17);
        }
    }
}

TEST(Levels, VoxelsThatAreNoNodesHaveNoForce) {
    const TaskArena arena(1);
    const Volume scan = scan_of({49, 49, 49}, {1, 1, 1}, [](Vec3i) { return 1000; });
    const StiffnessMap map(scan, held_settings(0.4), arena);
    ElasticLevels levels(map, 12, false, arena);
    levels.focus({24, 24, 24});
    levels.hold(ball(map, {24, 24, 24}, 2, {0.5, 0, 0}));
    solve(levels, 1, 5);
    const Vec3i voxels[] = {{26, 24, 24}, {3, 5, 7}, {45, 24, 24}};
    const auto forces = levels.forces_un(voxels);
    ASSERT_EQ(forces.size(), 3u);
    EXPECT_GT(norm(forces[0]), 0);
    EXPECT_EQ(forces[1], (Vec3d{0, 0, 0}));
    EXPECT_EQ(forces[2], (Vec3d{0, 0, 0}));
}

TEST(Levels, MemoryIsThatOfTheNodes) {
    const TaskArena arena(1);
    const Volume scan = body({57, 54, 50}, {1, 1, 1}, 2);
    const StiffnessMap map(scan, held_settings(0.45), arena);
    const ElasticLevels levels(map, kWhole, true, arena);
    const std::int64_t floats = 32 * levels.node_count();  // without padding
    EXPECT_GT(levels.bytes(), 4 * floats);
    EXPECT_LT(levels.bytes(), 2 * 4 * floats);
}

}  // namespace
}  // namespace pliant::test
