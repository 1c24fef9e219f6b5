// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Catheters in bent tubes: how deep they are is asked of all triangles, one by one.
// Covers: catheter/reach.cpp, catheter/settings_rows.cpp, scene_files/vessel_phantom.cpp,
// catheter/vessel_script.cpp.

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "support/inside.h"
#include "support/made.h"

namespace pliant::test {
namespace {

using std::numbers::pi;

std::vector<CentrePoint> bent_way() {
    return test::bent_way({.inner_mm = 4,
                           .from_mm = 0,
                           .to_mm = 30,
                           .radius_mm = 25,
                           .angle_rad = 2 * pi / 3,
                           .last_mm = 24});
}
std::vector<Vec3d> places_of(const std::vector<CentrePoint>& way) {
    std::vector<Vec3d> positions;
    for (const CentrePoint& p : way) positions.push_back(p.position_mm);
    return positions;
}
VesselWall bent_tube() {
    return made(swept_tube(bent_way(), {.thickness_mm = 1.2, .layers = 2, .sectors = 12}));
}

CatheterSettings settings(double stiff = 20) {
    CatheterSettings s;
    s.catheter.length_mm = 130;
    s.catheter.radius_mm = 0.8;
    s.catheter.bend_n_mm2 = stiff;
    s.entry = {{0, 0, 4}, {0, 0, 1}, 5};
    return s;
}

/// How far the wire's surface is beyond the ghost at most: all triangles for many points of it that
/// are out of the guide.
double deepest(const CatheterScene& scene) {
    const CatheterEntry& entry = scene.settings().entry;
    const TriangleMesh& ghost = scene.wall().ghost;
    const auto positions = scene.ghost_positions();
    const auto x = scene.wire_positions();
    double most = -1e9;
    for (auto s = std::size_t(scene.first_inserted()); s + 1 < x.size(); ++s)
        for (int k = 1; k <= 6; ++k) {
            const Vec3d p = (1 - k / 6.0) * x[s] + (k / 6.0) * x[s + 1];
            const bool in_guide = dot(p - entry.position_mm, entry.direction) < 0;
            if (in_guide && std::int32_t(s) == scene.first_inserted()) continue;
            most = std::max(most,
                            scene.settings().catheter.radius_mm - inside_by(p, positions, ghost));
        }
    return most;
}

struct Journey {
    double depth = -1e9, reported = -1e9, energy = 0, force = 0, moved = 0, progress = 0;
    double volume_mean = 0;
    std::int64_t inverted = 0;
    CatheterMeasures end{};
    std::uint64_t hash = 0;
};
/// To the far end and back, then still.
Journey journey(const VesselWall& wall, const CatheterSettings& s, double speed, bool steered,
                int threads = 1, double way_in = 85) {
    const TaskArena arena(threads);
    CatheterScene scene = made(CatheterScene::create(wall, s));
    WayPilot pilot(places_of(bent_way()), 10);
    Journey found;
    CatheterCommand command;
    const int there = int(std::lround(way_in / speed / s.time_step_s)), all = 2 * there + 300;
    for (int n = 0; n < all; ++n) {
        command.insert_mm_s = n < there ? speed : n < 2 * there ? -speed : 0;
        if (steered) pilot.steer(scene, command);
        EXPECT_TRUE(scene.command(command).ok());
        const Status status = scene.step(1, arena);
        EXPECT_TRUE(status.ok()) << status.error().message;
        if (!status.ok()) return found;
        found.reported = std::max(found.reported, scene.quick_measures().depth_mm);
        found.force = std::max(found.force, std::abs(scene.quick_measures().force_n));
        if (n % std::max(1, there / 10) != 0) continue;
        const CatheterMeasures m = scene.measures();
        found.depth = std::max(found.depth, deepest(scene));
        found.energy =
            std::max(found.energy, m.wire_energy_mj + m.wall_energy_mj + m.kinetic_energy_mj);
        found.moved = std::max(found.moved, m.wall_moved_mm);
        found.volume_mean = std::max(found.volume_mean, m.volume.mean);
        found.progress = std::max(found.progress, pilot.progress_mm(scene.tip_mm()));
    }
    found.end = scene.measures();
    found.hash = scene.hash();
    std::printf(
        "EI %g, %g mm/s: depth %.4f (reported %.4f) mm, force %.3f N, energy %.3f mJ, wall "
        "moved %.3f mm, at the end %.4f mm, %.1f mm along the way\n",
        s.catheter.bend_n_mm2, speed, found.depth, found.reported, found.force, found.energy,
        found.moved, found.end.wall_moved_mm, found.progress);
    return found;
}

void expect_a_good_journey(const Journey& j) {
    EXPECT_LE(j.depth, 0.1);
    EXPECT_LE(j.reported, 0.1);
    EXPECT_GT(j.reported, -0.1);  // it does touch
    EXPECT_NEAR(j.end.inserted_mm, 5, 1e-6);
    EXPECT_GT(j.progress, 75);
    EXPECT_EQ(j.end.inverted, 0);
    EXPECT_LT(j.end.wall_moved_mm, 0.01);
    EXPECT_LT(j.end.kinetic_energy_mj, 1e-4);
    // At most the hand's work: 85 mm times its force.
    EXPECT_LE(j.energy, j.force * 85 + 0.02);
}

TEST(CatheterScene, StaysInsideAtAnySpeedAndStiffness) {
    const VesselWall wall = bent_tube();
    for (const double stiff : {5.0, 400.0})
        for (const double speed : {100.0, 400.0}) {
            CatheterSettings s = settings(stiff);
            s.catheter.tip_bend_n_mm2 = 0.2 * stiff;
            expect_a_good_journey(journey(wall, s, speed, false));
        }
}

// Behind its end the guide lies in the wall; the wire has to bend round the wall right before it.
TEST(CatheterScene, IsDrawnIntoAGuideBesideTheWall) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    CatheterSettings s = settings(60);
    s.entry = {{2.9, 0, 12}, normalized({-0.15, 0, 1}), 5};
    s.catheter.tip_bend_n_mm2 = 6;
    CatheterScene scene = made(CatheterScene::create(wall, s));
    double depth = -1e9, reported = -1e9;
    for (int n = 0; n < 600; ++n) {
        ASSERT_TRUE(scene.command({.insert_mm_s = n < 300 ? 200.0 : -200.0}).ok());
        ASSERT_TRUE(scene.step(1, arena).ok());
        reported = std::max(reported, scene.quick_measures().depth_mm);
        if (n > 300) depth = std::max(depth, deepest(scene));
    }
    std::printf("depth %.4f (reported %.4f) mm\n", depth, reported);
    EXPECT_LE(depth, 0.1);
    EXPECT_LE(reported, 0.1);
    EXPECT_GT(depth, -0.06);  // it touches
}

TEST(WayPilot, BendsTheTipToWhereTheWayGoes) {
    const TaskArena arena(1);
    const VesselWall wall = bent_tube();
    for (const Vec3d& side : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}}) {
        CatheterSettings s = settings();
        s.entry.inserted_mm = 30;
        CatheterScene scene = made(CatheterScene::create(wall, s));
        const Vec3d start = scene.tip_mm();
        WayPilot pilot({{0, 0, 0}, start, start + 20.0 * side}, 10);
        EXPECT_NEAR(pilot.way_mm(), 54, 1e-9);
        EXPECT_NEAR(pilot.progress_mm({1, 1, 20}), 20, 1e-9);
        // Turned about itself, the tip still goes where it is led.
        CatheterCommand command{.rotate_deg_s = 60};
        for (int n = 0; n < 200; ++n) {
            pilot.steer(scene, command);
            ASSERT_TRUE(scene.command(command).ok());
            ASSERT_TRUE(scene.step(1, arena).ok());
        }
        const Vec3d moved = scene.tip_mm() - start;
        EXPECT_GT(dot(moved, side), 1);
        EXPECT_LT(std::abs(dot(moved, cross({0, 0, 1}, side))), 0.5 * dot(moved, side));
        EXPECT_GT(std::hypot(command.bend_first_deg, command.bend_second_deg), 10);
    }
}

