// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The servo's function: geometry against the definition of a projection, the law against its
// formula, limits and safe stop period by period.

#include <gtest/gtest.h>
#include <pliant/view/haptics.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "haptic_run.h"
#include "support/random.h"

namespace pliant {
namespace {

using test::Random;

constexpr std::int64_t kPeriod_ns = 1'000'000;

/// A flat surface at z = 0, free above, with a stiffness that is the same in all directions.
HapticModel flat_wall(double stiffness_n_m, std::int64_t number = 1) {
    HapticModel model;
    model.number = number;
    model.plane_count = 1;
    model.planes[0] = {{0, 0, 0}, {0, 0, 1}};
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c][c] = stiffness_n_m;
    return model;
}

/// Plays positions one after the other; the model comes again every 30 periods.
class Player {
  public:
    explicit Player(HapticSettings settings) : m_settings(settings) { m_state.gain = 1; }

    Vec3d step(Vec3d position_mm, const HapticModel* fresh = nullptr, bool stop = false) {
        const HapticReading reading{kPeriod_ns * m_period++, position_mm, stop};
        m_last = servo_step(m_settings, fresh, reading, m_state);
        return m_last.force_n;
    }
    const HapticState& state() const { return m_state; }
    std::uint32_t flags() const { return m_last.flags; }

  private:
    HapticSettings m_settings;
    HapticState m_state;
    HapticForce m_last;
    std::int64_t m_period = 0;
};

TEST(NearestFreePlace, IsTheProjectionOnRandomPolyhedra) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        HapticModel model;
        model.plane_count = random.whole(1, HapticModel::kMaxPlanes);
        const Vec3d inside = random.vector(300);
        for (int k = 0; k < model.plane_count; ++k) {
            const Vec3d n = normalized(random.vector(1));
            model.planes[k] = {inside - random.real(0, 5) * n + cross(n, random.vector(3)), n};
        }
        const Vec3d x = inside + random.vector(20);
        bool boxed_in = true;
        const Vec3d p = nearest_free_position(model, x, &boxed_in);
        EXPECT_FALSE(boxed_in);
        const auto is_free = [&](Vec3d q, double tolerance) {
            for (int k = 0; k < model.plane_count; ++k)
                if (dot(model.planes[k].normal, q - model.planes[k].point_mm) < -tolerance)
                    return false;
            return true;
        };
        EXPECT_TRUE(is_free(p, 1e-8));
        // p is nearest if and only if no free q lies on x's side of the plane through p.
        for (int trial = 0; trial < 300; ++trial) {
            const Vec3d direction = normalized(random.vector(1));
            double reach = 40;
            for (int k = 0; k < model.plane_count; ++k) {
                const HapticPlane& plane = model.planes[k];
                const double slope = dot(plane.normal, direction);
                if (slope < 0)
                    reach = std::min(reach, dot(plane.normal, plane.point_mm - inside) / slope);
            }
            const Vec3d q = inside + reach * direction;
            ASSERT_TRUE(is_free(q, 1e-8));
            EXPECT_LE(dot(x - p, q - p), 1e-6);
        }
    }
}

TEST(NearestFreePlace, SaysWhenThereIsNone) {
    HapticModel model;
    model.plane_count = 2;
    model.planes[0] = {{0, 0, 1}, {0, 0, 1}};
    model.planes[1] = {{0, 0, -2}, {0, 0, -1}};
    bool boxed_in = false;
    EXPECT_EQ(nearest_free_position(model, {5, 6, 0}, &boxed_in), (Vec3d{5, 6, -2}));
    EXPECT_TRUE(boxed_in);
}

TEST(CappedStiffness, KeepsDirectionsAndCutsEigenvalues) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Mat3d axes = random.rotation(false);
        const Vec3d values{random.real(-500, 0), random.real(0, 700), random.real(700, 9000)};
        const Vec3d cut{0, values.y, 700};
        Mat3d k{}, expected{};
        for (int a = 0; a < 3; ++a)
            for (int c = 0; c < 3; ++c) {
                const Vec3d axis = axes.columns[a];
                k.columns[c] = k.columns[c] + (values[a] * axis[c]) * axis;
                expected.columns[c] = expected.columns[c] + (cut[a] * axis[c]) * axis;
            }
        // A turning part does no work over a closed way only if it isn't there.
        k.columns[0].y += 40;
        k.columns[1].x -= 40;
        const Mat3d capped = capped_stiffness(k, 700);
        for (int c = 0; c < 3; ++c) EXPECT_LT(norm(capped.columns[c] - expected.columns[c]), 1e-8);
    }
}

