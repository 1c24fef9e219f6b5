// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stability, in simulated time on a device that is a mass with friction: where it ends against
// [Colgate1997], and that the hand never gets energy that it didn't give.
// Covers: haptics/devices.cpp.

#include <gtest/gtest.h>
#include <pliant/view/haptics.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tissues.h"

namespace pliant {
namespace {

using results::force_of_wall;
using results::wall;

HapticSettings unlimited() {
    HapticSettings settings;
    settings.max_force_n = 1000;
    settings.max_force_rate_n_s = 1e6;
    settings.max_stiffness_n_m = 1e5;
    settings.ramp_s = 0.001;
    settings.bounded_energy = false;
    return settings;
}

/// Whether a push of the hand that is held against a wall swings up.
bool swings_up(double stiffness_n_m, HapticScheme scheme, int update_periods) {
    HapticRun run;
    run.settings = unlimited();
    run.scheme = scheme;
    run.update_periods = update_periods;
    const double press_n = stiffness_n_m * 2e-3;  // 2 mm deep
    VirtualDeviceSettings settings;
    settings.position_mm = {0, 0, -2.05};
    settings.hand.steady_n = {0, 0, -press_n};
    VirtualDevice device(settings);
    // The slowest growth that counts is that of 1 % beyond the boundary: σ = 1 % · b / 2m.
    const std::int64_t periods = 30'000;
    double early = 0, late = 0;
    bool has_left = false;
    run_haptics(
        device, run, periods,
        [&](Vec3d x) {
            return scheme == HapticScheme::LinearLaw ? wall(stiffness_n_m)
                                                     : force_of_wall(stiffness_n_m, x);
        },
        [&](const HapticReading& reading, const HapticModel*, const HapticState&,
            const HapticForce&) {
            const double off = std::abs(device.position_mm().z + 2);
            // The first period has no force yet.
            if (reading.time_ns > 1'000'000'000 && reading.time_ns < 3'000'000'000)
                early = std::max(early, off);
            if (reading.time_ns > (periods - 2000) * 1'000'000) late = std::max(late, off);
            has_left = off > 1.9;  // it leaves the wall, and is no linear system any more
            return !has_left;
        });
    return has_left || late > early;
}

double boundary_n_m(HapticScheme scheme, int update_periods, double low, double high) {
    EXPECT_FALSE(swings_up(low, scheme, update_periods));
    EXPECT_TRUE(swings_up(high, scheme, update_periods));
    while (high > 1.01 * low) {
        const double middle = std::sqrt(low * high);
        (swings_up(middle, scheme, update_periods) ? high : low) = middle;
    }
    return std::sqrt(low * high);
}

/// Stability boundary of a mass with damping and a force −K x held for T: the determinant of its
/// map between samples is 1.
double exact_boundary_n_m(double mass, double b, double period) {
    const double a = std::exp(-b * period / mass);
    const double alpha = mass / b * (1 - a), gamma = (1 - a) / b, beta = (period - alpha) / b;
    return (1 - a) / (gamma * alpha - beta * a);
}

TEST(Stability, EndsAtTwiceTheDampingOverThePeriod) {
    const double found = boundary_n_m(HapticScheme::LinearLaw, 1, 500, 2000);
    EXPECT_NEAR(found, 1000, 100);
    EXPECT_NEAR(found / exact_boundary_n_m(0.1, 0.5, 1e-3), 1, 0.02);
}

TEST(Stability, OfForcesHeldAt30HzEndsAtAThirtieth) {
    const double found = boundary_n_m(HapticScheme::Hold, 33, 10, 100);
    EXPECT_NEAR(found, 2 * 0.5 / 0.033, 0.1 * 2 * 0.5 / 0.033);
    EXPECT_NEAR(found / exact_boundary_n_m(0.1, 0.5, 0.033), 1, 0.02);
}

TEST(Stability, OfALocalModelDoesNotDependOnHowOftenItComes) {
    EXPECT_NEAR(boundary_n_m(HapticScheme::LinearLaw, 33, 500, 2000), 1000, 100);
}

TEST(VirtualDevice, CountsAllEnergy) {
    VirtualDeviceSettings settings;
    settings.coulomb_n = 0.05;
    settings.hand = spring_hand({0, 1, -3});
    settings.hand.sine_n = {0.5, 0, 2};
    settings.hand.frequency_hz = 10;
    settings.velocity_mm_s = {10, 20, 100};
    VirtualDevice device(settings);
    const double at_first = device.kinetic_j();
    double work_by_way = 0;
    for (int k = 0; k < 5000; ++k) {
        const Vec3d force{0.3 * std::sin(0.01 * k), 0.1, -0.002 * device.position_mm().z};
        const Vec3d before = device.position_mm();
        device.advance(force, 1e-3);
        work_by_way += 1e-3 * dot(force, device.position_mm() - before);
    }
    EXPECT_GT(device.lost_j(), 1e-3);
    EXPECT_NEAR(device.kinetic_j() - at_first,
                device.work_of_servo_j() + device.work_of_hand_j() - device.lost_j(), 1e-12);
    EXPECT_NEAR(device.work_of_servo_j(), work_by_way, 1e-3 * std::abs(work_by_way) + 1e-7);
}

TEST(VirtualDevice, SwingsAsItsHandsSpringAndMassSay) {
    VirtualDeviceSettings settings;
    settings.damping_n_s_m = 0;
    settings.hand = spring_hand({0, 0, 0}, 400, 0);
    settings.position_mm = {5, 0, 0};
    VirtualDevice device(settings);
    const double omega = std::sqrt(400 / 0.1);
    for (int k = 1; k <= 1000; ++k) {
        device.advance({0, 0, 0}, 1e-3);
        EXPECT_NEAR(device.position_mm().x, 5 * std::cos(omega * 1e-3 * k), 0.01);
    }
}

/// Energy of a free device before and after it hits a wall with 0.3 m/s, as a ratio.
double rebound(HapticScheme scheme, double stiffness_n_m, double encoder_mm) {
    HapticRun run;
    run.scheme = scheme;
    run.settings.max_force_n = 20;
    run.settings.max_stiffness_n_m = stiffness_n_m;
    run.settings.bounded_energy = false;
    VirtualDeviceSettings settings;
    const double far_mm = 60;  // the servo's ramp is over before the wall
    settings.position_mm = {0, 0, far_mm};
    settings.velocity_mm_s = {0, 0, -300 - far_mm * 0.5 / 0.1};  // compensates the damping on the
                                                                 // way
    settings.encoder_mm = encoder_mm;
    VirtualDevice device(settings);
    double before = 0, after = 0;
    bool has_hit = false;
    run_haptics(
        device, run, 3000,
        [&](Vec3d x) {
            return scheme == HapticScheme::LinearLaw ? wall(stiffness_n_m)
                                                     : force_of_wall(stiffness_n_m, x);
        },
        [&](const HapticReading&, const HapticModel*, const HapticState& state,
            const HapticForce&) {
            if (!has_hit && device.position_mm().z > 0) before = device.kinetic_j();
            has_hit = has_hit || state.in_contact;
            // Off the wall again, with no force any more.
            if (has_hit && state.force_n == Vec3d{0, 0, 0} && device.position_mm().z > 0 &&
                device.velocity_mm_s().z > 0)
                after = std::max(after, device.kinetic_j());
            return true;
        });
    EXPECT_NEAR(std::sqrt(before / (0.5 * 0.1)), 0.3, 0.01);
    return after / before;
}

TEST(WallTap, GainsNoEnergyWithALocalModelAndDoesWithTheOthers) {
    for (const double stiffness_n_m : {100., 300., 600., 900.})
        for (const double encoder_mm : {0., 0.03}) {
            const double ratio = rebound(HapticScheme::LinearLaw, stiffness_n_m, encoder_mm);
            EXPECT_GT(ratio, 0.2) << stiffness_n_m;
            EXPECT_LT(ratio, 1) << stiffness_n_m;
        }
    EXPECT_GT(rebound(HapticScheme::Hold, 300, 0), 1.5);
    EXPECT_GT(rebound(HapticScheme::Extrapolate, 300, 0), 1.5);
}

enum class Hand { Free, Spring, Active };

/// Lowest passivity [J] and how much force there was, in a minute.
double lowest_passivity_j(Hand hand, HapticScheme scheme, const HapticTissue& tissue,
                          int delay_periods, bool bounded_energy, double* most_force_n = nullptr) {
    HapticRun run;
    run.scheme = scheme;
    run.settings.max_force_n = 8;
    run.settings.bounded_energy = bounded_energy;
    run.delay_periods = delay_periods;
    VirtualDeviceSettings settings;
    settings.coulomb_n = 0.05;
    settings.encoder_mm = 0.02;
    settings.position_mm = {0, 0, 5};
    if (hand == Hand::Spring) settings.hand = spring_hand({0, 0, 5});
    if (hand == Hand::Active) settings.hand = active_hand({0.2, 0.1, 2}, 10);
    if (hand == Hand::Active) settings.hand.steady_n = {0, 0, -1};
    VirtualDevice device(settings);
    if (hand == Hand::Free) device.hand().steady_n = {0, 0, -0.3};  // its weight
    run_haptics(device, run, 60'000, tissue,
                [&](const HapticReading& reading, const HapticModel*, const HapticState& state,
                    const HapticForce&) {
                    const double t = 1e-9 * double(reading.time_ns);
                    if (hand == Hand::Spring)
                        device.hand().target_mm = {3 * std::sin(1.1 * t), 0,
                                                   5 * std::cos(2 * std::numbers::pi * 0.7 * t)};
                    // Lifted and dropped again.
                    if (hand == Hand::Free)
                        device.hand().steady_n.z = std::fmod(t, 2) < 1.7 ? -0.3 : 1;
                    if (most_force_n) *most_force_n = std::max(*most_force_n, norm(state.force_n));
                    return true;
                });
    return device.lowest_passivity_j();
}

TEST(Passivity, StaysAboveItsBoundForAMinuteWithEachHand) {
    for (const Hand hand : {Hand::Free, Hand::Spring, Hand::Active}) {
        SCOPED_TRACE("hand " + std::to_string(int(hand)));
        double most_n = 0;
        const auto stiff = [](Vec3d) {
            HapticModel model = wall(600);
            model.friction = 0.3;
            return model;
        };
        for (const bool bounded : {false, true}) {
            EXPECT_GE(lowest_passivity_j(hand, HapticScheme::LinearLaw, stiff, 0, bounded, &most_n),
                      -1e-9);
            EXPECT_GT(most_n, 0.2);
        }
        // A law that is a whole solution behind.
        EXPECT_GE(lowest_passivity_j(hand, HapticScheme::LinearLaw, results::hardening(), 33, true,
                                     &most_n),
                  -1e-4);
        EXPECT_GT(most_n, 0.2);
    }
}

TEST(Passivity, IsLostByForcesThatAreHeldOrExtrapolatedAndByLateLaws) {
    const auto forces = [](Vec3d x) { return force_of_wall(300, x); };
    EXPECT_LT(lowest_passivity_j(Hand::Active, HapticScheme::Hold, forces, 0, true), -0.05);
    EXPECT_LT(lowest_passivity_j(Hand::Active, HapticScheme::Extrapolate, forces, 0, true), -0.05);
    EXPECT_LT(
        lowest_passivity_j(Hand::Active, HapticScheme::LinearLaw, results::hardening(), 33, false),
        -0.05);
}

}  // namespace
}  // namespace pliant