TEST(CatheterScene, IsTheSameForAnyNumberOfThreads) {
    const VesselWall wall = bent_tube();
    const std::uint64_t one = journey(wall, settings(), 400, true, 1, 50).hash;
    EXPECT_EQ(journey(wall, settings(), 400, true, 2, 50).hash, one);
    EXPECT_EQ(journey(wall, settings(), 400, true, 4, 50).hash, one);
    EXPECT_NE(journey(wall, settings(), 401, true, 1, 50).hash, one);
}

// A state put back, in the same scene or in another one, goes on to the same bits.
TEST(CatheterScene, GoesOnFromAState) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1), two(2);
    const CatheterSettings s = settings(100);
    CatheterScene scene = made(CatheterScene::create(wall, s)),
                  other = made(CatheterScene::create(wall, s));
    const auto start = scene.state();
    ASSERT_TRUE(scene.command({.insert_mm_s = 300, .bend_first_deg = 20}).ok());
    ASSERT_TRUE(scene.step(200, arena).ok());
    const auto state = scene.state();
    const std::uint64_t then = scene.hash();
    ASSERT_TRUE(scene.command({.insert_mm_s = -100, .rotate_deg_s = 90}).ok());
    ASSERT_TRUE(scene.step(60, arena).ok());
    const std::uint64_t after = scene.hash();
    EXPECT_GT(scene.measures().wall_moved_mm, 0.01);
    for (CatheterScene* at : {&scene, &other}) {
        ASSERT_TRUE(at->restore(state, arena).ok());
        EXPECT_EQ(at->hash(), then);
        EXPECT_EQ(at->quick_measures().steps, 200);
        EXPECT_EQ(at->state(), state);
        ASSERT_TRUE(at->command({.insert_mm_s = -100, .rotate_deg_s = 90}).ok());
        ASSERT_TRUE(at->step(60, at == &other ? two : arena).ok());
        EXPECT_EQ(at->hash(), after);
    }
    ASSERT_TRUE(scene.restore(start, arena).ok());
    EXPECT_EQ(scene.hash(), made(CatheterScene::create(wall, s)).hash());
    // An invalid state changes nothing.
    auto wrong = state;
    wrong.pop_back();
    EXPECT_FALSE(scene.restore(wrong, arena).ok());
    wrong = state;
    wrong[40] = std::nan("");
    EXPECT_FALSE(scene.restore(wrong, arena).ok());
    EXPECT_FALSE(scene.restore({}, arena).ok());
    EXPECT_EQ(scene.state(), start);
}

