// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each allocation of a step, a restore and a create fails once: the call returns an error, the
// scene is as before to the bit, and goes on as its twin does that nothing happened to.
// Covers: catheter/scene.cpp, catheter/vessel_file.cpp, catheter/carried_scan.cpp.

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "support/each_allocation_of.h"
#include "support/inside.h"
#include "support/made.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

VesselWall tube() {
    const auto way = bent_way({.inner_mm = 4,
                               .from_mm = 0,
                               .to_mm = 20,
                               .radius_mm = 25,
                               .angle_rad = std::numbers::pi / 2,
                               .last_mm = 15});
    return made(swept_tube(way, {.thickness_mm = 1.2, .layers = 2, .sectors = 10}));
}

CatheterSettings short_catheter(bool local) {
    CatheterSettings s;
    s.local = local;
    s.catheter.length_mm = 90;
    s.catheter.radius_mm = 0.8;
    s.catheter.twist_n_mm2 = 14;
    s.catheter.tip_bend_n_mm2 = 4;
    s.entry = {{0, 0, 4}, {0, 0, 1}, 5};
    return s;
}

/// All that a scene tells of itself.
struct Seen {
    std::uint64_t hash;
    std::vector<double> state, measures;
    std::vector<Vec3d> wire, wall;
    Rotation tip;
    CatheterCommand hand;
    std::int32_t first;
    friend bool operator==(const Seen& a, const Seen& b) {
        return a.hash == b.hash && a.state == b.state && a.measures == b.measures &&
               a.wire == b.wire && a.wall == b.wall && a.tip.w == b.tip.w && a.hand == b.hand &&
               a.first == b.first;
    }
};

Seen seen(const CatheterScene& scene) {
    const CatheterMeasures m = scene.measures();
    return {scene.hash(),
            scene.state(),
            {double(m.steps), m.time_s, m.inserted_mm, m.rotated_deg, m.force_n, m.torque_n_mm,
             m.contact_n, m.wall_moved_mm, m.depth_mm, m.wire_energy_mj, m.wall_energy_mj,
             m.kinetic_energy_mj, m.volume.total, m.volume.mean, m.volume.largest,
             double(m.inverted), double(m.active_tetrahedra), double(m.left_end)},
            {scene.wire_positions().begin(), scene.wire_positions().end()},
            scene.wall_positions(),
            scene.tip_frame(),
            scene.hand(),
            scene.first_inserted()};
}

/// A scene that can be made again and again: a state, and steps that were made since.
struct Prepared {
    std::string name;
    CatheterSettings settings;
    std::vector<double> state;  ///< empty: the first one
    int steps = 0;
    bool is_short = false;  ///< there was too little memory to find contact anew after the restore

    std::unique_ptr<CatheterScene> make(const VesselWall& wall, const TaskArena& arena) const {
        auto scene = std::make_unique<CatheterScene>(made(CatheterScene::create(wall, settings)));
        for (std::int64_t n = is_short ? 0 : 1000000; !state.empty(); ++n) {
            const FailingAllocation failing(n);
            if (scene->restore(state, arena).ok()) break;
        }
        const CatheterCommand command{
            .insert_mm_s = 200, .rotate_deg_s = 90, .bend_first_deg = 20, .bend_second_deg = 0};
        EXPECT_TRUE(scene->command(command).ok());
        EXPECT_TRUE(scene->step(steps, arena).ok());
        return scene;
    }
};

constexpr int kSteps = 4;  ///< so that the state of contact is some steps old

/// Scenes at rest, in contact in the bend, and just before boxes wake up.
std::vector<Prepared> prepared(const VesselWall& wall, bool local, const TaskArena& arena) {
    const std::string name = local ? "local" : "whole wall";
    const CatheterSettings s = short_catheter(local);
    std::vector<Prepared> all{{name + ", first step", s, {}, 0}};
    const auto scene = all[0].make(wall, arena);
    std::vector<std::vector<double>> states;
    std::int32_t active = 0;
    for (int n = 0; n < 260; ++n) {
        states.push_back(scene->state());
        EXPECT_TRUE(scene->step(1, arena).ok());
        const std::int32_t before =
            std::exchange(active, scene->quick_measures().active_tetrahedra);
        if (n < 180 || !(scene->quick_measures().contact_n > 0)) continue;
        const auto& earlier = states[std::size_t(n - kSteps)];
        if (all.size() == 1) {
            all.push_back({name + ", in contact", s, earlier, kSteps});
            all.push_back({name + ", after 19 steps", s, states[std::size_t(n - 19)], 19});
            all.push_back({name + ", restored", s, earlier, 0});
            all.push_back({name + ", restored without contact", s, earlier, 0, true});
        }
        if (local && active != before) {
            all.push_back({name + ", boxes change", s, earlier, kSteps});
            break;
        }
    }
    EXPECT_EQ(all.size(), local ? 6U : 5U);
    return all;
}

