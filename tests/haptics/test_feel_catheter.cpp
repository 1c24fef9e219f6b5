// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter in the hand: against a wire modelled as a spring, with a known solution, and against
// the simulated wire in a bend.

#include <gtest/gtest.h>
#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "tissues.h"

namespace pliant {
namespace {

constexpr double kRad = std::numbers::pi / 180;

/// Force on a hand along the rail, opposite to the motion [N].
double felt_n(const HapticModel& model) {
    return model.force_n.z;  // forward is −z
}
Vec3d at(double ahead_mm) {
    return {0, 0, -ahead_mm};
}

/// A wire without mass that goes where it is told, with a force that depends on how far.
class SimpleWire {
  public:
    explicit SimpleWire(std::function<double(double)> force_n, double inserted_mm = 20)
        : m_force_n(std::move(force_n)) {
        m_now.inserted_mm = inserted_mm;
        m_now.force_n = m_force_n(inserted_mm);
    }
    const CatheterMeasures& now() const { return m_now; }
    void go(CatheterFeel::Motion motion, double seconds) {
        m_now.time_s += seconds;
        m_now.inserted_mm += seconds * motion.insert_mm_s;
        m_now.rotated_deg += seconds * motion.rotate_deg_s;
        m_now.force_n = m_force_n(m_now.inserted_mm);
    }