// A state put back makes it look for the wall anew: in every step, or only where it has to.
TEST(CatheterScene, IsTheSameHoweverLongAgoItLookedForTheWall) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    const CatheterSettings s = settings(100);
    CatheterScene scene = made(CatheterScene::create(wall, s)),
                  other = made(CatheterScene::create(wall, s));
    for (int n = 0; n < 500; ++n) {
        const double speed = n < 300 ? 250 : n < 400 ? 15 : -120;
        for (CatheterScene* at : {&scene, &other}) {
            ASSERT_TRUE(at->command({.insert_mm_s = speed}).ok());
            ASSERT_TRUE(at->step(1, arena).ok());
        }
        ASSERT_TRUE(other.restore(other.state(), arena).ok());
        ASSERT_EQ(scene.hash(), other.hash()) << "step " << n;
    }
    EXPECT_GT(scene.measures().wall_moved_mm, 0.01);
}

/// Wall positions while the catheter stands in the bend, after some time.
std::vector<Vec3d> standing(const VesselWall& wall, CatheterSettings s, std::vector<Vec3d>* wire) {
    const TaskArena arena(1);
    CatheterScene scene = made(CatheterScene::create(wall, s));
    for (int n = 0; n < 650; ++n) {
        EXPECT_TRUE(scene.command({.insert_mm_s = n < 400 ? 150.0 : 0.0}).ok());
        EXPECT_TRUE(scene.step(1, arena).ok());
    }
    wire->assign(scene.wire_positions().begin(), scene.wire_positions().end());
    return scene.wall_positions();
}