TEST(CheckedModel, NamesWhatIsWrong) {
    const auto message_of = [](const HapticModel& model) {
        const auto checked = checked_model(model, 1000);
        return checked.ok() ? std::string() : checked.error().message;
    };
    EXPECT_EQ(message_of(flat_wall(100)), "");
    HapticModel model = flat_wall(100);
    model.planes[0].normal = {0, 0, 0};
    EXPECT_EQ(message_of(model),
              "haptic model: plane 0: expected a position and a normal with a length");
    model = flat_wall(100);
    model.plane_count = 9;
    EXPECT_EQ(message_of(model), "haptic model: expected 0 to 8 planes, found 9");
    model = flat_wall(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(message_of(model), "haptic model: stiffness_n_m: expected numbers");
    model = flat_wall(100);
    model.friction = -1;
    EXPECT_EQ(message_of(model), "haptic model: friction: expected 0 or more, found -1.000000");
    model = flat_wall(5000);
    model.planes[0].normal = {0, 0, 4};
    const auto checked = checked_model(model, 1000);
    ASSERT_TRUE(checked.ok());
    EXPECT_EQ(checked->planes[0].normal, (Vec3d{0, 0, 1}));
    EXPECT_NEAR(checked->stiffness_n_m.columns[2].z, 1000, 1e-9);
}

TEST(HapticSettings, NameTheOneThatIsOutOfRange) {
    EXPECT_TRUE(check_haptic_settings({}).ok());
    HapticSettings settings;
    settings.ramp_s = 0;
    const Status status = check_haptic_settings(settings);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().message, "haptics: ramp_s: expected 0.001 to 10, found 0.000000");
    settings = {};
    settings.workspace.rotation.columns[0] = {2, 0, 0};
    EXPECT_FALSE(check_haptic_settings(settings).ok());
}

TEST(Law, IsZeroOutsideAndLinearInDepthBeyondTheSurface) {
    Player player({});
    const HapticModel model = flat_wall(500);
    EXPECT_EQ(player.step({0, 0, 1}, &model), (Vec3d{0, 0, 0}));
    for (int k = 0; k < 20; ++k) {
        const double depth = 0.05 * k;
        const Vec3d force = player.step({1, 2, -depth});
        EXPECT_NEAR(force.z, 0.5 * depth, 1e-12);
        EXPECT_EQ(force.x, 0);
    }
    // Away in one period: no force in that period.
    EXPECT_NE(player.step({0, 0, -0.9}).z, 0);
    EXPECT_EQ(player.step({0, 0, 0.001}), (Vec3d{0, 0, 0}));
}

TEST(Law, BeginsAtZeroAndNeverPulls) {
    // The solution knew a force of 1 N at a depth of 2 mm, and a small stiffness there: its
    // straight line doesn't vanish at the surface.
    HapticModel model = flat_wall(100);
    model.depth_mm = {0, 0, 2};
    model.force_n = {0, 0, 1};
    HapticSettings settings;
    Player player(settings);
    player.step({0, 0, 1}, &model);
    double last = 0;
    for (int k = 0; k <= 2000; ++k) {
        const double depth = 0.001 * k;
        const double force = player.step({0, 0, -depth}).z;
        EXPECT_LE(force, settings.max_stiffness_n_m * 1e-3 * depth + 1e-12);
        EXPECT_GE(force, last);
        last = force;
        if (k % 30 == 0) model.number++, player.step({0, 0, -depth}, &model);
    }
    EXPECT_NEAR(last, 1, 1e-9);
    // A law that would pull near the surface.
    model.number++;
    model.force_n = {0, 0, 0.1};
    Player other(settings);
    other.step({0, 0, 1}, &model);
    EXPECT_EQ(other.step({0, 0, -0.5}), (Vec3d{0, 0, 0}));
    EXPECT_NEAR(other.step({0, 0, -1.5}).z, 0.05, 1e-12);
}

TEST(Law, GripPullsBothWays) {
    HapticModel model = model_of_grip({1, 0, 0}, {0.2, 0, 0}, {{{-300, 0, 0}, {}, {}}});
    model.number = 1;
    HapticSettings settings;
    settings.bounded_energy = false;  // it had hold of the tissue before the first period
    Player player(settings);
    player.step({1, 0, 0}, &model);
    EXPECT_NEAR(player.step({1.1, 0, 0}).x, 0.17, 1e-12);
    EXPECT_NEAR(player.step({0.9, 0, 0}).x, 0.23, 1e-12);
}

