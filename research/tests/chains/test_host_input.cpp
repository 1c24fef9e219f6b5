// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes and limits from a program: invalid ones are refused with a one-line message.

#include <gtest/gtest.h>
#include <pliant/research/graph.h>
#include <pliant/research/objects.h>

#include <array>

#include "support/broken_volumes.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

TEST(HostVolumes, AnObjectWithABrokenFieldIsRefused) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        ObjectSpace space(one_thread());
        expect_refused(space.add_object(broken.volume, {}, false), "object 0." + broken.field);
    }
}

TEST(HostLaws, AGraphRefusesALimitOutOfItsRange) {
    const std::array<Vec3d, 2> positions{Vec3d{0, 0, 0}, Vec3d{1, 2, 3}};
    const std::array<ChainEdge, 1> edges{ChainEdge{0, 1}};
    const auto makes = [&](const ElementLimits& limits) {
        const std::array materials{limits};
        return ChainGraph::create(positions, materials, {}, edges).ok();
    };
    const ElementLimits good{{0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}, {0.1, 0.1, 0.1}, 10, false};
    EXPECT_TRUE(makes(good));
    for (const double wrong : {kNotANumber, -1.0, -1e-9, -kInfinity}) {
        for (int axis = 0; axis < 3; ++axis)
            for (Vec3d ElementLimits::*field :
                 {&ElementLimits::compress, &ElementLimits::stretch, &ElementLimits::shear}) {
                ElementLimits bad = good;
                (bad.*field)[axis] = wrong;
                EXPECT_FALSE(makes(bad)) << wrong;
            }
        ElementLimits bad = good;
        bad.max_movement_mm = wrong;
        EXPECT_FALSE(makes(bad)) << wrong;
    }
    ElementLimits bad = good;
    bad.compress.y = 1.0001;
    EXPECT_FALSE(makes(bad));
}

}  // namespace
}  // namespace pliant::test
