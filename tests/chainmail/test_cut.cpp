// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cutting and carving: the correct links are cut, no motion crosses a gap, and solvers respect it.
// Covers: chainmail/cut.cpp, chainmail/carve.cpp, field/element_edits.cpp, field/brick_search.cpp.

#include "chainmail/chainmail_impl.h"

#include <gtest/gtest.h>

#include <queue>
#include <set>

#include "chainmail/oracle.h"
#include "chainmail/tissues.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kCutSeed = 20260301;

ChainMail bounded_tissue(const Volume& volume, const TaskArena& arena) {
    ChainMailSettings settings;
    settings.bounded = true;
    settings.smallest_bone_mm3 = 0;
    return tissue_of(volume, arena, settings);
}

Vec3d present_mm(const ChainMail& tissue, Vec3i e) {
    return world_from_voxel(tissue.volume().grid, {double(e.x), double(e.y), double(e.z)}) +
           tissue.displacement_mm(e);
}

/// Number of the connected part of each element of the scan; −1: void.
std::vector<int> parts(const ChainMail& tissue, int& count) {
    const Grid& grid = tissue.volume().grid;
    const Lattice& lattice = lattice_of(tissue);
    std::vector<int> part(voxel_count(grid), -1);
    count = 0;
    for_each_element(grid, [&](Vec3i seed) {
        if (part[voxel_index(grid, seed)] >= 0 || lattice.is_void(seed)) return;
        std::queue<Vec3i> open;
        part[voxel_index(grid, seed)] = count;
        for (open.push(seed); !open.empty(); open.pop())
            for (int side = 0; side < 6; ++side) {
                const Vec3i e = open.front();
                Vec3i to = e;
                to[side / 2] += side % 2 ? 1 : -1;
                if (!contains(voxel_box(grid), to)) continue;
                if (!lattice.is_linked(side % 2 ? e : to, side / 2)) continue;
                int& there = part[voxel_index(grid, to)];
                if (there >= 0) continue;
                there = count;
                open.push(to);
            }
        ++count;
    });
    return part;
}

/// A blade much larger than the scan.
CutSurface plane_through(Vec3d point, Vec3d across, Vec3d deep) {
    return {{point - 300.0 * across - 300.0 * deep, point + 300.0 * across - 300.0 * deep},
            600.0 * deep};
}

/// Counts uncut links across the plane and cut links beside it, and parts with elements on both
/// sides. Elements on the plane belong to either side.
void expect_parted(const ChainMail& tissue, Vec3d point, Vec3d normal) {
    const Grid& grid = tissue.volume().grid;
    const auto side = [&](Vec3i e) {
        const double away = dot(normal, present_mm(tissue, e) - point);
        return std::abs(away) < 1e-5 ? 0 : away > 0 ? 1 : -1;
    };
    int count = 0;
    const std::vector<int> part = parts(tissue, count);
    std::set<int> lower, upper;
    for_each_element(grid, [&](Vec3i e) {
        const int own = side(e);
        if (own < 0) lower.insert(part[voxel_index(grid, e)]);
        if (own > 0) upper.insert(part[voxel_index(grid, e)]);
        for (int b = 0; b < 3; ++b) {
            const Vec3i f = e + Vec3i{b == 0, b == 1, b == 2};
            if (!contains(voxel_box(grid), f)) continue;
            const int product = own * side(f);
            if (product < 0) {
                EXPECT_FALSE(lattice_of(tissue).is_linked(e, b));
            }
            if (product > 0) {
                EXPECT_TRUE(lattice_of(tissue).is_linked(e, b));
            }
        }
    });
    for (const int n : lower)
        EXPECT_FALSE(upper.contains(n)) << "a part has elements of both sides";
    EXPECT_FALSE(lower.empty() || upper.empty());
}

TEST(Cut, PlaneOfAnyOrientationPartsItsTwoSides) {
    const TaskArena arena(2);
    for (std::uint64_t n = 0; n < 60; ++n) {
        SCOPED_TRACE("seed " + std::to_string(kCutSeed + n));
        Random random(kCutSeed + n);
        Volume volume = block({random.whole(5, 11), random.whole(5, 11), random.whole(5, 11)});
        volume.grid.spacing_mm = {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)};
        volume.grid.direction = random.rotation(n % 2);
        volume.grid.origin_mm = random.vector(50);
        ChainMail tissue = bounded_tissue(volume, arena);
        const Vec3i middle = {volume.grid.size.x / 2, volume.grid.size.y / 2,
                              volume.grid.size.z / 2};
        if (n % 3 == 0) {
            const std::vector<Vec3i> grabbed = {middle};
            ASSERT_TRUE(tissue.push_elements(grabbed, random.vector(1.5)).ok());
        }
        const Mat3d frame = random.rotation(false);
        const Vec3d point = present_mm(tissue, middle) + random.vector(0.4);
        const auto report = tissue.cut(plane_through(point, frame.columns[0], frame.columns[1]));
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GT(report->cut_links, 20);
        EXPECT_EQ(report->cut_links, tissue.state().cut_links);
        expect_parted(tissue, point, frame.columns[2]);
    }
}

