// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A simulated device that feels a tissue in somebody's hand for a while, and what became of its
// energy. Tissues have their surface at z = 0.

#pragma once

#include <pliant/haptics_virtual.h>

#include <array>
#include <utility>
#include <vector>

namespace pliant::results {

enum class Hand {
    Free,    ///< the device's weight, lifted and dropped each two seconds
    Spring,  ///< goes up and down by 5 mm, 0.7 times a second
    Active,  ///< shakes with 2 N at 10 Hz, and presses a little
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
    double lowest_mj = 0;                              ///< below 0: made from nothing
    double most_n = 0;
    double step_n = 0;  ///< largest step of the force in a period with a new model
};

TimeInHand in_hand(Hand hand, const HapticTissue& tissue, const HandSettings& how);

}  // namespace pliant::results
