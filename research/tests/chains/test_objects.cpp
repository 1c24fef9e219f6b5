// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Objects in one space: contact is exact, and objects never pass through each other.

#include <gtest/gtest.h>
#include <pliant/research/objects.h>

#include <optional>

#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "chains/objects_contact.h"
#include "lattice/lattice.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kObjectsSeed = 20260304;
constexpr double kUnitMm = 1.0 / (1 << 20);

Volume block_at(Vec3d origin_mm, Vec3i size, int value = 40) {
    Volume volume = block(size, value);
    volume.grid.origin_mm = origin_mm;
    return volume;
}

/// Positions of all elements along the grid's axes, in doubles.
std::vector<Vec3d> places_of(const ChainMail& tissue) {
    std::vector<Vec3d> positions;
    const Grid& grid = tissue.volume().grid;
    for_each_element(grid, [&](Vec3i e) {
        if (lattice_of(tissue).is_void(e)) return;
        const Vec3d x = world_from_voxel(grid, {double(e.x), double(e.y), double(e.z)}) +
                        tissue.displacement_mm(e);
        positions.push_back(lattice_from_world_vector(grid, x));
    });
    return positions;
}

/// Largest penetration of two elements [mm], each measured on the axis of the smallest overlap;
/// negative: no overlap.
double deepest_overlap(const std::vector<Vec3d>& p, Vec3d p_spacing, const std::vector<Vec3d>& q,
                       Vec3d q_spacing) {
    double deepest = -1e9;
    for (const Vec3d& a : p)
        for (const Vec3d& b : q) {
            double least = 1e9;
            for (int k = 0; k < 3; ++k)
                least = std::min(least, (p_spacing[k] + q_spacing[k]) / 2 - std::abs(a[k] - b[k]));
            deepest = std::max(deepest, least);
        }
    return deepest;
}

double deepest_overlap(const ChainMail& p, const ChainMail& q) {
    return deepest_overlap(places_of(p), p.volume().grid.spacing_mm, places_of(q),
                           q.volume().grid.spacing_mm);
}

TEST(Contact, OverlapTimesOfOneAxisAreExact) {
    const auto equal = [](OverlapTime t, Ratio enter, Ratio leave) {
        return t.enter == enter && t.leave == leave;
    };
    // Moved by 10 from the start: contact at 30 − 20, separation at 30 + 20.
    EXPECT_TRUE(equal(overlap_time(-30, 20, 100, 100), {10, 100}, {50, 100}));
    EXPECT_TRUE(equal(overlap_time(30, 20, 100, -100), {10, 100}, {50, 100}));
    EXPECT_TRUE(equal(overlap_time(-30, 20, 60, 100), {50, 100}, {90, 100})) << "moves later";
    EXPECT_TRUE(equal(overlap_time(-30, 20, 10, 100), kAfter, kAfter)) << "only touches";
    EXPECT_TRUE(equal(overlap_time(-30, 20, 11, 100), {99, 100}, kAfter));
    EXPECT_TRUE(equal(overlap_time(30, 20, 100, 100), kAfter, kAfter)) << "moves away";
    EXPECT_TRUE(equal(overlap_time(5, 20, 100, 100), kBefore, {15, 100}));
    EXPECT_TRUE(equal(overlap_time(5, 20, 0, 0), kBefore, kAfter));
    EXPECT_TRUE(equal(overlap_time(20, 20, 0, 0), kAfter, kAfter));
    EXPECT_EQ(ratio_of({-100, 7, 0}, {1, 3}), (Vec3<Fixed>{-33, 2, 0}));
}

TEST(Contact, BoxesThatPassEachOtherDoNotMeet) {
    // Leaves on x at 0.5 just when it enters on y.
    const Impact pass = impact_of({-30, -70, 0}, {20, 20, 20}, {100, 100, 0}, {100, 100, 0});
    EXPECT_TRUE(pass.enter == pass.leave);
    EXPECT_FALSE(pass.happens());
    EXPECT_TRUE(impact_of({-30, -69, 0}, {20, 20, 20}, {100, 100, 0}, {100, 100, 0}).happens());
}

