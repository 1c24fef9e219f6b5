// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pushes of a scan, through the public interface.
// Covers: chainmail/chainmail.cpp, chainmail/grab.cpp, lattice/lattice.cpp, lattice/near_cells.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "base/memory_budget.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/check.h"
#include "chainmail/grab.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

class PushTest : public ::testing::Test {
  protected:
    TaskArena arena{2};
    Volume volume = block({24, 24, 24});
};

TEST_F(PushTest, PointToolMovesTheEightElementsOfTheCellTogether) {
    ChainMail tissue = tissue_of(volume, arena);
    const auto report = tissue.push({.point_mm = {10.5, 11.25, 12.75}, .push_mm = {1, -0.5, 2}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Applied);
    EXPECT_EQ(report->step_fraction, 1);
    EXPECT_EQ(report->grabbed_elements, 8);
    for (int c = 0; c < 8; ++c) {
        const Vec3d u = tissue.displacement_mm({10 + (c & 1), 11 + (c >> 1 & 1), 12 + (c >> 2)});
        EXPECT_NEAR(norm(u - Vec3d{1, -0.5, 2}), 0, 2e-6);
    }
}

TEST_F(PushTest, HomogeneousPushFallsOffByTheLimitPerLink) {
    ChainMailSettings settings;
    settings.offset = 0.25;
    ChainMail tissue = tissue_of(volume, arena, settings);
    ASSERT_TRUE(tissue.push({.point_mm = {10.5, 10.5, 10.5}, .push_mm = {0, 0, 1}}).ok());
    const double w = 1040 / 4095.0, limit = 0.25 * (1 - w * w);
    for (int n = 0; n < 8; ++n) {
        const double expected = std::max(0.0, 1 - n * limit);
        EXPECT_NEAR(tissue.displacement_mm({11, 11, 11 + n}).z, expected, 1e-4) << n;
        EXPECT_NEAR(tissue.displacement_mm({11 + n, 11, 11}).z, expected, 1e-4) << n;
    }
}

TEST_F(PushTest, SphereGrabsTissueInsideItAndNoAir) {
    auto& voxels = std::get<0>(volume.voxels);
    for (int z = 0; z < 12; ++z)
        for (int n = 0; n < 24 * 24; ++n) voxels[std::size_t(z * 576 + n)] = -1000;
    ChainMail tissue = tissue_of(volume, arena);
    std::int64_t expected = 0;
    for (int z = 12; z < 24; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x)
                expected += (x - 12) * (x - 12) + (y - 12) * (y - 12) + (z - 12) * (z - 12) <= 9;
    const auto report =
        tissue.push({.point_mm = {12, 12, 12}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 3});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->grabbed_elements, expected);
    const auto air =
        tissue.push({.point_mm = {12, 12, 4}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 2});
    ASSERT_TRUE(air.ok());
    EXPECT_EQ(air->status, PushStatus::Rejected);
    EXPECT_NE(air->message.find("no tissue"), std::string::npos);
}

TEST_F(PushTest, SecondPushTakesHoldOfWhatIsAtThePointNow) {
    ChainMail tissue = tissue_of(volume, arena);
    ASSERT_TRUE(tissue.push({.point_mm = {10.5, 10.5, 10.5}, .push_mm = {3, 0, 0}}).ok());
    const auto cell = grab_cell(lattice_of(tissue), {13.5, 10.5, 10.5});
    ASSERT_TRUE(cell);
    EXPECT_EQ(cell->front(), (Vec3i{10, 10, 10}));
    const auto around =
        grab_sphere(lattice_of(tissue), {13.5, 10.5, 10.5}, 0.9, TissueValues{-500});
    EXPECT_EQ(around.size(), 8u);
    EXPECT_EQ(around.front(), (Vec3i{10, 10, 10}));
}

