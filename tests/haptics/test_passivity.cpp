// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The passivity observer over all tissues and all hands, for some seconds of simulated time;
// ./dev results haptics has a minute of each.
// Covers: haptics/feel_*.cpp.

#include <gtest/gtest.h>

#include <string>

#include "hands.h"
#include "tissues.h"

namespace pliant::results {
namespace {

TEST(Passivity, IsKeptByEachTissueInEachHand) {
    const TaskArena arena(2);
    const struct {
        const char* name;
        HapticTissue tissue;
    } tissues[] = {{"ChainMail, bone 6 mm deep", chainmail(layers(6), arena)},
                   {"springs", springs()},
                   {"position-based block", pbd(arena)},
                   {"catheter in a vessel", vessel(arena)}};
    for (const auto& [name, tissue] : tissues)
        for (const Hand hand : kHands) {
            SCOPED_TRACE(std::string(name) + ", hand " + std::to_string(int(hand)));
            const TimeInHand felt = in_hand(hand, tissue, {.seconds = 4});
            EXPECT_GE(felt.lowest_mj, -0.1);  // of a hand that spends some hundred a second
            EXPECT_GT(felt.most_n, 0.05);
        }
}

TEST(Passivity, IsSeenToBeLostWhereItIs) {
    const auto forces = [](Vec3d x) { return force_of_wall(300, x); };
    EXPECT_LT(in_hand(Hand::Active, forces, {.scheme = HapticScheme::Hold, .seconds = 4}).lowest_mj,
              -1);
}

}  // namespace
}  // namespace pliant::results
