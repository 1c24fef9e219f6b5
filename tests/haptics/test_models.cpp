// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues through the servo, with 30 solutions per second: against their static solution, and
// against invariants of every wall.
// Covers: haptics/feel_*.cpp, haptics/local_model.cpp, haptics/nearest_free_position.cpp,
// haptics/walls.cpp.

#include <gtest/gtest.h>
#include <pliant/models/pbd.h>
#include <pliant/models/springs.h>
#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/broken_volumes.h"
#include "support/random.h"
#include "tissues.h"

namespace pliant {
namespace {

struct Felt {
    double depth_mm, force_n;
};

/// Pushes down the z axis from +0.3 mm, quasi-statically, as far as `deep`; the tissue is solved
/// every 33 periods, for the position that the tool had then.
std::vector<Felt> press(const HapticSettings& settings, double deep_mm, double speed_mm_s,
                        const std::function<HapticModel(Vec3d tool, Vec3d proxy)>& tissue,
                        Vec3d axis_mm = {0, 0, 0}, double start_mm = 0.3) {
    HapticState state;
    state.gain = 1;
    std::vector<Felt> felt;
    std::int64_t number = 0;
    const int periods = int((deep_mm + start_mm) / speed_mm_s * 1000);
    for (int k = 0; k <= periods; ++k) {
        const double z = start_mm - 1e-3 * speed_mm_s * k;
        const HapticReading reading{1'000'000 * std::int64_t(k), axis_mm + Vec3d{0, 0, z}, false,
                                    0};
        HapticModel model;
        const bool is_fresh = k % 33 == 0;
        if (is_fresh) {
            const Vec3d proxy = k == 0 ? reading.position_mm : state.proxy_mm;
            model = checked_model(tissue(reading.position_mm, proxy), settings.max_stiffness_n_m)
                        .value();
            model.number = ++number;
        }
        servo_step(settings, is_fresh ? &model : nullptr, reading, state);
        felt.push_back({-z, norm(state.force_n)});
    }
    return felt;
}

/// Force rises with depth, and no step is larger than the stiffest position explains.
void expect_smooth_and_monotone(const std::vector<Felt>& felt, double stiffest_n_m) {
    for (std::size_t k = 1; k < felt.size(); ++k) {
        const double step_mm = felt[k].depth_mm - felt[k - 1].depth_mm;
        EXPECT_GE(felt[k].force_n, felt[k - 1].force_n - 1e-9) << "at " << felt[k].depth_mm;
        EXPECT_LE(felt[k].force_n - felt[k - 1].force_n, 1e-3 * stiffest_n_m * step_mm + 1e-9)
            << "at " << felt[k].depth_mm;
    }
}

HapticSettings device_of(double stiffness_n_m) {
    HapticSettings settings;
    settings.max_stiffness_n_m = stiffness_n_m;
    settings.max_force_n = 7.9;
    return settings;
}

TEST(Springs, FeelAsTheirStaticSolutionWithinTwoPercent) {
    // A block of 12 kPa, 27 mm wide, held at its base; the tool pushes four nodes of its top.
    auto parts = springs_of_lattice(
        {.size = {10, 10, 8}, .spacing = {3, 3, 3}, .stiffness = {15e3, 15e3, 15e3}});
    ASSERT_TRUE(parts.ok());
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    const std::int32_t first = 10 * 10 * 7 + 10 * 4 + 4;
    const std::vector<std::int32_t> held{first, first + 1, first + 10, first + 11};
    auto network = SpringNetwork::create(std::move(*parts));
    ASSERT_TRUE(network.ok());
    auto tissue = SpringTissue::create(std::move(*network), {.depth = 40});
    ASSERT_TRUE(tissue.ok());
    ASSERT_TRUE(tissue->hold(held).ok());
    double at_mm = 0;
    const auto solve_at = [&](double depth_mm) {
        ASSERT_TRUE(tissue->shift_held({0, 0, at_mm - depth_mm}).ok());
        at_mm = depth_mm;
        ASSERT_TRUE(tissue->find_equilibrium(1e-9).ok());
    };
    LearntStiffness last(0, 1000);
    const auto felt = press(device_of(1000), 3, 5, [&](Vec3d tool, Vec3d) {
        const double depth = std::max(0.0, -tool.z);
        solve_at(depth);
        return results::model_of_springs(*tissue, held, {0, 0, 0}, {0, 0, 1}, tool, &last).value();
    });
    int compared = 0;
    for (std::size_t k = 0; k < felt.size(); k += 19) {
        if (felt[k].depth_mm < 0.5) continue;
        solve_at(felt[k].depth_mm);
        const auto reaction = tissue->reaction(held, ReactionLaw::Held);
        ASSERT_TRUE(reaction.ok());
        const double exact_n = 1e-6 * reaction->force.z;
        EXPECT_GT(exact_n, 0);
        EXPECT_NEAR(felt[k].force_n, exact_n, 0.02 * exact_n) << felt[k].depth_mm << " mm";
        ++compared;
    }
    EXPECT_GT(compared, 20);
    expect_smooth_and_monotone(felt, 1000);
}

/// Air over tissue with its surface at z = 0, over bone from a depth on.
Volume layered(double bone_depth_mm, float tissue_hu = 40) {
    Volume volume;
    volume.grid = {{48, 48, 48}, {0.8, 0.8, 0.8}, {-19, -19, -28}, kIdentity3};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 48; ++k) {
        const double z = -28 + 0.8 * k;
        // −300 HU is crossed at z = 0 for every tissue.
        const double share = std::clamp(0.5 - z / 0.8, 0.0, 1.0);
        const double air = -300 - 0.5 / 0.5 * (tissue_hu + 300);
        double value = air + share * (tissue_hu - air);
        if (z < -bone_depth_mm) value = 1200;
        voxels.insert(voxels.end(), 48 * 48, std::int16_t(std::lround(value)));
    }
    volume.voxels = std::move(voxels);
    return volume;
}

std::vector<Felt> press_wall(const Volume& volume, double device_n_m, double deep_mm,
                             const TaskArena& arena) {
    ChainMailFeelSettings settings;
    auto feel = ChainMailFeel::create(volume, {}, settings, arena);
    EXPECT_TRUE(feel.ok()) << feel.error().message;
    const Vec3d above{0, 0, settings.tool_radius_mm};  // a sphere touches when its centre is here
    return press(
        device_of(device_n_m), deep_mm, 20,
        [&](Vec3d tool, Vec3d proxy) { return (*feel)->model(tool, proxy); }, above);
}

double stiffness_n_m(const std::vector<Felt>& felt, double low_mm, double high_mm) {
    const auto at = [&](double depth) {
        return std::lower_bound(felt.begin(), felt.end(), depth,
                                [](const Felt& f, double d) { return f.depth_mm < d; });
    };
    return 1e3 * (at(high_mm)->force_n - at(low_mm)->force_n) /
           (at(high_mm)->depth_mm - at(low_mm)->depth_mm);
}

TEST(ChainMail, ForceIsSmoothAndMonotoneInDepthOfHomogeneousTissue) {
    const TaskArena arena(2);
    const auto felt = press_wall(layered(1000), 1000, 7, arena);
    expect_smooth_and_monotone(felt, 1000);
    EXPECT_EQ(felt.front().force_n, 0);
    // The flat punch's law, 2 a E/(1 − ν²), as long as the links' limit is far.
    const double punch = 2 * 1.5e-3 * 7500 / (1 - 0.45 * 0.45);
    EXPECT_NEAR(stiffness_n_m(felt, 0.1, 0.6), punch, 0.2 * punch);
}

TEST(ChainMail, BoneFeelsAtLeastTwentyTimesStifferThanSoftTissue) {
    const TaskArena arena(2);
    for (const double device : {600., 1000.}) {
        const double soft = stiffness_n_m(press_wall(layered(1000), device, 2, arena), 0.2, 1);
        const double bone = stiffness_n_m(press_wall(layered(-1), device, 2, arena), 0.2, 1);
        EXPECT_GE(bone, 20 * soft) << device;
        EXPECT_LE(bone, device * 1.001);
    }
}

TEST(ChainMail, AThinLayerOverBoneIsSoftAndThenHard) {
    const TaskArena arena(2);
    const auto felt = press_wall(layered(6), 1000, 5, arena);
    // A model without knowledge of the bone blends into the next one over its period.
    expect_smooth_and_monotone(felt, 4000);
    const auto deep = press_wall(layered(1000), 1000, 5, arena);
    EXPECT_LT(stiffness_n_m(felt, 0.05, 0.3), 3 * stiffness_n_m(deep, 0.05, 0.3));
    EXPECT_GT(stiffness_n_m(felt, 4, 4.9), 10 * stiffness_n_m(deep, 4, 4.9));
}

TEST(ChainMail, TheLimitIsWhatAPushCanDo) {
    const TaskArena arena(2);
    double last = 0;
    for (const double bone_mm : {3., 6., 12.}) {
        const Volume volume = layered(bone_mm);
        auto feel = ChainMailFeel::create(volume, {}, {}, arena);
        ASSERT_TRUE(feel.ok());
        const double limit = (*feel)->give_at({0, 0, 0}, {0, 0, 1}).limit_mm;
        EXPECT_GT(limit, last);
        EXPECT_LT(limit, bone_mm);
        last = limit;
    }
    ChainMailFeelSettings settings;
    settings.reach_mm = -1;
    const Volume volume = layered(3);
    const auto wrong = ChainMailFeel::create(volume, {}, settings, arena);
    ASSERT_FALSE(wrong.ok());
    EXPECT_NE(wrong.error().message.find("reach_mm: expected"), std::string::npos);
}

TEST(ChainMail, ATubesWallIsFeltFromAllSides) {
    const TaskArena arena(2);
    Volume volume;
    volume.grid = {{40, 40, 40}, {1, 1, 1}, {-19.5, -19.5, -19.5}, kIdentity3};
    std::vector<std::int16_t> voxels;
    for (int n = 0; n < 40 * 40 * 40; ++n) {
        const double x = n % 40 - 19.5, y = n / 40 % 40 - 19.5;
        const double over = std::hypot(x, y) - 8;  // −300 HU at a radius of 8 mm
        voxels.push_back(std::int16_t(std::lround(std::clamp(-300 + 340 * over, -1000., 40.))));
    }
    volume.voxels = std::move(voxels);
    auto feel = ChainMailFeel::create(volume, {}, {}, arena);
    ASSERT_TRUE(feel.ok());
    test::Random random(5);
    for (int trial = 0; trial < 20; ++trial) {
        const double angle = random.real(-3.14, 3.14), r = random.real(2, 6.3);
        const Vec3d out{std::cos(angle), std::sin(angle), 0};
        const HapticModel model = (*feel)->model(9.0 * out, r * out);
        EXPECT_GE(model.plane_count, 3);
        const Vec3d free = nearest_free_position(model, 9.0 * out);
        EXPECT_NEAR(norm(free), 6.5, 0.35) << "angle " << angle << ", radius " << r;
        EXPECT_LT(dot(model.force_n, out), 0);
    }
}

TEST(Pbd, StiffnessIsLearntFromForces) {
    // Two springs that are known.
    test::Random random(3);
    const Mat3d axes = random.rotation(false);
    Mat3d k{};
    const Vec3d values{50, 200, 400};
    for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 3; ++c)
            k.columns[c] = k.columns[c] + (values[a] * axes.columns[a][c]) * axes.columns[a];
    LearntStiffness learnt(100, 1000);
    Vec3d x{0, 0, 0};
    for (int n = 0; n < 60; ++n) {
        learnt.add(x, -1e-3 * (k * x));
        x = random.vector(2);
    }
    for (int c = 0; c < 3; ++c) EXPECT_LT(norm(learnt.change_n_m().columns[c] + k.columns[c]), 2);
}

