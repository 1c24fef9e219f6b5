// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A simulated device in a simulated hand that touches a tissue for a while, and its energy balance.
// Tissues have their surface at z = 0.

#pragma once

#include <pliant/view/haptics.h>

#include <array>
#include <utility>
#include <vector>

#include "haptic_run.h"

namespace pliant::results {

enum class Hand {
    Free,    ///< the device's weight, lifted and dropped each two seconds
    Spring,  ///< goes up and down by 5 mm, 0.7 times a second
    Active,  ///< oscillates with 2 N at 10 Hz, with a small steady force
};
inline constexpr std::array kHands = {Hand::Free, Hand::Spring, Hand::Active};

struct HandSettings {
    HapticScheme scheme = HapticScheme::LinearLaw;
    int delay_periods = 0;
    bool bounded_energy = true;
    int seconds = 60;
};

struct TimeInHand {
    std::vector<std::pair<double, double>> passivity;  ///< [s, mJ], 50 times a second
    double lowest_mj = 0;                              ///< negative: energy was generated
    double most_n = 0;
    double step_n = 0;  ///< largest step of the force in a period with a new model
};

TimeInHand in_hand(Hand hand, const HapticTissue& tissue, const HandSettings& how);

}  // namespace pliant::results