/// The path in many small steps: the same lattice alone, pushed from the same state to fractions of
/// the push, and tested for overlaps element by element.
struct Reference {
    const ChainMail* other;
    ChainMail alone;

    /// @returns the last fraction k/count before the first overlap; 1: there is none
    double first_overlap(std::span<const Vec3i> elements, Vec3d push_mm, int count) {
        const auto positions = places_of(*other);
        for (int k = 1; k <= count; ++k) {
            const auto report = alone.push_elements(elements, double(k) / count * push_mm);
            EXPECT_TRUE(report.ok());
            const double deep = deepest_overlap(places_of(alone), alone.volume().grid.spacing_mm,
                                                positions, other->volume().grid.spacing_mm);
            if (report->moved_elements > 0) {
                EXPECT_TRUE(alone.undo().ok());
            }
            if (deep > 1e-5) return double(k - 1) / count;
            if (report->step_fraction < 1) return report->step_fraction * k / count;
        }
        return 1;
    }
};

/// A grid of the random instance, but of the given size and directions.
Volume random_object(Random& random, const Volume& labels, const Mat3d& direction,
                     Vec3d position_mm) {
    Volume volume = labels;
    volume.grid.direction = direction;
    volume.grid.origin_mm = direction * position_mm;
    for (int a = 0; a < 3; ++a) volume.grid.spacing_mm[a] = random.real(0.8, 1.6);
    return volume;
}

struct Counts {
    int stopped = 0, as_sub_steps = 0;
};

void run_scene(std::uint64_t seed, Counts& counts) {
    Random random(seed);
    const TaskArena arena(2);
    const Mat3d direction = random.rotation(random.whole(0, 1));
    const Instance own = random_instance(random, 3, 5, false);
    const Instance theirs = random_instance(random, 3, 5, false);
    const Volume second = random_object(random, theirs.volume, direction, {0, 0, 0});
    Volume first = random_object(random, own.volume, direction, {0, 0, 0});
    // Beside the other one on a random axis, with a small gap, and shifted along its face.
    const int axis = random.whole(0, 2), side = random.whole(0, 1) ? 1 : -1;
    Vec3d place = random.vector(2);
    const double width = side > 0 ? second.grid.size[axis] * second.grid.spacing_mm[axis]
                                  : first.grid.size[axis] * first.grid.spacing_mm[axis];
    const double half = (first.grid.spacing_mm[axis] - second.grid.spacing_mm[axis]) / 2;
    place[axis] = side > 0 ? width + half : half - width;
    place[axis] += side * random.real(0, 1.5);
    first.grid.origin_mm = direction * place;
    ChainMailSettings settings;
    settings.air_threshold_hu = -2000;
    settings.custom_law = own.law;
    settings.brick_size = random.whole(2, 8);
    settings.bounded = true;
    ObjectSpace space(arena);
    const bool free = random.whole(0, 1);
    const auto pushed = space.add_object(first, settings, free);
    ASSERT_TRUE(pushed.ok()) << pushed.error().message;
    ChainMailSettings their_settings = settings;
    their_settings.custom_law = theirs.law;
    const auto other = space.add_object(second, their_settings, false);
    ASSERT_TRUE(other.ok()) << other.error().message;
    Reference reference{&space.object(*other),
                        std::move(ChainMail::create(first, settings, arena)).value()};
    for (int step = 0; step < 4; ++step) {
        const std::vector<Vec3i> grabbed = random_grab(random, first.grid);
        Vec3d push = random.vector(2);
        push[axis] -= side * random.real(0, 5);
        const Vec3d push_mm = direction * push;
        constexpr int kSubSteps = 60;
        const double expected = reference.first_overlap(grabbed, push_mm, kSubSteps);
        const Vec3d before = space.displacement_mm(0, grabbed[0]);
        const auto report = space.push_elements(0, grabbed, push_mm);
        ASSERT_TRUE(report.ok());
        if (expected == 1) {
            // Sub-steps can skip a corner that the exact path touches.
            ASSERT_EQ(report->object >= 0, report->push.step_fraction < 1);
        } else {
            ASSERT_LE(report->push.step_fraction, expected + 1.0 / kSubSteps + 1e-6);
        }
        if (report->push.step_fraction < expected - 1e-6) {
            // Stopped before the sub-steps detect an overlap: by a corner between two of them.
            ASSERT_EQ(report->push.limited_by, LimitedBy::Wall);
        }
        const double deepest = deepest_overlap(space.object(0), space.object(1));
        ASSERT_LT(deepest, 1e-5);
        if (report->object >= 0) {
            ASSERT_GT(deepest, -1e-5) << "stopped before anything touched";
            ++counts.stopped;
            counts.as_sub_steps += report->push.step_fraction >= expected - 1e-6;
        }
        const Vec3d done = space.displacement_mm(0, grabbed[0]) - before;
        ASSERT_NEAR(norm(done - report->push.step_fraction * push_mm), 0, 4 * kUnitMm);
        ASSERT_TRUE(reference.alone.push_elements(grabbed, done).ok());
        double apart = 0;
        for_each_element(first.grid, [&](Vec3i e) {
            apart = std::max(
                apart, norm(reference.alone.displacement_mm(e) - space.displacement_mm(0, e)));
        });
        ASSERT_LT(apart, 12 * kUnitMm) << "the part done is not what a push of that part does";
        ASSERT_LT(space.object(0).state().max_violation_mm, 1e-9);
    }
}