TEST(Cut, PlaneThroughLatticePointsLeavesNoLinkUncut) {
    const TaskArena arena(1);
    const Volume volume = block({8, 8, 8});
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
            for (int z = 0; z <= 2; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                SCOPED_TRACE(std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z));
                const Vec3d normal{double(x), double(y), double(z)};
                const Vec3d other = std::abs(z) + std::abs(y) > 0 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
                const Vec3d deep = cross(normal, other);  // whole numbers: every tie is exact
                const Vec3d across = cross(normal, deep);
                ChainMail tissue = bounded_tissue(volume, arena);
                ASSERT_TRUE(tissue.cut(plane_through({4, 4, 4}, across, deep)).ok());
                expect_parted(tissue, {4, 4, 4}, normal);
                int count = 0;
                parts(tissue, count);
                EXPECT_GE(count, 2);
            }
}

TEST(Cut, ClosedLineTakesOutAColumnThroughItsCorners) {
    const TaskArena arena(1);
    const Volume volume = block({12, 12, 6});
    ChainMail tissue = bounded_tissue(volume, arena);
    // A lozenge whose corners and edges run through elements, cut right through.
    ASSERT_TRUE(
        tissue.cut({{{6, 2, -9}, {10, 6, -9}, {6, 10, -9}, {2, 6, -9}, {6, 2, -9}}, {0, 0, 30}})
            .ok());
    int count = 0;
    const std::vector<int> part = parts(tissue, count);
    const Grid& grid = volume.grid;
    const int inside = part[voxel_index(grid, {6, 6, 3})];
    for_each_element(grid, [&](Vec3i e) {
        const int away = std::abs(e.x - 6) + std::abs(e.y - 6);
        if (away < 4) {
            EXPECT_EQ(part[voxel_index(grid, e)], inside);
        }
        if (away > 4) {
            EXPECT_NE(part[voxel_index(grid, e)], inside);
        }
    });
}

/// Möller and Trumbore's test in doubles, a method independent of signs of volumes.
bool crosses_in_doubles(const Triangle& t, Position p, Position q) {
    const auto real = [](Position a) { return Vec3d{double(a.x), double(a.y), double(a.z)}; };
    const Vec3d d = real(q - p), e1 = real(t[1] - t[0]), e2 = real(t[2] - t[0]);
    const Vec3d h = cross(d, e2);
    const double f = 1 / dot(e1, h);
    const Vec3d s = real(p - t[0]);
    const double u = f * dot(s, h);
    const Vec3d k = cross(s, e1);
    const double v = f * dot(d, k), w = f * dot(e2, k);
    return u > 0 && v > 0 && u + v < 1 && w > 0 && w < 1;
}

TEST(Cut, SegmentsCrossTrianglesWhereGeometrySays) {
    Random random(kCutSeed);
    const auto anywhere = [&](int reach) {
        return Position{random.whole(-reach, reach), random.whole(-reach, reach),
                        random.whole(-reach, reach)};
    };
    int crossing = 0;
    for (int n = 0; n < 200'000; ++n) {
        const int reach = n % 2 ? 1'000'000 : 1'000'000'000;
        const Triangle t{anywhere(reach), anywhere(reach), anywhere(reach)};
        const Position p = anywhere(reach), q = anywhere(reach);
        const bool expected = crosses_in_doubles(t, p, q);
        crossing += expected;
        ASSERT_EQ(crosses(t, p, q), expected) << "seed " << kCutSeed << ", case " << n;
        ASSERT_EQ(crosses(t, q, p), expected);
        ASSERT_EQ(crosses({t[2], t[1], t[0]}, p, q), expected);
    }
    EXPECT_GT(crossing, 5000);
}