TEST_F(PushTest, ASphereTakesHoldOfWhatIsWithinItNowAndOfNoAir) {
    const std::uint64_t seed = 6;
    SCOPED_TRACE(seed);
    Random random(seed);
    ChainMail tissue = tissue_of(volume, arena);
    const Grid& grid = volume.grid;
    for (int turn = 0; turn < 12; ++turn) {
        ASSERT_TRUE(
            tissue
                .push({.point_mm = {random.real(4, 20), random.real(4, 20), random.real(4, 20)},
                       .push_mm = random.vector(4)})
                .ok());
        const Vec3d centre{random.real(0, 23), random.real(0, 23), random.real(0, 23)};
        const double radius_mm = random.real(0.3, 9), air_hu = turn % 3 ? -500 : -2000;
        std::vector<Vec3i> expected;
        for (int z = 0; z < grid.size.z; ++z)
            for (int y = 0; y < grid.size.y; ++y)
                for (int x = 0; x < grid.size.x; ++x) {
                    const Vec3d now = world_from_voxel(grid, {double(x), double(y), double(z)}) +
                                      tissue.displacement_mm({x, y, z});
                    if (norm(now - world_from_voxel(grid, centre)) <= radius_mm &&
                        lattice_of(tissue).value_at({x, y, z}) >= air_hu)
                        expected.push_back({x, y, z});
                }
        auto found = grab_sphere(lattice_of(tissue), centre, radius_mm, TissueValues{air_hu});
        std::sort(found.begin(), found.end(), [](Vec3i p, Vec3i q) {
            return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
        });
        EXPECT_EQ(found, expected) << "sphere of " << radius_mm << " mm";
    }
}

TEST_F(PushTest, EveryPointOfADeformedLatticeIsInACell) {
    ChainMail tissue = tissue_of(volume, arena);
    Random random(5);
    for (int n = 0; n < 6; ++n)
        ASSERT_TRUE(
            tissue
                .push({.point_mm = {random.real(4, 20), random.real(4, 20), random.real(4, 20)},
                       .push_mm = random.vector(3)})
                .ok());
    for (int n = 0; n < 400; ++n) {
        const Vec3d p{random.real(0, 23), random.real(0, 23), random.real(0, 23)};
        EXPECT_TRUE(grab_cell(lattice_of(tissue), p)) << p.x << ' ' << p.y << ' ' << p.z;
    }
}

TEST_F(PushTest, MotionGoesBeyondTheBorderOfTheScan) {
    // Air that follows the law by value is dragged along.
    ChainMailSettings settings;
    settings.air_enabled = false;
    ChainMail tissue = tissue_of(volume, arena, settings);
    ASSERT_TRUE(tissue.push({.point_mm = {0.5, 12.5, 12.5}, .push_mm = {-2, 0, 0}}).ok());
    EXPECT_LT(tissue.displacement_mm({-3, 12, 12}).x, -0.5);
    EXPECT_EQ(tissue.displacement_mm({-40, 12, 12}), (Vec3d{0, 0, 0}));
    EXPECT_LT(tissue.moved_box().begin.x, -3);
    EXPECT_LT(tissue.state().max_violation_mm, 1e-6);
}