TEST(Friction, HoldsUpToItsConeAndThenSlides) {
    HapticModel model = flat_wall(500);
    model.friction = 0.4;
    Player player({});
    player.step({0, 0, 0.01}, &model);
    player.step({0, 0, -1});
    for (int k = 0; k < 25; ++k) {
        const double aside = 0.05 * k;
        const Vec3d force = player.step({aside, 0, -1});
        EXPECT_NEAR(force.z, 0.5, 1e-12);
        EXPECT_NEAR(force.x, -0.5 * std::min(aside, 0.4), 1e-12) << aside;
    }
    // Back: it first releases its static friction, and then sticks in the other direction.
    EXPECT_NEAR(player.step({1.2 - 0.4, 0, -1}).x, 0, 1e-9);
    EXPECT_NEAR(player.step({1.2 - 0.8, 0, -1}).x, 0.2, 1e-9);
}

TEST(Friction, StaysInItsConeOnRandomWaysOverRandomGeometry) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        HapticModel model = flat_wall(400);
        model.friction = random.real(0, 1);
        model.plane_count = random.whole(1, 6);
        for (int k = 1; k < model.plane_count; ++k) {
            const Vec3d n = normalized(Vec3d{0, 0, 1} + random.vector(0.9));
            model.planes[k] = {-1.0 * n, n};
        }
        model = *checked_model(model, 600);
        Player player({});
        Vec3d x{0, 0, 2};
        player.step(x, &model);
        for (int k = 0; k < 90; ++k) {
            x = x + random.vector(0.3) + Vec3d{0, 0, -0.03};
            player.step(x);
            const Vec3d nearest = nearest_free_position(model, x);
            const Vec3d force = player.state().force_n;
            if (nearest == x) {
                EXPECT_EQ(force, (Vec3d{0, 0, 0}));
                continue;
            }
            if (player.flags() & (kHapticForceLimit | kHapticRateLimit)) continue;
            const Vec3d n = normalized(nearest - x);
            const double normal = dot(force, n);
            EXPECT_GE(normal, -1e-12);
            EXPECT_LE(norm(force - normal * n), model.friction * normal + 1e-9);
        }
    }
}

TEST(Limits, BoundForceAndItsRate) {
    HapticSettings settings;
    settings.max_force_n = 0.5;
    settings.max_force_rate_n_s = 100;
    Player player(settings);
    const HapticModel model = flat_wall(600);
    player.step({0, 0, 0.5}, &model);
    double last = 0;
    std::uint32_t seen = 0;
    for (int k = 0; k < 30; ++k) {
        const double force = player.step({0, 0, -3}).z;
        EXPECT_LE(force, 0.5 + 1e-12);
        EXPECT_LE(std::abs(force - last), 0.1 + 1e-12);
        seen |= player.flags();
        last = force;
    }
    EXPECT_NEAR(last, 0.5, 1e-12);
    EXPECT_EQ(seen & (kHapticForceLimit | kHapticRateLimit),
              unsigned(kHapticForceLimit | kHapticRateLimit));
}

TEST(SafeStop, GoesToZeroWithoutAJumpAndComesBack) {
    HapticSettings settings;
    Player player(settings);
    HapticModel model = flat_wall(600);
    player.step({0, 0, 0}, &model);
    double last = 0;
    for (int k = 1; k <= 100; ++k) last = player.step({0, 0, -1}).z;
    EXPECT_NEAR(last, 0.6, 1e-12);  // still believed
    int zero_after = 0;
    for (int k = 1; k <= 150; ++k) {
        const double force = player.step({0, 0, -1}).z;
        EXPECT_LE(std::abs(force - last), 0.6 * 1e-3 / settings.ramp_s + 1e-12);
        EXPECT_LE(force, last);
        EXPECT_TRUE(player.flags() & kHapticStale);
        if (force == 0 && zero_after == 0) zero_after = k;
        last = force;
    }
    EXPECT_NEAR(zero_after, 100, 1);
    for (int k = 0; k < 120; ++k) {
        model.number++;
        const double force = player.step({0, 0, -1}, &model).z;
        EXPECT_LE(std::abs(force - last), 0.6 * 1e-3 / settings.ramp_s + 1e-9);
        last = force;
    }
    EXPECT_NEAR(last, 0.6, 1e-9);
    // A stop is requested while the tissue is running.
    for (int k = 0; k < 102; ++k) {
        model.number++;
        last = player.step({0, 0, -1}, &model, true).z;
    }
    EXPECT_EQ(last, 0);
}