TEST(Cut, OfTwoTrianglesThatShareAnEdgeExactlyOneIsCrossed) {
    // Ties everywhere: small whole coordinates. The two triangles make a square; a segment through
    // it crosses one of them, and for one that ends on it the moved ribbon alone decides.
    const Position a{0, 0, 0}, b{4, 0, 0}, c{4, 4, 0}, d{0, 4, 0};
    for (std::int64_t x = 1; x <= 3; ++x)
        for (std::int64_t y = 1; y <= 3; ++y) {
            const Position low{x, y, -3}, on{x, y, 0}, high{x, y, 3};
            const auto count = [&](Position p, Position q) {
                return crosses({a, b, c}, p, q) + crosses({a, c, d}, p, q);
            };
            EXPECT_EQ(count(low, high), 1);
            EXPECT_EQ(count(low, on) + count(on, high), 1);
        }
}

TEST(Cut, PullingOneSideLeavesTheOtherBitForBitAtRest) {
    const TaskArena arena(2);
    const Volume volume = block({20, 20, 20});
    for (const ChainMailSolver solver : {ChainMailSolver::Sweep, ChainMailSolver::Heap}) {
        ChainMailSettings settings;
        settings.bounded = true;
        settings.solver = solver;
        ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
        ASSERT_TRUE(tissue.cut(plane_through({9.5, 9.5, 9.5}, {0, 1, 0}, {0, 0, 1})).ok());
        const auto push = tissue.push({.point_mm = {12.5, 9.5, 9.5}, .push_mm = {4, 1, -2}});
        ASSERT_TRUE(push.ok());
        EXPECT_GT(push->moved_elements, 1000);
        for_each_element(volume.grid, [&](Vec3i e) {
            if (e.x <= 9) {
                EXPECT_EQ(tissue.displacement_mm(e), (Vec3d{0, 0, 0}));
            }
        });
        EXPECT_LE(tissue.state().max_violation_mm, 0);
        EXPECT_EQ(tissue.state().folded_cells, 0);
    }
}

TEST(Cut, GapOpensByThePullAndShortCutsBendAround) {
    const TaskArena arena(1);
    const Volume volume = block({24, 24, 24});
    ChainMail whole = bounded_tissue(volume, arena), cut = bounded_tissue(volume, arena);
    ASSERT_TRUE(cut.cut({{{11.5, 4.5, -5}, {11.5, 18.5, -5}}, {0, 0, 40}}).ok());
    const Push push{.point_mm = {13.5, 11.5, 11.5}, .push_mm = {3, 0, 0}};
    ASSERT_TRUE(whole.push(push).ok() && cut.push(push).ok());
    const auto gap = [](const ChainMail& t) {
        return t.displacement_mm({12, 11, 11}).x - t.displacement_mm({11, 11, 11}).x;
    };
    EXPECT_LT(gap(whole), 0.25);
    EXPECT_GT(gap(cut), 2.5);
    EXPECT_LE(cut.state().max_violation_mm, 0);
}

TEST(Cut, SecondCutAtTheSamePlaceFindsNothing) {
    const TaskArena arena(1);
    const Volume volume = block({10, 10, 10});
    ChainMail tissue = bounded_tissue(volume, arena);
    const CutSurface surface = plane_through({4.5, 5, 5}, {0, 1, 0}, {0, 0, 1});
    EXPECT_EQ(tissue.cut(surface)->cut_links, 100);
    EXPECT_EQ(tissue.cut(surface)->cut_links, 0);
    EXPECT_EQ(tissue.undo_steps(), 1);
}

TEST(Cut, SurfacesOfNoUseAreRefused) {
    const TaskArena arena(1);
    const Volume volume = block({10, 10, 10});
    ChainMail tissue = bounded_tissue(volume, arena);
    const auto message = [&](const CutSurface& surface) {
        const auto report = tissue.cut(surface);
        return report.ok() ? std::string() : report.error().message;
    };
    EXPECT_NE(message({{{1, 1, 1}}, {0, 0, 1}}).find("two or more points, found 1"), -1ul);
    EXPECT_NE(message({{{1, 1, 1}, {1, 1, 5}}, {0, 0, 1}}).find("no area"), -1ul);
    EXPECT_NE(message({{{1, 1, 1}, {1, 1, 5e9}}, {0, 1, 1}}).find("100000 mm"), -1ul);
    EXPECT_NE(message({{{1, 1, NAN}, {1, 1, 5}}, {0, 1, 1}}).find("100000 mm"), -1ul);
    EXPECT_EQ(tissue.state().cut_links, 0);
}