TEST(CatheterScene, LocalIsNearlyFull) {
    const VesselWall wall = bent_tube();
    std::vector<Vec3d> wires[2];
    CatheterSettings s = settings(300);
    s.catheter.tip_bend_n_mm2 = 60;
    s.local = false;
    const auto full = standing(wall, s, &wires[0]);
    s.local = true;
    const auto local = standing(wall, s, &wires[1]);
    double most = 0, apart = 0, wire = 0;
    for (std::size_t n = 0; n < full.size(); ++n) {
        most = std::max(most, norm(full[n] - wall.mesh.nodes_mm[n]));
        apart = std::max(apart, norm(full[n] - local[n]));
    }
    for (std::size_t n = 0; n < wires[0].size(); ++n)
        wire = std::max(wire, norm(wires[0][n] - wires[1][n]));
    std::printf("moved %.4f mm, local against full %.5f mm (%.2f %%), wire %.5f mm\n", most, apart,
                100 * apart / most, wire);
    EXPECT_GT(most, 0.05);
    EXPECT_LT(apart, 0.02 * most);
}

// On a soft support a push is felt far along the vessel; boxes as wide as it says follow it.
TEST(CatheterScene, IsNearlyFullOnASoftSupportWhereBoxesAreWide) {
    const VesselWall wall = bent_tube();
    std::vector<Vec3d> wire;
    CatheterSettings s = settings(300);
    s.catheter.tip_bend_n_mm2 = 60;
    s.wall.support_pa_per_mm = 2000;
    s.local = false;
    const auto full = standing(wall, s, &wire);
    double most = 0, apart[2] = {0, 0};
    s.local = true;
    for (const bool wide : {false, true}) {
        s.reach_mm = wide ? -1 : 2;
        const auto local = standing(wall, s, &wire);
        for (std::size_t n = 0; n < full.size(); ++n) {
            most = std::max(most, norm(full[n] - wall.mesh.nodes_mm[n]));
            apart[wide] = std::max(apart[wide], norm(full[n] - local[n]));
        }
    }
    std::printf("reach %.2f mm: %.2f %% of %.3f mm; 2 mm: %.2f %%\n", wide_reach_mm(wall, s.wall),
                100 * apart[1] / most, most, 100 * apart[0] / most);
    EXPECT_GT(apart[0], 0.02 * most);
    EXPECT_LE(apart[1], 0.02 * most);
}

// l = (4 E t R²/k)^(1/4), with the tube's own radius and thickness.
TEST(CatheterScene, AWideReachFollowsFromTheWallAndItsSupport) {
    const VesselWall wall = bent_tube();
    const double expected = std::pow(4 * 5e5 * 1.2 * 4.6 * 4.6 / 2000, 0.25);
    EXPECT_NEAR(wide_reach_mm(wall, {.support_pa_per_mm = 2000}), expected, 0.03 * expected);
    EXPECT_EQ(wide_reach_mm(wall, {.support_pa_per_mm = 0}), 1000);
    CatheterSettings s = settings();
    s.reach_mm = -1;
    EXPECT_NEAR(made(CatheterScene::create(wall, s)).settings().reach_mm,
                wide_reach_mm(wall, s.wall), 1e-12);
    s.reach_mm = -2;
    EXPECT_FALSE(CatheterScene::create(wall, s).ok());
}

