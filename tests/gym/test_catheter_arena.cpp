// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Catheters in an arena: the same bits for any number of threads, wires that are never beyond the
// wall, calls that fail without an effect, and shadows that weigh what they should.
// Covers: gym/device_shadow.cpp.

#include <gtest/gtest.h>
#include <pliant/data/gym.h>
#include <pliant/models/scene_files.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>

#include "gym/device_shadow.h"
#include "support/inside.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using std::numbers::pi;

const VesselWall& bend() {
    static const VesselWall wall = made(swept_tube(made(phantom_centreline("bend")).branches[0],
                                                   {.thickness_mm = 1.5, .layers = 1}));
    return wall;
}
const Volume& bend_scan() {
    static const Volume scan = made(scan_of_vessel(bend(), TaskArena(2)));
    return scan;
}

CatheterArenaSettings in_bend(int count, WallModel model) {
    CatheterArenaSettings s;
    s.count = count;
    s.width = 20;
    s.height = 24;
    s.control_hz = 10;
    s.view = {.centre_mm = {20, 0, 60}, .width_mm = 150, .noise = 0.5};
    s.bend_rad = 1;
    s.catheter.catheter = {.length_mm = 160, .segment_mm = 4, .tip_mm = 20, .mass_g_mm = 0.01};
    s.catheter.wall.model = model;
    s.catheter.wall.density_g_mm3 = 0.05;
    s.catheter.entry = {{0, 0, 4}, {0, 0, 1}, 5};
    s.catheter.time_step_s = 0.006;
    s.catheter.box_mm = 6;
    s.catheter.reach_mm = 1;
    return s;
}

std::unique_ptr<CatheterArena> arena_in_bend(const CatheterArenaSettings& s,
                                             const TaskArena& threads) {
    auto arena = made(CatheterArena::create(bend(), bend_scan(), s, threads));
    for (int n = 0; n < s.count; ++n) EXPECT_TRUE(arena->place(n, 0.5 * n).ok());
    EXPECT_TRUE(arena->look().ok());
    return arena;
}

/// Mostly ahead.
std::vector<double> random_hands(Random& random, int count) {
    std::vector<double> actions;
    for (int n = 0; n < count; ++n)
        for (const double a : {random.real(-40, 60), random.real(-3, 3), random.real(-1.5, 1.5)})
            actions.push_back(a);
    return actions;
}

template <class T>
void append(std::vector<double>& all, std::span<const T> values) {
    for (const T& value : values) all.push_back(double(value));
}
std::vector<double> result_of(const CatheterArena& arena) {
    std::vector<double> all;
    append(all, arena.pictures());
    append(all, arena.points());
    for (int n = 0; n < arena.count(); ++n) {
        const CatheterArenaState& s = arena.state(n);
        for (const double number :
             {s.tip_mm.x, s.tip_mm.y, s.tip_mm.z, s.inserted_mm, s.rotated_rad, s.bend_rad,
              s.wall_force_n, s.max_displacement_mm, double(arena.hash(n) >> 12)})
            all.push_back(number);
    }
    return all;
}

TEST(CatheterArena, GivesTheSameBitsForAnyNumberOfThreadsAndCatheters) {
    for (const WallModel model : {WallModel::Solid, WallModel::Rigid}) {
        SCOPED_TRACE(model == WallModel::Solid ? "deforming, seed 3" : "rigid, seed 3");
        const TaskArena one(1), two(2), three(3), five(5);
        std::vector<std::vector<double>> first;
        for (const TaskArena* threads : {&one, &two, &three, &five}) {
            const auto arena = arena_in_bend(in_bend(3, model), *threads);
            Random random(3);
            for (std::size_t step = 0; step < 12; ++step) {
                const Status s = arena->step(random_hands(random, 3));
                ASSERT_TRUE(s.ok()) << s.error().message;
                if (threads == &one)
                    first.push_back(result_of(*arena));
                else
                    ASSERT_EQ(result_of(*arena), first[step]) << "step " << step;
            }
            EXPECT_NE(arena->hash(0), arena->hash(1));
        }
        // The second catheter alone.
        const auto all = arena_in_bend(in_bend(3, model), two);
        const auto alone = made(CatheterArena::create(bend(), bend_scan(), in_bend(1, model), two));
        ASSERT_TRUE(alone->place(0, 0.5).ok());
        Random random(3);
        for (int step = 0; step < 8; ++step) {
            const auto actions = random_hands(random, 3);
            ASSERT_TRUE(all->step(actions).ok());
            ASSERT_TRUE(alone->step(std::span(actions).subspan(3, 3)).ok());
            EXPECT_EQ(all->hash(1), alone->hash(0));
        }
    }
}