TEST(Carve, ElementsInsideTheToolNowBecomeVoid) {
    const TaskArena arena(1);
    const Volume volume = block({20, 20, 20});
    ChainMail tissue = bounded_tissue(volume, arena);
    ASSERT_TRUE(tissue.push({.point_mm = {9.5, 9.5, 9.5}, .push_mm = {2, 1, 0}}).ok());
    const CarveTool tool{.from_mm = {6, 9, 9}, .to_mm = {14, 10, 12}, .radius_mm = 2.6};
    std::set<std::size_t> inside;
    for_each_element(volume.grid, [&](Vec3i e) {
        const Vec3d p = present_mm(tissue, e);
        double nearest = 1e9;
        for (int n = 0; n <= 10'000; ++n)
            nearest =
                std::min(nearest, norm(p - tool.from_mm - n / 1e4 * (tool.to_mm - tool.from_mm)));
        if (nearest <= tool.radius_mm) inside.insert(voxel_index(volume.grid, e));
    });
    const auto report = tissue.carve(tool);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->carved_elements, std::int64_t(inside.size()));
    EXPECT_EQ(tissue.state().carved_elements, std::int64_t(inside.size()));
    for_each_element(volume.grid, [&](Vec3i e) {
        const bool is_void = inside.contains(voxel_index(volume.grid, e));
        EXPECT_EQ(lattice_of(tissue).is_void(e), is_void);
        if (is_void) {
            EXPECT_EQ(tissue.displacement_mm(e), (Vec3d{0, 0, 0}));
        }
    });
    EXPECT_LE(tissue.state().max_violation_mm, 0);
}

TEST(Carve, AChannelThroughManyBricksIsUndoneAndRedone) {
    const TaskArena arena(2);
    const Volume volume = block({40, 24, 24});
    ChainMail tissue = bounded_tissue(volume, arena);
    const auto voids = [&] {
        std::vector<bool> found;
        for_each_element(volume.grid,
                         [&](Vec3i e) { found.push_back(lattice_of(tissue).is_void(e)); });
        return found;
    };
    const auto whole = voids();
    ASSERT_TRUE(tissue.carve({.from_mm = {3, 4, 5}, .to_mm = {36, 17, 14}, .radius_mm = 2}).ok());
    const auto once = voids();
    ASSERT_TRUE(tissue.carve({.from_mm = {3, 17, 5}, .to_mm = {36, 6, 19}, .radius_mm = 1.5}).ok());
    const auto twice = voids();
    EXPECT_GT(std::count(twice.begin(), twice.end(), true),
              std::count(once.begin(), once.end(), true));
    ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(voids(), once);
    ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(voids(), whole);
    ASSERT_TRUE(tissue.redo().ok() && tissue.redo().ok());
    EXPECT_EQ(voids(), twice);
}

TEST(Carve, BoneCanBeCarvedUnlessItIsSpared) {
    const TaskArena arena(1);
    Volume volume = block({16, 16, 16});
    auto& voxels = *std::get_if<0>(&volume.voxels);
    for (int y = 7; y <= 8; ++y)
        for (int x = 7; x <= 8; ++x) voxels[voxel_index(volume.grid, {x, y, 8})] = 1200;
    ChainMail tissue = bounded_tissue(volume, arena);
    const Push push{.point_mm = {7.5, 7.5, 7.5}, .push_mm = {0, 0, -1}};
    EXPECT_EQ(tissue.push(push)->limited_by, LimitedBy::Bone);
    CarveTool tool{
        .from_mm = {7.5, 7.5, 8}, .to_mm = {7.5, 7.5, 8}, .radius_mm = 1.2, .spare_fixed = true};
    ASSERT_TRUE(tissue.carve(tool).ok());
    for (int c = 0; c < 4; ++c)
        EXPECT_FALSE(lattice_of(tissue).is_void({7 + (c & 1), 7 + (c >> 1), 8}));
    tool.spare_fixed = false;
    EXPECT_EQ(tissue.carve(tool)->carved_elements, 4);
    const auto freed = tissue.push({.point_mm = {7.5, 7.5, 6.5}, .push_mm = {0, 0, -1}});
    EXPECT_EQ(freed->status, PushStatus::Applied);
}