/// The first allocations, the last ones, and some in between.
std::vector<std::int64_t> some_of(std::int64_t count) {
    constexpr std::int64_t kFirst = 15, kLast = 45;
    std::vector<std::int64_t> numbers;
    for (const std::int64_t n : chosen(std::max(count - kLast, std::min(count, kFirst)),
                                       {.all_up_to = kFirst, .of_the_rest = 10, .seed = 3}))
        numbers.push_back(n);
    for (std::int64_t n = std::max(kFirst, count - kLast); n < count; ++n) numbers.push_back(n);
    return numbers;
}

/// Fails one allocation of a step. @returns whether the step failed
bool fail_one(CatheterScene& scene, std::int64_t n, const TaskArena& arena) {
    bool has_failed = false;
    Status status = Ok{};
    {
        const FailingAllocation failing(n);
        status = scene.step(1, arena);
        has_failed = failing.has_failed();
    }
    EXPECT_TRUE(has_failed || status.ok());
    if (!status.ok()) {
        EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(status.error().message, "out of memory");
    }
    return !status.ok();
}

void expect_steps_are_all_or_nothing(const VesselWall& wall, const Prepared& p,
                                     const TaskArena& arena) {
    constexpr int kLater = 3;
    SCOPED_TRACE(p.name);
    const auto twin = p.make(wall, arena);
    const Seen before = seen(*twin);
    const std::int64_t first = allocation_count();
    ASSERT_TRUE(twin->step(1, arena).ok());
    const std::int64_t count = allocation_count() - first;
    const Seen after = seen(*twin);
    ASSERT_TRUE(twin->step(kLater, arena).ok());
    const Seen later = seen(*twin);
    int failed = 0, again = 0;
    Random random(7);
    for (const std::int64_t n : some_of(count)) {
        SCOPED_TRACE("allocation " + std::to_string(n));
        const auto scene = p.make(wall, arena);
        ASSERT_EQ(seen(*scene), before);
        if (!fail_one(*scene, n, arena)) {
            EXPECT_EQ(seen(*scene), after);
            continue;
        }
        ++failed;
        ASSERT_EQ(seen(*scene), before);
        // Once more: contact has perhaps to be found anew now, which asks for more.
        const bool fails = fail_one(*scene, random.whole(0, 40), arena);
        again += fails;
        ASSERT_EQ(seen(*scene), fails ? before : after);
        ASSERT_TRUE(!fails || scene->step(1, arena).ok());
        EXPECT_EQ(seen(*scene), after);
        ASSERT_TRUE(scene->step(kLater, arena).ok());
        EXPECT_EQ(seen(*scene), later);
    }
    std::printf("%s: %lld allocations, %d failed steps, %d once more\n", p.name.c_str(),
                static_cast<long long>(count), failed, again);
    EXPECT_EQ(failed > 0, count > 0);
}

class CatheterOutOfMemory : public testing::TestWithParam<bool> {};

TEST_P(CatheterOutOfMemory, AStepIsMadeOrNot) {
    const TaskArena arena(1);
    const VesselWall wall = tube();
    for (const Prepared& p : prepared(wall, GetParam(), arena))
        expect_steps_are_all_or_nothing(wall, p, arena);
}

TEST(CatheterOutOfMemoryThreads, AStepOfTwoThreadsIsMadeOrNot) {
    const TaskArena arena(2);
    const VesselWall wall = tube();
    const auto all = prepared(wall, true, arena);
    expect_steps_are_all_or_nothing(wall, all[3], arena);
    expect_steps_are_all_or_nothing(wall, all.back(), arena);
}

TEST_P(CatheterOutOfMemory, ARestoredSceneIsTheOneOrTheOther) {
    const TaskArena arena(1);
    const VesselWall wall = tube();
    const auto all = prepared(wall, GetParam(), arena);
    const auto make = [&] { return all[1].make(wall, arena); };
    for (const Prepared& p : {all[0], all.back()}) {
        SCOPED_TRACE("to " + p.name);
        const std::vector<double> to = p.make(wall, arena)->state();
        const auto restore = [&](CatheterScene& scene) { return scene.restore(to, arena); };
        const Failures f =
            fail_each_allocation(make, restore, seen, {.all_up_to = 40, .of_the_rest = 20});
        std::printf("%s: restore makes %lld allocations, %d failed\n", p.name.c_str(),
                    static_cast<long long>(f.allocations), f.failed);
        // Contact that could not be found at once is found by the next step.
        const auto twin = make(), scene = make();
        ASSERT_TRUE(restore(*twin).ok());
        bool restored = false;
        for (std::int64_t n = 0; !restored; ++n) {
            const FailingAllocation failing(n);
            restored = restore(*scene).ok();
            ASSERT_TRUE(!restored || failing.has_failed());
        }
        ASSERT_TRUE(twin->step(3, arena).ok() && scene->step(3, arena).ok());
        EXPECT_EQ(seen(*scene), seen(*twin));
    }
}