  private:
    std::function<double(double)> m_force_n;
    CatheterMeasures m_now;
};

CatheterFeel feel_of(CatheterFeelSettings settings = {}) {
    auto feel = CatheterFeel::create(settings);
    EXPECT_TRUE(feel.ok());
    return std::move(*feel);
}

TEST(CatheterFeel, RestsWhereTheCouplingHoldsTheWiresForce) {
    // From free to far stiffer than the coupling, in steps of the simulation short and long.
    for (const double wire_n_mm : {0.0, 0.02, 0.3, 3.0, 9.0})
        for (const double step_s : {1.0 / 60, 1.0 / 15}) {
            SCOPED_TRACE(std::to_string(wire_n_mm) + " N/mm, " + std::to_string(step_s));
            SimpleWire wire([&](double s) { return wire_n_mm * (s - 20); });
            CatheterFeel feel = feel_of();
            feel.take_hold({0, 0, 0}, 0, wire.now());
            double most_mm = 0;
            for (int n = 0; n < 240; ++n) {
                wire.go(feel.follow(at(4), 0, wire.now()), step_s);
                most_mm = std::max(most_mm, wire.now().inserted_mm - 20);
            }
            // k_c (x − s) = k_w s
            const double expected = 0.3 * 4 / (0.3 + wire_n_mm);
            EXPECT_NEAR(wire.now().inserted_mm - 20, expected, 0.021);
            EXPECT_LT(most_mm, 4 * std::max(1.0, 30 * step_s) + 0.01);  // of the first step
            const HapticModel model = feel.model(at(4), wire.now());
            EXPECT_NEAR(felt_n(model), wire.now().force_n, 1e-12);
            EXPECT_NEAR(feel.ahead_mm(at(4), wire.now()), 4 - expected, 0.021);
            // No stiffer than the coupling, and along the rail only.
            const double k = model.stiffness_n_m.columns[2].z;
            EXPECT_LE(k, 300);
            EXPECT_GE(k, 0);
            EXPECT_EQ(model.stiffness_n_m.columns[0], (Vec3d{0, 0, 0}));
            EXPECT_TRUE(wire_n_mm > 0 || k == 0);
        }
}

TEST(CatheterFeel, OfAWireThatGoesFreelyIsNothing) {
    SimpleWire wire([](double) { return 0.0; });
    CatheterFeel feel = feel_of();
    feel.take_hold({5, 6, 7}, 0, wire.now());
    for (int n = 0; n < 60; ++n) {
        const Vec3d hand = Vec3d{5, 6, 7} + at(0.5 * n);
        wire.go(feel.follow(hand, 0, wire.now()), 1.0 / 60);
        const HapticModel model = feel.model(hand, wire.now());
        EXPECT_NEAR(felt_n(model), 0, 1e-12);
        EXPECT_EQ(model.stiffness_n_m.columns[2].z, 0);
    }
    EXPECT_NEAR(wire.now().inserted_mm, 20 + 29.5, 1.1);  // 30 mm/s, a thirtieth of a second late
}

TEST(CatheterFeel, EndsWhereNothingIsLeftToInsertAndGoesNoFasterThanItMay) {
    SimpleWire wire([](double) { return 0.0; });
    CatheterFeel feel = feel_of({.length_mm = 25});
    feel.take_hold({0, 0, 0}, 0, wire.now());
    const CatheterFeel::Motion fast = feel.follow(at(60), 0, wire.now());
    EXPECT_NEAR(fast.insert_mm_s, 100, 1e-9);
    // Force of the lag: 60 mm minus the motion in a thirtieth of a second.
    EXPECT_NEAR(felt_n(feel.model(at(60), wire.now())), 0.3 * (60 - 100.0 / 30), 1e-9);
    for (int n = 0; n < 100; ++n) wire.go(feel.follow(at(8), 0, wire.now()), 1.0 / 60);
    EXPECT_NEAR(wire.now().inserted_mm, 25, 0.021);
    const HapticModel model = feel.model(at(8), wire.now());
    EXPECT_NEAR(felt_n(model), 0.3 * 3, 0.02);  // N/mm beyond the end
    EXPECT_NEAR(model.stiffness_n_m.columns[2].z, 300, 1e-9);
    for (int n = 0; n < 100; ++n) wire.go(feel.follow(at(-30), 0, wire.now()), 1.0 / 60);
    EXPECT_NEAR(wire.now().inserted_mm, 0, 0.021);
    EXPECT_NEAR(felt_n(feel.model(at(-30), wire.now())), -0.3 * 10, 0.02);
}

TEST(CatheterFeel, TurnsAsOftenAsTheHand) {
    SimpleWire wire([](double) { return 0.0; });
    CatheterFeel feel = feel_of();
    feel.take_hold({0, 0, 0}, 170 * kRad, wire.now());
    for (int deg = 170; deg <= 170 + 900; deg += 5)  // as a device says it, within ±180
        wire.go(feel.follow({0, 0, 0}, std::remainder(deg, 360) * kRad, wire.now()), 1.0 / 60);
    for (int n = 0; n < 60; ++n)
        wire.go(feel.follow({0, 0, 0}, std::remainder(1070, 360) * kRad, wire.now()), 1.0 / 60);
    EXPECT_NEAR(wire.now().rotated_deg, 900, 0.1);
    EXPECT_EQ(wire.now().inserted_mm, 20);
}

TEST(CatheterFeel, HoldsNothingUntilItTakesHold) {
    SimpleWire wire([](double s) { return 0.1 * (s - 18); });
    CatheterFeel feel = feel_of();
    EXPECT_FALSE(feel.holds());
    EXPECT_FALSE(feel.model({0, 0, 0}, wire.now()).held);
    feel.take_hold(at(3), 0, wire.now());
    EXPECT_TRUE(feel.holds());
    // Where it takes hold is where the wire is.
    EXPECT_EQ(feel.ahead_mm(at(3), wire.now()), 0);
    feel.let_go();
    EXPECT_FALSE(feel.model(at(3), wire.now()).held);
}

TEST(CatheterFeel, RefusesSettingsOutOfRange) {
    const auto message_of = [](const CatheterFeelSettings& settings) {
        const auto feel = CatheterFeel::create(settings);
        return feel.ok() ? std::string() : feel.error().message;
    };
    EXPECT_EQ(message_of({.forward = {0, 0, 0}}), "catheter feel: forward: expected a direction");
    EXPECT_NE(message_of({.coupling_n_m = 0}).find("coupling_n_m: expected above 0"),
              std::string::npos);
    EXPECT_NE(message_of({.length_mm = std::nan("")}).find("length_mm"), std::string::npos);
}

/// A stiff wire in a soft bend, fed by a hand and felt through the servo's own function.
TEST(CatheterFeel, AtRestIsTheForceAtTheWiresBase) {
    const TaskArena arena(2);
    auto scene = results::wire_in_bend();
    CatheterFeel feel = feel_of({.forward = {0, 0, 1}, .length_mm = 120});
    feel.take_hold({0, 0, 0}, 0, scene.quick_measures());
    HapticSettings settings;
    HapticState state;
    HapticReading reading;
    double moving_n = 0;
    constexpr int kUpdates = 120, kPeriods = 32;
    for (int n = 0; n < kUpdates; ++n) {
        // 25 mm in a second and a half, and then it stands still.
        const double hand_mm = std::min(25.0, 25.0 * n / 45);
        const auto motion = feel.follow({0, 0, hand_mm}, 0, scene.quick_measures());
        ASSERT_TRUE(scene.command({.insert_mm_s = motion.insert_mm_s}).ok());
        ASSERT_TRUE(scene.step(8, arena).ok());
        auto model = checked_model(feel.model({0, 0, hand_mm}, scene.quick_measures()), 600);
        ASSERT_TRUE(model.ok());
        model->number = n + 1;
        for (int k = 0; k < kPeriods; ++k) {
            reading.position_mm = {0, 0, hand_mm};
            reading.time_ns += 1'000'000;
            servo_step(settings, k == 0 ? &*model : nullptr, reading, state);
        }
        moving_n = std::max(moving_n, norm(state.force_n));
    }
    const CatheterMeasures rest = scene.quick_measures();
    EXPECT_GT(rest.force_n, 0.02);  // the bend pushes back
    EXPECT_GT(rest.inserted_mm, 27 + 20);
    // Against the way in, and as large as at the base: the bound of docs/method/haptics.md.
    EXPECT_NEAR(-state.force_n.z, rest.force_n, 0.002 + 0.02 * rest.force_n);
    EXPECT_GT(moving_n, rest.force_n);
}

}  // namespace
}  // namespace pliant