/// How far the wire's axis is inside of the wall's surface at least; all triangles are asked.
double least_inside(const CatheterScene& scene) {
    const auto surface = scene.ghost_positions();
    const auto x = scene.wire_positions();
    double least = 1e9;
    for (auto s = std::size_t(scene.first_inserted()); s + 1 < x.size(); ++s)
        for (int k = 1; k <= 4; ++k) {
            const Vec3d p = (1 - k / 4.0) * x[s] + (k / 4.0) * x[s + 1];
            if (p.z < 4) continue;  // in the guide
            least = std::min(least, inside_by(p, surface, scene.wall().ghost));
        }
    return least;
}

TEST(CatheterArena, NothingSlipsThroughTheWall) {
    const TaskArena threads(2);
    for (const WallModel model : {WallModel::Solid, WallModel::Rigid}) {
        const auto settings = in_bend(3, model);
        const auto arena = arena_in_bend(settings, threads);
        Random random(17);
        double least = 1e9, force = 0, moved = 0;
        for (int step = 0; step < 40; ++step) {
            auto actions = random_hands(random, 3);
            if (step % 20 < 12)
                for (std::size_t n = 0; n < 3; ++n) actions[3 * n] = 60;  // against the bend
            const Status s = arena->step(actions);
            ASSERT_TRUE(s.ok()) << s.error().message;
            for (int n = 0; n < 3; ++n) {
                const CatheterArenaState& state = arena->state(n);
                force = std::max(force, state.wall_force_n);
                moved = std::max(moved, state.max_displacement_mm);
                EXPECT_LT(state.depth_mm, 0.1);
                if (step % 12 == 11 && state.left_end == 0)
                    least = std::min(least, least_inside(arena->scene(n)));
            }
        }
        SCOPED_TRACE(model == WallModel::Solid ? "deforming, seed 17" : "rigid, seed 17");
        EXPECT_GT(least, settings.catheter.catheter.radius_mm - 0.1);
        EXPECT_GT(force, 0.01);  // it has been pressed to the wall
        if (model == WallModel::Rigid) {
            EXPECT_EQ(moved, 0);
            const auto wall = arena->scene(0).wall_positions();  // floats
            for (std::size_t n = 0; n < wall.size(); ++n)
                EXPECT_LT(norm(wall[n] - bend().mesh.nodes_mm[n]), 1e-5);
        } else {
            EXPECT_GT(moved, 1e-3);
        }
    }
}

TEST(CatheterArena, ARigidWallIsTheLimitOfStiffOnes) {
    const TaskArena threads(2);
    std::vector<std::vector<Vec3d>> wires;
    for (const double young_modulus_pa : {1e5, 1e7, 0.0}) {
        CatheterArenaSettings s =
            in_bend(1, young_modulus_pa > 0 ? WallModel::Solid : WallModel::Rigid);
        s.catheter.catheter.bend_n_mm2 = 200;  // a stiff wire
        s.catheter.catheter.tip_bend_n_mm2 = 20;
        s.catheter.catheter.friction = 0;
        s.catheter.wall.support_pa_per_mm = young_modulus_pa / 50;
        if (young_modulus_pa > 0) s.catheter.wall.young_modulus_pa = young_modulus_pa;
        s.catheter.time_step_s = 0.001;
        s.has_pictures = false;
        s.bend_rad = 0;
        const auto arena = arena_in_bend(s, threads);
        for (int step = 0; step < 22; ++step)
            ASSERT_TRUE(arena->step(std::vector<double>{step < 18 ? 60.0 : 0.0, 0, 0}).ok());
        const auto x = arena->scene(0).wire_positions();
        wires.push_back({x.begin(), x.end()});
    }
    const auto apart = [&](std::size_t n) {
        double most = 0;
        for (std::size_t k = 0; k < wires[2].size(); ++k)
            most = std::max(most, norm(wires[n][k] - wires[2][k]));
        return most;
    };
    EXPECT_LT(apart(1), 0.1);
    EXPECT_GT(apart(0), 3 * apart(1));
}