TEST(Pbd, ABlockIsFeltThroughItsConstraintForces) {
    // SI units: 40 mm wide, 10 kPa; the tool is an attachment to a node of the top.
    const TetMesh mesh = five_tet_block({6, 6, 6}, 0.04 / 6);
    auto parts = pbd_of_mesh(mesh, {.density = 1000,
                                    .edges = false,
                                    .volumes = false,
                                    .solids = true,
                                    .young_modulus = 1e4,
                                    .poisson_ratio = 0.4});
    ASSERT_TRUE(parts.ok());
    std::int32_t top = 0;
    const Vec3d middle{0.02, 0.02, 0.04};
    for (std::size_t n = 0; n < parts->positions.size(); ++n) {
        if (parts->positions[n].z < 1e-9) parts->inverse_masses[n] = 0;
        if (norm(parts->positions[n] - middle) < norm(parts->positions[std::size_t(top)] - middle))
            top = std::int32_t(n);
    }
    const Vec3d surface = parts->positions[std::size_t(top)];
    parts->attachments.push_back({.nodes = {top, top, top, top},
                                  .weights = {1, 0, 0, 0},
                                  .target = surface,
                                  .compliance = 1e-4});
    auto body = PbdBody::create(
        std::move(*parts),
        {.time_step = 0.033, .sub_steps = 30, .damping = 20, .precision = PbdPrecision::Double});
    ASSERT_TRUE(body.ok()) << body.error().message;
    const TaskArena arena(1);
    LearntStiffness learnt(50, 600);
    const auto felt = press(device_of(600), 5, 10, [&](Vec3d tool, Vec3d) {
        const Vec3d below{0, 0, std::min(0.0, 1e-3 * tool.z)};
        EXPECT_TRUE(body->move_attachment(0, surface + below).ok());
        EXPECT_TRUE(body->step(1, arena).ok());
        const Vec3d force = -body->attachment_force(0);
        if (tool.z < 0) learnt.add(tool, force);
        return model_of_contact({0, 0, 0}, {0, 0, 1}, tool, force, learnt.change_n_m());
    });
    EXPECT_GT(felt.back().force_n, 0.05);
    EXPECT_LT(felt.back().force_n, 3);
    // The body still moves while it is pushed: the force rises up to that motion.
    double most = 0;
    for (const Felt& f : felt) {
        EXPECT_GE(f.force_n, 0.9 * most - 0.01) << f.depth_mm;
        most = std::max(most, f.force_n);
    }
    const Vec3d at_last = -body->attachment_force(0);
    EXPECT_NEAR(felt.back().force_n, norm(at_last), 0.1 * norm(at_last));
}

TEST(ChainMail, AVolumeWithABrokenFieldIsRefused) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const test::BrokenVolume broken = test::broken_volume(random);
        const Volume good = test::good_volume(random);
        test::expect_refused(ChainMailFeel::create(broken.volume, {}, {}, arena), broken.field);
        test::expect_refused(ChainMailFeel::create(good, broken.volume, {}, {}, arena),
                             "shown." + broken.field);
    }
}

}  // namespace
}  // namespace pliant