TEST(Blending, ANewModelMakesNoJump) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Player player({});
        HapticModel model = flat_wall(300);
        player.step({0, 0, 0.2}, &model);
        Vec3d last = player.step({0, 0, -1});
        for (int k = 1; k < 300; ++k) {
            const bool is_new = k % 30 == 0;
            if (is_new) {  // the surface comes or goes, tilts, and is another tissue
                model = flat_wall(random.real(50, 600), model.number + 1);
                model.planes[0].point_mm.z = random.real(-2, 1);
                model.planes[0].normal = normalized(Vec3d{0, 0, 1} + random.vector(0.3));
                model = *checked_model(model, 600);
            }
            const Vec3d force = player.step({0, 0, -1}, is_new ? &model : nullptr);
            // A thirtieth of at most 1.8 N in each of 30 periods.
            EXPECT_LT(norm(force - last), 0.12) << "period " << k;
            last = force;
        }
    }
}

TEST(Workspace, PowerAtTheDeviceIsPowerInTheSceneTimesTheScales) {
    Random random(7);
    HapticSettings settings;
    settings.workspace = {random.rotation(false), 0.25, {10, 20, 30}, 2};
    const HapticWorkspace& w = settings.workspace;
    Player player(settings);
    HapticModel model = flat_wall(1);
    model.planes[0].point_mm = w.origin_mm;
    model = *checked_model(model, 1e4);
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c][c] = 900;
    const auto device_place = [&](double depth_mm) {
        return transposed(w.rotation) * Vec3d{0, 0, -depth_mm / w.scale};
    };
    player.step(device_place(-1), &model);
    const Vec3d force = player.step(device_place(0.3));
    EXPECT_NEAR(norm(force - transposed(w.rotation) * Vec3d{0, 0, 2 * 0.3 * 0.9}), 0, 1e-9);
}

TEST(Choi, FollowsTheLastTwoForcesAsFarAsIsAllowed) {
    for (const double limit : {0.5, 100.0}) {
        HapticRun run;
        run.scheme = HapticScheme::Extrapolate;
        run.extrapolated_updates = limit;
        run.update_periods = 30;
        run.settings.max_force_n = 50;
        run.settings.ramp_s = 0.001;
        VirtualDevice device({});
        std::vector<double> forces;
        run_haptics(
            device, run, 60,
            [&](Vec3d) {
                HapticModel model;
                model.force_n = {0, 0, forces.empty() ? 1 : 1.3};
                return model;
            },
            [&](const HapticReading&, const HapticModel*, const HapticState& state,
                const HapticForce&) {
                forces.push_back(state.force_n.z);
                return true;
            });
        EXPECT_NEAR(forces[29], 1, 1e-12);
        for (std::size_t k = 0; k < 30; ++k)
            EXPECT_NEAR(forces[30 + k], 1.3 + 0.3 * std::min(double(k) / 30, limit), 1e-9);
    }
}

TEST(Replay, OfWhatWasReadGivesTheSameBits) {
    HapticRun run;
    run.settings.max_stiffness_n_m = 800;
    run.settings.damping_n_s_m = 0.2;
    VirtualDeviceSettings settings;
    settings.encoder_mm = 0.02;
    settings.hand = active_hand({0.3, 0.1, 2}, 10);
    settings.hand.steady_n = {0, 0, -1};
    VirtualDevice device(settings);
    struct Period {
        HapticReading reading;
        bool is_fresh;
        HapticModel model;
        HapticForce force;
    };
    std::vector<Period> recorded;
    run_haptics(
        device, run, 3000,
        [](Vec3d x) {
            HapticModel model = flat_wall(700);
            model.friction = 0.3;
            model.planes[0].normal = normalized(Vec3d{0.1 * std::sin(x.x), 0, 1});
            return *checked_model(model, 800);
        },
        [&](const HapticReading& reading, const HapticModel* fresh, const HapticState&,
            const HapticForce& force) {
            recorded.push_back({reading, fresh != nullptr, fresh ? *fresh : HapticModel{}, force});
            return true;
        });
    HapticState state;
    double most = 0;
    for (const Period& p : recorded) {
        const HapticForce force =
            servo_step(run.settings, p.is_fresh ? &p.model : nullptr, p.reading, state);
        ASSERT_EQ(std::memcmp(&force.force_n, &p.force.force_n, sizeof force.force_n), 0);
        ASSERT_EQ(force.flags, p.force.flags);
        most = std::max(most, norm(force.force_n));
    }
    EXPECT_GT(most, 0.5);
}

}  // namespace
}  // namespace pliant