// A wall of another origin may come without the volume of its lumen.
TEST(CatheterScene, AWideReachNeedsNoVolumeOfTheLumen) {
    VesselWall wall = bent_tube();
    const WallTissue tissue{.support_pa_per_mm = 2000};
    const double expected = wide_reach_mm(wall, tissue);
    wall.lumen_mm3 = 0;
    EXPECT_NEAR(wide_reach_mm(wall, tissue), expected, 1e-6 * expected);
}

TEST(CatheterScene, BeginsInTheLumenOrIsRefused) {
    const VesselWall wall = bent_tube();
    CatheterSettings s = settings();
    const auto message = [&] {
        const auto scene = CatheterScene::create(wall, s);
        return scene.ok() ? std::string() : scene.error().message;
    };
    EXPECT_EQ(message(), "");
    s.entry.position_mm = {0, 4.5, 10};
    EXPECT_EQ(
        message(),
        "[entry] place_mm: expected a position in the vessel's lumen, found 0, 4.5, 10 outside of "
        "it");
    s.entry.position_mm = {0, 0, -300};
    EXPECT_EQ(message().find("[entry] place_mm: "), 0u);
    s.entry = {{0, 0, 10}, {0, 1, 0}, 9};
    EXPECT_EQ(message().find(
                  "[entry] inserted_mm: expected the length inserted at first in the vessel's"),
              0u)
        << message();
}

CatheterSettings with_distances(double stiff = 20) {
    CatheterSettings s = settings(stiff);
    s.wall.model = WallModel::Distances;
    return s;
}

TEST(CatheterScene, StaysInAWallOfDistances) {
    const VesselWall wall = bent_tube();
    for (const double stiff : {20.0, 100.0}) {
        const Journey there = journey(wall, with_distances(stiff), 300, true);
        EXPECT_LE(there.depth, 0.1);
        EXPECT_LE(there.reported, 0.1);
        EXPECT_EQ(there.inverted, 0);
        EXPECT_GT(there.moved, 0.02);
        EXPECT_LT(there.end.wall_moved_mm, 0.05);
        EXPECT_GT(there.progress, 60);
    }
    const std::uint64_t one = journey(wall, with_distances(), 400, true, 1, 40).hash;
    EXPECT_EQ(journey(wall, with_distances(), 400, true, 3, 40).hash, one);
    EXPECT_NE(journey(wall, settings(), 400, true, 1, 40).hash, one);
}

TEST(CatheterScene, VolumeConstraintsKeepTheVolumesOfAWallOfDistances) {
    const VesselWall wall = bent_tube();
    CatheterSettings s = with_distances(100);
    const double with = journey(wall, s, 300, false, 1, 50).volume_mean;
    s.wall.volume_stiffness = 0;
    const double without = journey(wall, s, 300, false, 1, 50).volume_mean;
    EXPECT_GT(with, 0);
    EXPECT_GT(without, 2 * with);
}

TEST(CatheterScene, IterationsToAndFroKeepTheVolumesOfAHardWall) {
    const VesselWall wall = bent_tube();
    CatheterSettings s = with_distances(100);
    const Journey once = journey(wall, s, 300, false, 1, 50);
    s.wall.iterations = 4;
    s.wall.alternates = true;
    const Journey more = journey(wall, s, 300, false, 1, 50);
    EXPECT_LT(more.volume_mean, 0.7 * once.volume_mean);
    EXPECT_NE(more.hash, once.hash);
    s.wall.iterations = 3;
    const auto odd = CatheterScene::create(wall, s);
    ASSERT_FALSE(odd.ok());
    EXPECT_EQ(odd.error().message,
              "[wall] iterations: expected an even number beside alternates, found 3");
}