TEST(CatheterArena, StepsThatFailChangeNothing) {
    const TaskArena threads(2);
    for (const WallModel model : {WallModel::Solid, WallModel::Rigid}) {
        // A host that interrupts a later loop: each of them in turn.
        std::atomic<int> left{-1};
        HostJobs jobs;
        jobs.give_up = [&] { return left > 0 && --left == 0; };
        const TaskArena host(jobs);
        const auto arena = arena_in_bend(in_bend(2, model), host);
        const auto straight = arena_in_bend(in_bend(2, model), threads);
        const std::vector<double> ahead{60, 1, 0, 30, -1, 0};
        for (int n = 0; n < 8; ++n) ASSERT_TRUE(arena->step(ahead).ok());
        for (int n = 0; n < 8; ++n) ASSERT_TRUE(straight->step(ahead).ok());
        const std::uint64_t before[] = {arena->hash(0), arena->hash(1)};
        int failed = 0;
        for (const int loops : {1, 2, 3, 5}) {
            left = loops;
            const Status s = arena->step(ahead);
            left = -1;
            if (s.ok()) break;
            ++failed;
            EXPECT_EQ(s.error().code, ErrorCode::LimitExceeded);
            for (int n = 0; n < 2; ++n) EXPECT_EQ(arena->hash(n), before[n]);
        }
        EXPECT_GE(failed, 3);
        for (auto& [actions, message] : std::vector<std::pair<std::vector<double>, std::string>>{
                 {{1, 2, 3}, "actions: expected 6 numbers, found 3"},
                 {{0, 0, std::nan(""), 0, 0, 0}, "actions: expected finite numbers"},
                 {{2000, 0, 0, 0, 0, 0}, "actions: expected speeds of at most 1000"}}) {
            const Status s = arena->step(actions);
            ASSERT_FALSE(s.ok());
            EXPECT_EQ(s.error().message.rfind(message, 0), 0U) << s.error().message;
        }
        EXPECT_FALSE(arena->step(ahead, std::vector<std::uint8_t>{1}).ok());
        ASSERT_TRUE(arena->step(ahead).ok());
        ASSERT_TRUE(straight->step(ahead).ok());
        for (int n = 0; n < 2; ++n) EXPECT_EQ(arena->hash(n), straight->hash(n));
    }
}

TEST(CatheterArena, OthersStayWhileSomeMove) {
    const TaskArena threads(2);
    const auto arena = arena_in_bend(in_bend(2, WallModel::Rigid), threads);
    const std::uint64_t before = arena->hash(0);
    const std::vector<double> ahead{60, 1, 0, 30, -1, 0};
    ASSERT_TRUE(arena->step(ahead, std::vector<std::uint8_t>{0, 1}).ok());
    EXPECT_EQ(arena->hash(0), before);
    EXPECT_NEAR(arena->state(1).inserted_mm, 8, 1e-9);
    EXPECT_EQ(arena->state(1).steps, 1);
}

TEST(CatheterArena, ContinuesFromASavedState) {
    const TaskArena threads(2);
    for (const WallModel model : {WallModel::Solid, WallModel::Rigid}) {
        const auto arena = arena_in_bend(in_bend(1, model), threads);
        Random random(5);
        for (int n = 0; n < 10; ++n) ASSERT_TRUE(arena->step(random_hands(random, 1)).ok());
        const auto saved = made(arena->save_state(0));
        const auto actions = random_hands(random, 1);
        ASSERT_TRUE(arena->step(actions).ok());
        const auto result = result_of(*arena);
        ASSERT_TRUE(arena->place(0, 1).ok());
        ASSERT_TRUE(arena->load_state(0, saved).ok());
        ASSERT_TRUE(arena->step(actions).ok());
        EXPECT_EQ(result_of(*arena), result);
        const std::uint64_t before = arena->hash(0);
        EXPECT_FALSE(arena->load_state(0, std::span(saved).first(20)).ok());
        EXPECT_EQ(arena->hash(0), before);
    }
}

TEST(CatheterArena, ATipThatHasLeftIsNotPushedFurther) {
    const TaskArena threads(1);
    auto settings = in_bend(1, WallModel::Rigid);
    settings.bend_rad = 0.3;
    const auto arena = arena_in_bend(settings, threads);
    const std::vector<double> ahead{60, 0, 0};
    for (int n = 0; n < 40 && arena->state(0).left_end == 0; ++n)
        ASSERT_TRUE(arena->step(ahead).ok());
    ASSERT_GT(arena->state(0).left_end, 0);
    const double inserted = arena->state(0).inserted_mm;
    ASSERT_TRUE(arena->step(ahead).ok());
    EXPECT_LT(arena->state(0).inserted_mm, inserted + 1);
    for (int n = 0; n < 3; ++n) ASSERT_TRUE(arena->step(std::vector<double>{-60, 0, 0}).ok());
    EXPECT_EQ(arena->state(0).left_end, 0);
}