TEST(Objects, StopWhereManySmallStepsWouldStop) {
    Counts counts;
    for (std::uint64_t n = 0; n < 50 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kObjectsSeed + n));
        run_scene(kObjectsSeed + n, counts);
    }
    EXPECT_GT(counts.stopped, 50);
    EXPECT_GT(counts.as_sub_steps, counts.stopped * 9 / 10) << "of " << counts.stopped;
}

class ObjectsTest : public ::testing::Test {
  protected:
    ChainMailSettings soft() const {
        ChainMailSettings settings;
        settings.custom_law = [](int) {
            return ElementLimits{{.2, .2, .2}, {.2, .2, .2}, {.2, .2, .2}, 500, false};
        };
        return settings;
    }
    int add(const Volume& volume, bool free) {
        const auto added = space.add_object(volume, soft(), free);
        EXPECT_TRUE(added.ok()) << added.error().message;
        return added.ok() ? *added : -1;
    }
    TaskArena arena{2};
    ObjectSpace space{arena};
};

TEST_F(ObjectsTest, PushStopsAtTheUnitWhereTheFacesTouch) {
    const int fragment = add(block_at({0, 0, 0}, {4, 4, 4}), true);
    const int tissue = add(block_at({9, -3, -3}, {10, 10, 10}), false);
    // Right faces at 3.5, left face at 8.5.
    const std::vector<Vec3i> face = {{3, 0, 0}, {3, 3, 0}, {3, 0, 3}, {3, 3, 3}};
    const auto report = space.push_elements(fragment, face, {20, 0, 0});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->push.status, PushStatus::Limited);
    EXPECT_EQ(report->push.limited_by, LimitedBy::Wall);
    EXPECT_EQ(report->object, tissue);
    EXPECT_EQ(report->element.x, 3);
    EXPECT_EQ(report->other_element.x, 0);
    // The sum of two boxes is two units below their spacing, to tolerate rounding.
    EXPECT_NEAR(space.position_mm(fragment, {3, 0, 0}).x, 8 + 2 * kUnitMm, 1e-9);
    const auto again = space.push_elements(fragment, face, {kUnitMm, 0, 0});
    EXPECT_EQ(again->push.status, PushStatus::Rejected);
    EXPECT_EQ(again->push.limited_by, LimitedBy::Wall);
    EXPECT_EQ(space.object(tissue).state().moved_elements, 0);
}