// Weight over support: ρ g V = k A d, for the outer surface A.
TEST(CatheterScene, AWallSagsByItsWeightOnItsSupport) {
    const CentrePoint way[] = {{{0, 0, 0}, 4}, {{0, 0, 60}, 4}};
    const VesselWall wall =
        made(swept_tube(way, {.thickness_mm = 1.2, .layers = 1, .sectors = 24}));
    const TaskArena arena(1);
    for (const WallModel model : {WallModel::Solid, WallModel::Distances}) {
        CatheterSettings s = settings();
        s.local = false;
        s.wall.model = model;
        s.wall.young_modulus_pa = 2e4;
        s.wall.stretch_stiffness = s.wall.bend_stiffness = 0.01;
        s.wall.support_pa_per_mm = 5000;
        s.wall.gravity_mm_s2 = {0, -9810, 0};
        CatheterScene scene = made(CatheterScene::create(wall, s));
        ASSERT_TRUE(scene.step(150, arena).ok());
        const auto positions = scene.wall_positions();
        double sag = 0, count = 0;
        for (std::size_t n = 0; n < positions.size(); ++n) {
            const Vec3d rest = wall.mesh.nodes_mm[n];
            if (std::abs(rest.z - 30) > 5 || std::hypot(rest.x, rest.y) < 5) continue;
            sag += rest.y - positions[n].y;
            count += 1;
        }
        const double expected = 0.02 * 9810 * (5.2 * 5.2 - 4 * 4) / (2 * 5.2) / 5000;
        EXPECT_NEAR(sag / count, expected, 0.1 * expected);
    }
}

TEST(CatheterScene, MakesAsManySubStepsAsContactWants) {
    const VesselWall wall = bent_tube();
    const auto sub_steps = [&](double tip, double step_s, double young) {
        CatheterSettings s = settings();
        s.catheter.tip_bend_n_mm2 = tip;
        s.time_step_s = step_s;
        s.wall.young_modulus_pa = young;
        return made(CatheterScene::create(wall, s)).settings().sub_steps;
    };
    EXPECT_EQ(sub_steps(2, 0.001, 5e5), 5);  // as asked for
    // h² EI/(l³ m) = 3 with segments of 130/43 mm.
    const double l = 130.0 / 43, h = std::sqrt(3 * l * l * l * l * 0.004 / (200 * 1e6));
    EXPECT_EQ(sub_steps(200, 0.001, 5e5), int(std::ceil(0.001 / h)));
    EXPECT_GT(sub_steps(2, 0.001, 5e7), 15);
    EXPECT_EQ(sub_steps(200, 0.002, 5e5), int(std::ceil(0.002 / h)));
    // The paper's constraints have no waves that are too fast.
    CatheterSettings distances = with_distances();
    distances.wall.young_modulus_pa = 5e7;
    CatheterScene scene = made(CatheterScene::create(wall, distances));
    EXPECT_EQ(scene.settings().sub_steps, 5);
    EXPECT_EQ(scene.quick_measures().sub_steps, 0);
    ASSERT_TRUE(scene.step(1, TaskArena(1)).ok());
    EXPECT_EQ(scene.quick_measures().sub_steps, 5);
}

TEST(CatheterScene, WarnsOfMoreSubStepsThanAreMade) {
    CatheterSettings s = settings();
    s.time_step_s = 0.05;
    s.wall.young_modulus_pa = 1e8;
    const CatheterMeasures m = made(CatheterScene::create(bent_tube(), s)).quick_measures();
    EXPECT_GT(m.needed_sub_steps, 1000);
    const auto warnings = warnings_of(m);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(
        warnings[0].find("sub_steps: expected at most 1000 for the tip's bending and waves in "
                         "the wall, found " +
                         std::to_string(m.needed_sub_steps) + "; "),
        0u)
        << warnings[0];
    EXPECT_TRUE(warnings_of({.needed_sub_steps = 1000}).empty());
}

