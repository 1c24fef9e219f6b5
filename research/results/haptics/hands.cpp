// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hands.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace pliant::results {

TimeInHand in_hand(Hand hand, const HapticTissue& tissue, const HandSettings& how) {
    HapticRun run;
    run.scheme = how.scheme;
    run.settings.max_force_n = 7.9;
    run.settings.max_stiffness_n_m = 800;  // the device is stable up to 1000 N/m
    run.settings.bounded_energy = how.bounded_energy;
    run.delay_periods = how.delay_periods;
    VirtualDeviceSettings settings;
    settings.coulomb_n = 0.05;
    settings.encoder_mm = 0.02;
    settings.position_mm = {0, 0, 5};
    if (hand == Hand::Spring) settings.hand = spring_hand({0, 0, 5});
    if (hand == Hand::Active) settings.hand = active_hand({0, 0, 2}, 10);
    settings.hand.steady_n.z = hand == Hand::Active ? -0.5 : hand == Hand::Free ? -0.3 : 0;
    VirtualDevice device(settings);
    TimeInHand felt;
    Vec3d last_n{0, 0, 0};
    run_haptics(device, run, 1000 * std::int64_t(how.seconds), tissue,
                [&](const HapticReading& reading, const HapticModel* fresh,
                    const HapticState& state, const HapticForce&) {
                    const double t = 1e-9 * double(reading.time_ns);
                    if (hand == Hand::Spring)
                        device.hand().target_mm.z = 5 * std::cos(2 * std::numbers::pi * 0.7 * t);
                    if (hand == Hand::Free)  // the device's weight, lifted and dropped
                        device.hand().steady_n.z = std::fmod(t, 2) < 1.7 ? -0.3 : 1;
                    if (reading.time_ns % 20'000'000 == 0)
                        felt.passivity.emplace_back(t, 1000 * device.passivity_j());
                    felt.most_n = std::max(felt.most_n, norm(state.force_n));
                    if (fresh) felt.step_n = std::max(felt.step_n, norm(state.force_n - last_n));
                    last_n = state.force_n;
                    return true;
                });
    felt.lowest_mj = 1000 * device.lowest_passivity_j();
    return felt;
}

}  // namespace pliant::results