TEST_F(ObjectsTest, FastFragmentDoesNotTunnelThroughAThinWallOfTissue) {
    const int fragment = add(block_at({0, 0, 0}, {3, 3, 3}), true);
    add(block_at({6, -3, -3}, {1, 9, 9}), false);
    const std::vector<Vec3i> all = {{0, 0, 0}, {2, 2, 2}, {1, 1, 1}};
    const auto report = space.push_elements(fragment, all, {250, 3, -3});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->push.limited_by, LimitedBy::Wall);
    EXPECT_LT(space.position_mm(fragment, {2, 1, 1}).x, 5 + 1e-5);
}

TEST_F(ObjectsTest, WallsStopAsFacesDoAndLetGoAgain) {
    const int fragment = add(block_at({0, 0, 0}, {4, 4, 4}), true);
    const auto wall = space.add_wall({.point_mm = {0, 7.25, 0}, .axis = 1, .side = -1});
    ASSERT_TRUE(wall.ok()) << wall.error().message;
    const std::vector<Vec3i> one = {{1, 1, 1}};
    const auto report = space.push_elements(fragment, one, {0, 30, 0});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->push.limited_by, LimitedBy::Wall);
    EXPECT_EQ(report->wall, *wall);
    EXPECT_EQ(report->object, -1);
    double highest = -1e9;
    for_each_element(space.object(fragment).volume().grid, [&](Vec3i e) {
        highest = std::max(highest, space.position_mm(fragment, e).y);
    });
    EXPECT_NEAR(highest, 6.75 + kUnitMm, 1e-9);
    EXPECT_EQ(space.push_elements(fragment, one, {3, -2, 1})->push.status, PushStatus::Applied);
}

TEST_F(ObjectsTest, FreeFragmentGoesAnywhereAndKeepsItsShape) {
    const int fragment = add(block_at({1, 2, 3}, {5, 4, 3}), true);
    const std::vector<Vec3i> one = {{0, 0, 0}};
    for (int n = 0; n < 30; ++n)
        ASSERT_EQ(space.push_elements(fragment, one, {90, -40, 10})->push.status,
                  PushStatus::Applied);
    EXPECT_NEAR(norm(space.displacement_mm(fragment, {0, 0, 0}) - Vec3d{2700, -1200, 300}), 0,
                1e-3);
    const Vec3d stretched =
        space.position_mm(fragment, {4, 3, 2}) - space.position_mm(fragment, {0, 0, 0});
    EXPECT_LT(norm(stretched - Vec3d{4, 3, 2}), 4) << "more than all links of it allow";
    EXPECT_LT(space.object(fragment).state().max_violation_mm, 1e-9);
    // A tool finds it at its new position.
    const auto report = space.push(
        fragment, {.point_mm = space.position_mm(fragment, {2, 2, 1}), .push_mm = {0, 0, 1}});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->push.grabbed_elements, 8);
}

TEST_F(ObjectsTest, AirOfAnObjectIsNoObstacle) {
    Volume hollow = block_at({0, 0, 0}, {12, 12, 12}, -1000);
    auto& voxels = *std::get_if<0>(&hollow.voxels);
    for_each_element(hollow.grid, [&](Vec3i e) {
        if (e.x == 0 || e.x == 11) voxels[voxel_index(hollow.grid, e)] = 40;
    });
    const int tissue = add(hollow, false);
    const int fragment = add(block_at({3, 5, 5}, {2, 2, 2}), true);
    EXPECT_FALSE(space.is_solid(tissue, {5, 5, 5}));
    EXPECT_TRUE(space.is_solid(tissue, {11, 5, 5}));
    const std::vector<Vec3i> all = {{1, 0, 0}, {1, 1, 0}, {1, 0, 1}, {1, 1, 1}};
    const auto report = space.push_elements(fragment, all, {9, 0, 0});
    EXPECT_EQ(report->push.limited_by, LimitedBy::Wall);
    EXPECT_NEAR(space.position_mm(fragment, {1, 0, 0}).x, 10, 1e-5);
}