// The stiffest guide wires have an EI of 4900 N mm².
TEST(CatheterScene, AStiffWireLiesOnARigidWall) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    CatheterSettings s = settings(3000);
    s.catheter.twist_n_mm2 = s.catheter.tip_bend_n_mm2 = 3000;
    s.catheter.tip_mm = 24;
    s.wall.model = WallModel::Rigid;
    const auto pressed = [&] {
        CatheterScene scene = made(CatheterScene::create(wall, s));
        EXPECT_TRUE(scene.command({.insert_mm_s = 120, .bend_first_deg = 150}).ok());
        EXPECT_TRUE(scene.step(100, arena).ok());
        EXPECT_TRUE(scene.command({.bend_first_deg = 150}).ok());
        EXPECT_TRUE(scene.step(100, arena).ok());
        return scene;
    };
    const CatheterScene scene = pressed();
    const CatheterMeasures m = scene.quick_measures();
    EXPECT_LT(deepest(scene), 0.1);
    EXPECT_NEAR(m.depth_mm, deepest(scene), 0.02);
    EXPECT_GT(m.largest_contact_n, 3);
    EXPECT_LE(m.largest_contact_n, m.contact_n);
    EXPECT_DOUBLE_EQ(m.contact_mm_per_n, 10.0 / 3000);
    EXPECT_EQ(scene.settings().catheter.contact_mm_per_n, m.contact_mm_per_n);
    EXPECT_TRUE(warnings_of(m).empty());
    // The key decides, and its warning names it.
    s.catheter.contact_mm_per_n = 0.1;
    const CatheterScene soft = pressed();
    EXPECT_GT(deepest(soft), 0.3);
    const auto warnings = warnings_of(soft.quick_measures());
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("lower contact_mm_per_n, 0.1"), std::string::npos) << warnings[0];
    // Soft wires have the largest compliance.
    EXPECT_EQ(made(CatheterScene::create(wall, settings(100))).settings().catheter.contact_mm_per_n,
              0.1);
}

TEST(CatheterScene, WarnsOfWhatIsWrongWithAState) {
    EXPECT_TRUE(warnings_of({.depth_mm = 0.09}).empty());
    EXPECT_EQ(warnings_of({.largest_contact_n = 4, .contact_mm_per_n = 0.1, .depth_mm = 0.35}),
              std::vector<std::string>{"the catheter is 0.35 mm beyond the wall, expected at most "
                                       "0.1: a contact of 4 N yields by 0.4 mm, lower "
                                       "contact_mm_per_n, 0.1"});
    EXPECT_EQ(warnings_of({.depth_mm = 0.25}),
              std::vector<std::string>{"the catheter is 0.25 mm beyond the wall, expected at most "
                                       "0.1: raise sub_steps"});
    EXPECT_EQ(warnings_of({.inverted = 3, .left_end = 2}),
              (std::vector<std::string>{"3 tetrahedra are inverted, expected none: raise sub_steps",
                                        "the tip has left the vessel through open end 2"}));
}

// Out of an open end, and back again.
TEST(CatheterScene, SaysThroughWhichEndTheTipHasLeft) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    CatheterSettings s = settings();
    s.entry = {{0, 0, 6}, {0, 0, -1}, 3};  // towards the near end
    CatheterScene scene = made(CatheterScene::create(wall, s));
    ASSERT_TRUE(scene.command({.insert_mm_s = 100}).ok());
    double left_at = 0;
    for (int n = 0; n < 200; ++n) {
        ASSERT_TRUE(scene.step(1, arena).ok());
        const CatheterMeasures m = scene.quick_measures();
        if (m.left_end > 0 && left_at == 0) left_at = m.inserted_mm;
        EXPECT_LE(m.depth_mm, 0.1);
    }
    EXPECT_EQ(scene.quick_measures().left_end, 1);
    EXPECT_NEAR(left_at, 6, 0.2);
    ASSERT_TRUE(scene.command({.insert_mm_s = -100}).ok());
    ASSERT_TRUE(scene.step(200, arena).ok());
    EXPECT_EQ(scene.quick_measures().left_end, 0);
}