TEST_P(CatheterOutOfMemory, MeasuresAndHashesNeedNoMemory) {
    const TaskArena arena(1);
    const VesselWall wall = tube();
    const auto all = prepared(wall, GetParam(), arena);
    const auto scene = all[1].make(wall, arena);
    const CatheterMeasures expected = scene->measures();
    const std::uint64_t hash = scene->hash();
    {
        const FailingAllocation failing(0);
        const CatheterMeasures found = scene->measures();
        EXPECT_EQ(found.wall_energy_mj, expected.wall_energy_mj);
        EXPECT_EQ(found.wall_moved_mm, expected.wall_moved_mm);
        EXPECT_EQ(found.volume.mean, expected.volume.mean);
        EXPECT_EQ(scene->inverted_tetrahedra(), expected.inverted);
        EXPECT_EQ(scene->hash(), hash);
    }
    // A vector is returned whole or not at all.
    const Seen unchanged = seen(*scene);
    for (std::int64_t n = 0; n < 4; ++n) {
        const FailingAllocation failing(n);
        EXPECT_THROW((void)scene->state(), std::bad_alloc);
    }
    EXPECT_EQ(seen(*scene), unchanged);
}

TEST_P(CatheterOutOfMemory, CreateReturnsAnErrorForEachAllocation) {
    const TaskArena arena(1);
    const VesselWall wall = tube();
    const CatheterSettings s = short_catheter(GetParam());
    using Maybe = std::unique_ptr<CatheterScene>;
    const auto create = [&](Maybe& scene) -> Status {
        // The copy is the caller's.
        VesselWall mine;
        try {
            mine = wall;
        } catch (const std::bad_alloc&) {
            return Error{ErrorCode::LimitExceeded, "out of memory"};
        }
        auto created = CatheterScene::create(std::move(mine), s);
        if (!created) return created.error();
        scene = Maybe(new (std::nothrow) CatheterScene(std::move(*created)));
        return scene ? Status(Ok{}) : Error{ErrorCode::LimitExceeded, "out of memory"};
    };
    const auto hash = [](const Maybe& scene) { return scene ? scene->hash() : 0; };
    const auto f = fail_each_allocation([] { return std::make_unique<Maybe>(); }, create, hash,
                                        {.all_up_to = 100, .of_the_rest = 60});
    std::printf("create makes %lld allocations, %d failed\n", static_cast<long long>(f.allocations),
                f.failed);
}

INSTANTIATE_TEST_SUITE_P(Scenes, CatheterOutOfMemory, testing::Bool(),
                         [](const auto& test) { return test.param ? "Local" : "Whole"; });

TEST(VesselOutOfMemory, FilesScenesAndScansAreErrors) {
    const TaskArena arena(1);
    const TemporaryFolder folder;
    const std::string name =
        folder.write("scene.toml", "[vessel]\nphantom = \"bend\"\nthickness_mm = 2\nlayers = 1\n")
            .string();
    // The file's text and the memory that is seen before it is understood; toml::parse itself ends
    // the process.
    for (std::int64_t n = 0; n < 3; ++n) {
        const FailingAllocation failing(n);
        const auto read = read_vessel_file(name);
        ASSERT_FALSE(read.ok()) << n;
        EXPECT_EQ(read.error().code, ErrorCode::LimitExceeded);
    }
    const VesselFile vessel = made(read_vessel_file(name));
    constexpr EachAllocation kSome{.all_up_to = 30, .of_the_rest = 30};
    const auto of_scene =
        fail_each_allocation_of([&] { return make_vessel(vessel, arena); }, kSome);
    const VesselWall wall = tube();
    const auto of_scan = fail_each_allocation_of([&] { return scan_of_vessel(wall, arena); },
                                                 {.all_up_to = 20, .of_the_rest = 10});
    std::printf("vessel: %lld allocations, %d failed; its scan: %lld, %d failed\n",
                static_cast<long long>(of_scene.allocations), of_scene.failed,
                static_cast<long long>(of_scan.allocations), of_scan.failed);
}

TEST(VesselOutOfMemory, ACarriedScanIsAnError) {
    const TaskArena arena(1);
    const VesselWall wall = tube();
    const Volume scan = made(scan_of_vessel(wall, arena));
    const auto create = [&] { return CarriedScan::create(scan, wall.mesh, {}, arena); };
    const auto of_create = fail_each_allocation_of(create, {.all_up_to = 15, .of_the_rest = 15});
    auto carried = made(create());
    std::vector<Vec3d> moved = wall.mesh.nodes_mm;
    for (Vec3d& p : moved) p.x += 0.5;
    int failed = 0;
    for (std::int64_t n = 0; n < 5; ++n) {
        const FailingAllocation failing(n);
        const Status updated = carried.update(moved);
        failed += !updated.ok();
        EXPECT_TRUE(updated.ok() || updated.error().code == ErrorCode::LimitExceeded);
    }
    EXPECT_GT(failed, 0);
    std::printf("carried scan: %lld allocations, %d failed; updates: %d failed\n",
                static_cast<long long>(of_create.allocations), of_create.failed, failed);
}

}  // namespace
}  // namespace pliant::test