TEST(CatheterArena, BadSettingsAreNamed) {
    const TaskArena threads(1);
    const auto refused = [&](auto change) {
        CatheterArenaSettings s = in_bend(1, WallModel::Rigid);
        change(s);
        auto made = CatheterArena::create(bend(), bend_scan(), s, threads);
        return made.ok() ? std::string() : made.error().message;
    };
    EXPECT_EQ(refused([](auto& s) { s.count = 0; }), "count: expected a number 1 to 4096, found 0");
    EXPECT_NE(refused([](auto& s) { s.bend_rad = 7; }).find("bend_rad"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.view.look = {0, 0, 0}; }).find("look"), std::string::npos);
    EXPECT_NE(refused([](auto& s) {
                  s.catheter.entry.position_mm = {50, 50, 0};
              }).find("place_mm"),
              std::string::npos);
}

TEST(CatheterArena, TrackedPointsAreEvenAlongTheWire) {
    const TaskArena threads(1);
    auto settings = in_bend(1, WallModel::Rigid);
    settings.points = 30;
    const auto arena = arena_in_bend(settings, threads);
    for (int n = 0; n < 12; ++n) ASSERT_TRUE(arena->step(std::vector<double>{60, 0, 0}).ok());
    const auto p = arena->points();
    ASSERT_EQ(p.size(), 60U);
    const auto tip = arena->project(arena->state(0).tip_mm);
    EXPECT_NEAR(p[0], tip[0], 1e-3);
    EXPECT_NEAR(p[1], tip[1], 1e-3);
    // In a plane across the rays, distances are those in space, magnified.
    for (std::size_t n = 1; n < 14; ++n) {
        const double step = std::hypot(p[2 * n] - p[2 * n - 2], p[2 * n + 1] - p[2 * n - 1]);
        EXPECT_GT(step, 3.5);
        EXPECT_LT(step, 5.1);
    }
    // 77 mm are inserted: the last points are the guide's end.
    const auto guide = arena->project({0, 0, 4});
    for (std::size_t n = 20; n < 30; ++n) {
        EXPECT_NEAR(p[2 * n], guide[0], 1e-3);
        EXPECT_NEAR(p[2 * n + 1], guide[1], 1e-3);
    }
    const auto centre = arena->project({20, 0, 60}), right = arena->project({30, 0, 60}),
               up = arena->project({20, 0, 70}), near = arena->project({30, -500, 60});
    EXPECT_NEAR(centre[0], 0, 1e-9);
    EXPECT_NEAR(centre[1], 0, 1e-9);
    EXPECT_NEAR(right[0], 10, 1e-9);
    EXPECT_NEAR(up[1], 10, 1e-9);
    EXPECT_NEAR(near[0], 20, 1e-9);  // half as far from the source
    EXPECT_FALSE(std::isfinite(arena->project({20, -2000, 60})[0]));
}

TEST(DeviceShadow, WeighsAsMuchAsTheWire) {
    const std::vector<Vec3d> wire{{-30, 0, -20}, {0, 0, 10}, {30, 0, 15}};
    const double length = std::hypot(30, 30) + std::hypot(30, 5);
    for (const int width : {25, 100, 400})
        for (const double radius : {0.3, 1.5}) {
            SCOPED_TRACE(std::to_string(width) + " pixels, radius " + std::to_string(radius));
            const gym::XRay rays({.centre_mm = {0, 0, 0}, .width_mm = 100}, width, width);
            std::vector<gym::NearWire> scratch;
            std::vector<float> water(std::size_t(width) * std::size_t(width));
            rays.add_wire(wire, radius, 20, scratch, water);
            const double pixel = 100.0 / width;
            const double sum = std::accumulate(water.begin(), water.end(), 0.0) * pixel * pixel;
            // At the ends, the nearest distance is used.
            const double ends = (pixel + radius) / length;
            EXPECT_NEAR(sum / (20 * pi * radius * radius * length), 1, 0.01 + ends);
        }
    // In the middle of a wide wire, the chord is the diameter.
    const gym::XRay rays({.centre_mm = {0, 0, 0}, .width_mm = 100}, 401, 401);
    std::vector<gym::NearWire> scratch;
    std::vector<float> water(401 * 401);
    rays.add_wire(std::vector<Vec3d>{{-30, 0, 0}, {30, 0, 0}}, 4, 1, scratch, water);
    EXPECT_NEAR(water[200 * 401 + 200], 8, 0.01);
    EXPECT_EQ(water[100 * 401 + 200], 0);
}

}  // namespace
}  // namespace pliant::test