TEST_F(PushTest, PushAgainstBoneStopsExactlyThere) {
    auto& voxels = std::get<0>(volume.voxels);
    for (int n = 0; n < 24 * 24; ++n) voxels[std::size_t(20 * 576 + n)] = 1000;
    ChainMail tissue = tissue_of(volume, arena);
    const auto report = tissue.push({.point_mm = {12.5, 12.5, 15.5}, .push_mm = {0, 0, 4}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Limited);
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    // Three links of soft tissue and one to the bone separate layer 16 from layer 20.
    const double w = 1040 / 4095.0, b = 2000 / 4095.0;
    const double play = 0.2 * (3 * (1 - w * w) + (1 - w * w + 1 - b * b) / 2);
    EXPECT_NEAR(report->step_fraction, play / 4, 1e-5);
    EXPECT_EQ(tissue.displacement_mm({12, 12, 20}), (Vec3d{0, 0, 0}));
    EXPECT_NE(report->message.find("bone_threshold_hu"), std::string::npos);
}

TEST_F(PushTest, GrabbedBoneRejectsThePushAndChangesNothing) {
    std::get<0>(volume.voxels)[voxel_index(volume.grid, {12, 12, 12})] = 1200;
    ChainMailSettings settings;
    settings.smallest_bone_mm3 = 0;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const auto report = tissue.push({.point_mm = {12.5, 12.5, 12.5}, .push_mm = {1, 0, 0}});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Rejected);
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_EQ(report->step_fraction, 0);
    EXPECT_EQ(report->moved_elements, 0);
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

TEST_F(PushTest, PushThatIsTakenBackLeavesNoBrickBehind) {
    ChainMailSettings settings;
    ChainMail tissue = tissue_of(volume, arena, settings);
    // All elements of the scan together are a rigid block: the opposite push restores everything
    // inside; a block around it also moves the air beyond the border back.
    std::vector<Vec3i> all;
    for (int z = -12; z < 36; ++z)
        for (int y = -12; y < 36; ++y)
            for (int x = -12; x < 36; ++x) all.push_back({x, y, z});
    ASSERT_TRUE(tissue.push_elements(all, {0.125, 0, 0}).ok());
    EXPECT_GT(tissue.state().resident_bricks, 0);
    ASSERT_TRUE(tissue.push_elements(all, {-0.125, 0, 0}).ok());
    EXPECT_EQ(tissue.displacement_mm({3, 3, 3}), (Vec3d{0, 0, 0}));
    EXPECT_EQ(tissue.state().resident_bricks, 0);
    EXPECT_EQ(tissue.hash(), tissue_of(volume, arena).hash());
}

TEST_F(PushTest, RotatedAndLeftHandedCopiesMoveTheSameInTheWorld) {
    Random random(77);
    Volume mirrored = volume;
    auto& voxels = std::get<0>(volume.voxels);
    for (auto& v : voxels) v = std::int16_t(random.whole(-100, 250));
    // The same elements at the same world positions, stored with i reversed: left-handed.
    auto& reversed = std::get<0>(mirrored.voxels);
    for (int z = 0; z < 24; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x)
                reversed[voxel_index(volume.grid, {23 - x, y, z})] =
                    voxels[voxel_index(volume.grid, {x, y, z})];
    mirrored.grid.direction.columns[0] = {-1, 0, 0};
    mirrored.grid.origin_mm = {23, 0, 0};
    // Also for a rotation of the world.
    Volume rotated = volume;
    const Mat3d rotation = random.rotation(false);
    rotated.grid.direction = rotation * volume.grid.direction;
    rotated.grid.origin_mm = {5, -3, 8};
    ChainMail a = tissue_of(volume, arena), b = tissue_of(mirrored, arena),
              c = tissue_of(rotated, arena);
    const Push push{.point_mm = {11.3, 12.6, 10.2}, .push_mm = {2, -1, 1.5}};
    ASSERT_TRUE(a.push(push).ok());
    ASSERT_TRUE(b.push(push).ok());
    ASSERT_TRUE(c.push({.point_mm = rotated.grid.origin_mm + rotation * push.point_mm,
                        .push_mm = rotation * push.push_mm})
                    .ok());
    for (int z = 0; z < 24; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x) {
                const Vec3d u = a.displacement_mm({x, y, z});
                ASSERT_EQ(u, b.displacement_mm({23 - x, y, z}));
                ASSERT_NEAR(norm(rotation * u - c.displacement_mm({x, y, z})), 0, 5e-6);
            }
}

TEST(PushOutside, BoundsAreSaidAndRasIsTried) {
    Volume volume;
    volume.grid.size = {11, 11, 5};
    volume.grid.origin_mm = {20, -70, 30};
    volume.grid.direction = {{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}};
    volume.voxels = VoxelArray<std::int16_t>(voxel_count(volume.grid));
    const TaskArena arena(1);
    auto tissue = ChainMail::create(volume, {}, arena);
    ASSERT_TRUE(tissue.ok());
    const auto message = [&](Vec3d point) {
        const auto done = tissue->push({.point_mm = point, .push_mm = {1, 0, 0}});
        return done.ok() ? std::string("pushed") : done.error().message;
    };
    const std::string bounds =
        "push: expected a point in the scan, x 20…30, y -70…-60, z 26…30 mm (LPS), found ";
    EXPECT_EQ(message({25, -65, 31}), bounds + "25, -65, 31");
    EXPECT_EQ(
        message({-25, 65.5, 28}),
        bounds +
            "-25, 65.5, 28; did you mean 25,-65.5,28, which is the point if it was given in RAS?");
    EXPECT_EQ(message({25, -65, 28}), "pushed");
    // Of an oblique scan, corners of the box lie outside: voxels are said, from side to side.
    volume.grid = {{11, 11, 5}, {1, 1, 1}, {0, 0, 0}, {{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}}};
    auto oblique = ChainMail::create(volume, {}, arena);
    ASSERT_TRUE(oblique.ok());
    const WorldBox box = centre_bounds(volume.grid);
    for (const Vec3d corner : {Vec3d{box.low_mm.x, box.low_mm.y, 2},
                               {box.high_mm.x, box.high_mm.y, 2},
                               {box.low_mm.x, box.high_mm.y, 0},
                               {box.high_mm.x, box.low_mm.y, 4}}) {
        const auto done = oblique->push({.point_mm = corner, .push_mm = {1, 0, 0}});
        ASSERT_FALSE(done.ok());
        EXPECT_NE(done.error().message.find(", i 0…10, j 0…10, k 0…4 voxels, found"), -1ul)
            << done.error().message;
    }
}

TEST_F(PushTest, BadInputIsNamedAndChangesNothing) {
    ChainMail tissue = tissue_of(volume, arena);
    const auto outside = tissue.push({.point_mm = {100, 0, 0}, .push_mm = {1, 0, 0}});
    ASSERT_FALSE(outside.ok());
    const WorldBox box = centre_bounds(volume.grid);
    EXPECT_LT(box.high_mm.x, 100);
    EXPECT_TRUE(outside.error().message.starts_with("push: expected a point in the scan, x "))
        << outside.error().message;
    EXPECT_EQ(outside.error().message.find("did you mean"), std::string::npos);
    EXPECT_FALSE(tissue.push({.point_mm = {5, 5, 5}, .push_mm = {NAN, 0, 0}}).ok());
    EXPECT_FALSE(tissue.push({.point_mm = {5, 5, 5}, .push_mm = {1e9, 0, 0}}).ok());
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

TEST_F(PushTest, PushThatNeedsTooMuchMemoryIsRefusedAndChangesNothing) {
    ChainMailSettings settings;
    settings.max_elements = 2048;
    settings.offset = 0.01;
    for (const auto solver : {ChainMailSolver::Sweep, ChainMailSolver::Heap}) {
        settings.solver = solver;
        ChainMail tissue = tissue_of(volume, arena, settings);
        const auto report = tissue.push({.point_mm = {12.5, 12.5, 12.5}, .push_mm = {8, 3, 0}});
        ASSERT_FALSE(report.ok());
        EXPECT_EQ(report.error().code, ErrorCode::LimitExceeded);
        EXPECT_NE(report.error().message.find("max_elements"), std::string::npos);
        EXPECT_EQ(tissue.state().resident_bricks, 0);
    }
}

TEST_F(PushTest, CheckFindsViolatedLinksAndFoldedCells) {
    // A soft law moves elements freely; a hard law finds violations in the same state, and a cell
    // pushed through its neighbour is folded.
    ChainMailSettings soft;
    soft.custom_law = [](int) {
        return ElementLimits{{1, 1, 1}, {2, 2, 2}, {2, 2, 2}, 100, false};
    };
    ChainMail tissue = tissue_of(volume, arena, soft);
    const std::vector<Vec3i> one = {{12, 12, 12}};
    ASSERT_TRUE(tissue.push_elements(one, {0.9, 0.9, 0.9}).ok());
    const LatticeState state = tissue.state();
    EXPECT_EQ(state.max_violation_mm, 0);
    EXPECT_EQ(state.moved_elements, 1);
    // In front of the element, where det F = 1 - 3 * 0.9 at its corner.
    EXPECT_EQ(state.folded_cells, 1);
    const auto hard = [](Vec3i) {
        return ElementLimits{{.2, .2, .2}, {.3, .3, .3}, {.1, .1, .1}, 100, false};
    };
    // The largest violation is the shear of a link: 0.9 mm with a limit of 0.1 mm.
    EXPECT_NEAR(check_lattice(lattice_of(tissue), hard, arena).max_violation_mm, 0.8, 1e-5);
}

TEST_F(PushTest, DefaultLimitsOfTissueNeverFold) {
    ChainMailSettings settings;
    settings.air_enabled = false;
    ChainMail tissue = tissue_of(volume, arena, settings);
    Random random(9);
    for (int n = 0; n < 10; ++n) {
        ASSERT_TRUE(
            tissue
                .push({.point_mm = {random.real(2, 21), random.real(2, 21), random.real(2, 21)},
                       .push_mm = random.vector(6)})
                .ok());
        EXPECT_EQ(tissue.state().folded_cells, 0);
    }
    EXPECT_GT(tissue.state().moved_elements, 1000);
}

TEST(Push, ASphereBetweenTheElementsTakesTheCellsThatItTouches) {
    const Volume volume = block({12, 12, 12}, 40, {1, 1, 4});
    const TaskArena arena(1);
    ChainMail tissue = tissue_of(volume, arena);
    const Push inside{.point_mm = {5.5, 5.5, 22}, .push_mm = {1, 0, 0}, .sphere_radius_mm = 0.1};
    const auto grabbed = tissue.elements_at(inside);
    ASSERT_TRUE(grabbed.ok());
    Push cell = inside;
    cell.sphere_radius_mm = 0;
    EXPECT_EQ(*grabbed, *tissue.elements_at(cell)) << "the eight elements of its cell";
    const auto report = tissue.push(inside);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Applied);
    EXPECT_NEAR(tissue.displacement_mm({5, 5, 5}).x, 1, 1e-5);
}

/// Rigid tissue that nothing surrounds: a push would move it without end.
ChainMailSettings endless() {
    ChainMailSettings settings;
    settings.offset = 0;
    settings.bone_threshold_hu = 32768;
    settings.max_movement_mm = 500;
    settings.air_enabled = false;
    return settings;
}

const Push kEndlessPush{
    .point_mm = {10.5, 10.5, 10.5}, .push_mm = {1, 0, 0}, .sphere_radius_mm = 4};

/// Refused, the tissue is as before, and answers other pushes like one that wasn't asked.
void expect_refusal_without_trace(ChainMail& tissue, const Volume& volume, const TaskArena& arena,
                                  const std::string& message) {
    const std::uint64_t before = tissue.hash();
    const auto push = tissue.push(kEndlessPush);
    ASSERT_FALSE(push.ok());
    EXPECT_EQ(push.error().code, ErrorCode::LimitExceeded);
    EXPECT_NE(push.error().message.find(message), std::string::npos) << push.error().message;
    EXPECT_EQ(tissue.hash(), before);
    EXPECT_EQ(tissue.state().resident_bricks, 0);
    ChainMailSettings soft = endless();
    soft.offset = 0.2;
    ASSERT_TRUE(tissue.set_materials(soft).ok());
    ChainMail twin = tissue_of(volume, arena, soft);
    ASSERT_TRUE(tissue.push(kEndlessPush).ok());
    ASSERT_TRUE(twin.push(kEndlessPush).ok());
    EXPECT_EQ(tissue.hash(), twin.hash());
}

TEST_F(PushTest, MovesNotManyMoreElementsThanTheScanHas) {
    for (const auto solver : {ChainMailSolver::Sweep, ChainMailSolver::Heap}) {
        ChainMailSettings settings = endless();
        settings.solver = solver;
        ChainMail tissue = tissue_of(volume, arena, settings);
        expect_refusal_without_trace(tissue, volume, arena,
                                     "the push would move more than 8055296 elements");
    }
}

TEST_F(PushTest, IsRefusedWhereTheMachineLacksItsMemory) {
    const TemporaryFolder folder;
    folder.write("machine/proc/meminfo", "MemAvailable: 102400 kB\n");
    const MemorySources small{folder.path() / "machine", kUnlimited};
    ChainMail tissue = tissue_of(volume, arena, endless());
    const UseMemorySources use(small);
    expect_refusal_without_trace(tissue, volume, arena, "memory");
}

}  // namespace
}  // namespace pliant::test