TEST(CatheterScene, SaysWhatIsWrong) {
    const VesselWall wall = bent_tube();
    const auto message = [&](auto change) {
        CatheterSettings s = settings();
        change(s);
        const auto scene = CatheterScene::create(wall, s);
        return scene.ok() ? std::string() : scene.error().message;
    };
    EXPECT_EQ(message([](CatheterSettings&) {}), "");
    EXPECT_EQ(message([](CatheterSettings& s) { s.catheter.radius_mm = 0; }),
              "[catheter] radius_mm: expected 0.1 to 5 mm, found 0");
    EXPECT_EQ(message([](CatheterSettings& s) { s.wall.poisson_ratio = std::nan(""); }),
              "[wall] poisson_ratio: expected 0.01 to 0.499, found nan");
    EXPECT_EQ(message([](CatheterSettings& s) {
                  s.entry.direction = {0, 0, 0};
              }),
              "[entry] direction: expected a vector that isn't zero, found 0, 0, 0");
    EXPECT_EQ(message([](CatheterSettings& s) { s.wall.bend_stiffness = 1.5; }),
              "[wall] bend_stiffness: expected 0 to 1, found 1.5");
    EXPECT_EQ(
        message([](CatheterSettings& s) {
            s.wall.model = WallModel::Distances;
            s.wall.stretch_stiffness = s.wall.bend_stiffness = s.wall.volume_stiffness = 0;
        }),
        "[wall] stretch_stiffness: expected one of the three stiffnesses above 0, found none");
    VesselWall broken = wall;
    broken.ghost_positions.pop_back();
    const auto scene = CatheterScene::create(broken, settings());
    ASSERT_FALSE(scene.ok());
    EXPECT_EQ(scene.error().message.substr(0, 6), "wall: ");
    CatheterScene good = made(CatheterScene::create(wall, settings()));
    EXPECT_FALSE(good.command({.insert_mm_s = std::nan("")}).ok());
    EXPECT_FALSE(good.command({.insert_mm_s = 2000}).ok());
    EXPECT_FALSE(good.rig_tip(TipRig{.moment_n_mm = {0, std::nan(""), 0}}).ok());
    EXPECT_FALSE(good.rig_tip(TipRig{.hold = TipHold{.frame = {1, 1, 0, 0}}}).ok());
    EXPECT_TRUE(good.rig_tip(TipRig{}).ok());
    EXPECT_TRUE(good.rig_tip({}).ok());
}

TEST(CatheterSettings, HaveDifferentNames) {
    std::vector<std::string_view> names;
    for (const auto& row : catheter_rows()) names.push_back(row.name);
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    CatheterSettings s;
    ASSERT_TRUE(apply({{"wall_model", "rigid"}, {"iterations", 7}}, catheter_rows(), s).ok());
    EXPECT_EQ(s.wall.model, WallModel::Rigid);
    EXPECT_EQ(s.iterations, 7);
    EXPECT_EQ(s.wall.iterations, 1);
}

TEST(Phantoms, TheAortaIsOneTreeWithSixEnds) {
    const TaskArena arena(2);
    const auto tree = made(phantom_centreline("aorta"));
    EXPECT_EQ(tree.branches.size(), 6U);
    const auto wall =
        made(wall_around_centreline(tree, {.thickness_mm = 3, .layers = 1, .cell_mm = 2}, arena));
    EXPECT_EQ(wall.ends.size(), 6U);
    EXPECT_TRUE(check_wall(wall).ok());
    for (const std::string name : {"bend", "arch"})
        EXPECT_EQ(made(phantom_centreline(name)).branches.size(), 1U);
    EXPECT_FALSE(phantom_centreline("foot").ok());
}

}  // namespace
}  // namespace pliant::test