TEST_F(ObjectsTest, FixedElementsStillStopTheirOwnObject) {
    Volume held = block_at({0, 0, 0}, {8, 4, 4});
    (*std::get_if<0>(&held.voxels))[voxel_index(held.grid, {7, 2, 2})] = 1200;
    const auto tissue = space.add_object(held, {}, false);
    const auto freed = space.add_object(
        [&] {
            held.grid.origin_mm = {0, 50, 0};
            return held;
        }(),
        {}, true);
    ASSERT_TRUE(tissue.ok() && freed.ok());
    const std::vector<Vec3i> one = {{0, 0, 0}};
    EXPECT_EQ(space.push_elements(*tissue, one, {-9, 0, 0})->push.limited_by, LimitedBy::Bone);
    EXPECT_EQ(space.push_elements(*freed, one, {-9, 0, 0})->push.status, PushStatus::Applied);
}

TEST_F(ObjectsTest, WhatDoesNotFitIsRefused) {
    add(block_at({0, 0, 0}, {4, 4, 4}), false);
    const auto overlap = space.add_object(block_at({3, 3, 3}, {4, 4, 4}), soft(), true);
    ASSERT_FALSE(overlap.ok());
    EXPECT_NE(overlap.error().message.find("overlaps object 0"), std::string::npos);
    EXPECT_TRUE(space.add_object(block_at({4, 0, 0}, {4, 4, 4}), soft(), true).ok())
        << "side by side";
    Volume turned = block_at({50, 0, 0}, {4, 4, 4});
    turned.grid.direction.columns[0] = {0, 1, 0};
    turned.grid.direction.columns[1] = {-1, 0, 0};
    EXPECT_NE(space.add_object(turned, soft(), true).error().message.find("same directions"),
              std::string::npos);
    EXPECT_NE(space.add_wall({{3, 0, 0}, 0, 1}).error().message.find("nothing behind it"),
              std::string::npos);
    EXPECT_FALSE(space.add_wall({{-9, 0, 0}, 3, 1}).ok());
    EXPECT_TRUE(space.add_wall({{-9, 0, 0}, 0, 1}).ok());
    EXPECT_NE(space.add_object(block_at({-11, 0, 0}, {4, 4, 4}), soft(), true)
                  .error()
                  .message.find("behind wall 0"),
              std::string::npos);
    EXPECT_FALSE(space.push_elements(7, {}, {1, 0, 0}).ok());
    EXPECT_FALSE(space.push_elements(0, {}, {301, 0, 0}).ok());
    EXPECT_FALSE(space.push(0, {.push_mm = {NAN, 0, 0}}).ok());
    EXPECT_EQ(space.object_count(), 2);
}

TEST_F(ObjectsTest, ResultIsTheSameForAnyThreadsAndBrickSize) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4})
        for (const int brick_size : {3, 8}) {
            const TaskArena own_arena(threads);
            ObjectSpace own(own_arena);
            ChainMailSettings settings = soft();
            settings.brick_size = brick_size;
            ASSERT_TRUE(own.add_object(block_at({0, 0, 0}, {9, 9, 9}), settings, true).ok());
            ASSERT_TRUE(own.add_object(block_at({10, -2, 3}, {14, 14, 14}), settings, false).ok());
            const std::vector<Vec3i> one = {{2, 3, 4}};
            for (const Vec3d push : {Vec3d{4, 1, 0}, {6, -2, 5}, {9, 3, -4}})
                ASSERT_TRUE(own.push_elements(0, one, push).ok());
            hashes.push_back(own.object(0).hash());
        }
    for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes.front());
}

}  // namespace
}  // namespace pliant::test