TEST(Carve, NothingSmearsAcrossACarvedSlab) {
    const TaskArena arena(1);
    const Volume volume = block({24, 10, 10});
    ChainMail tissue = bounded_tissue(volume, arena);
    const double r = 0.6;
    for (int y = 0; y < 10; ++y)
        ASSERT_TRUE(tissue.carve({{12, double(y), -1}, {12, double(y), 11}, r}).ok());
    EXPECT_EQ(tissue.state().carved_elements, 100);
    ASSERT_TRUE(tissue.push({.point_mm = {15.5, 4.5, 4.5}, .push_mm = {-4, 1, 1}}).ok());
    for_each_element(volume.grid, [&](Vec3i e) {
        if (e.x <= 12) {
            EXPECT_EQ(tissue.displacement_mm(e), (Vec3d{0, 0, 0}));
        }
    });
}

TEST(Carve, ToolsOfNoUseAreRefused) {
    const TaskArena arena(1);
    const Volume volume = block({8, 8, 8});
    ChainMail tissue = bounded_tissue(volume, arena);
    EXPECT_FALSE(tissue.carve({{1, 1, 1}, {1, 1, 1}, 0}).ok());
    EXPECT_FALSE(tissue.carve({{1, 1, 1}, {1, 1, 1}, NAN}).ok());
    EXPECT_FALSE(tissue.carve({{1, 1, NAN}, {1, 1, 1}, 2}).ok());
    EXPECT_EQ(tissue.state().carved_elements, 0);
}

/// Alternates pushes, cuts and carvings; each push is compared with the oracle bit for bit.
void run_cut_instance(std::uint64_t seed) {
    Random random(seed);
    const TaskArena arena(2);
    const Instance instance = random_instance(random, 4, 8, true);
    const Grid& grid = instance.volume.grid;
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    settings.brick_size = random.whole(2, 9);
    ChainMail sweep = std::move(ChainMail::create(instance.volume, settings, arena)).value();
    settings.brick_size = 8;
    settings.solver = ChainMailSolver::Heap;
    ChainMail heap = std::move(ChainMail::create(instance.volume, settings, arena)).value();
    Oracle<std::int64_t> exact(instance.volume, instance.law, kInstanceMargin);
    const auto anywhere = [&] {
        return world_from_voxel(grid, {random.real(0, grid.size.x), random.real(0, grid.size.y),
                                       random.real(0, grid.size.z)});
    };
    for (int step = 0; step < 4; ++step) {
        const CutSurface surface{{anywhere(), anywhere(), anywhere()}, random.vector(15)};
        ASSERT_EQ(sweep.cut(surface)->cut_links, heap.cut(surface)->cut_links);
        const CarveTool tool{anywhere(), anywhere(), random.real(0.3, 1.2)};
        if (step % 2) {
            ASSERT_EQ(sweep.carve(tool)->carved_elements, heap.carve(tool)->carved_elements);
        }
        exact.for_each([&](Vec3i e) {
            const BrickEdits* edits = lattice_of(sweep).edits_of(lattice_of(sweep).brick_of(e));
            if (edits)
                exact.set_edits(e, (*edits)[std::size_t(lattice_of(sweep).index_in_brick(e))]);
        });
        const std::vector<Vec3i> grabbed = random_grab(random, grid);
        std::vector<Vec3i> left;
        for (const Vec3i& e : grabbed)
            if (!lattice_of(sweep).is_void(e)) left.push_back(e);
        if (left.empty()) continue;
        const Vec3<Fixed> before = lattice_of(sweep).displacement_at(left[0]);
        const Vec3d push_mm = random.vector(instance.push_limit_mm.x);
        ASSERT_TRUE(sweep.push_elements(grabbed, push_mm).ok());
        ASSERT_TRUE(heap.push_elements(grabbed, push_mm).ok());
        const Vec3<Fixed> done = lattice_of(sweep).displacement_at(left[0]) - before;
        exact.push(left, Vec3<std::int64_t>{done.x, done.y, done.z});
        ASSERT_TRUE(exact.margin_at_rest()) << "the instance outgrew its margin";
        exact.for_each([&](Vec3i e) {
            for (int a = 0; a < 3; ++a)
                ASSERT_EQ(lattice_of(sweep).displacement_at(e)[a], exact.displacement(e, a));
        });
        ASSERT_EQ(sweep.hash(), heap.hash());
        ASSERT_LT(sweep.state().max_violation_mm, 1e-9);
    }
}

TEST(Cut, SolversEqualTheOracleAmongCutsAndVoids) {
    for (std::uint64_t n = 0; n < 60 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kCutSeed + n));
        run_cut_instance(kCutSeed + n);
    }
}

}  // namespace
}  // namespace pliant::test
