// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The catheter's wire against the rod, whose solver has other unknowns.

#include <gtest/gtest.h>
#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "catheter/rod_wire.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using Wire = catheter::RodWire;
using catheter::WireSettings;

WireSettings straight(int segments) {
    WireSettings s;
    s.segments = segments;
    s.segment_mm = 2;
    s.mass_g_mm = 2e-3;
    s.bend.assign(std::size_t(segments), 5e6);
    s.twist.assign(std::size_t(segments), 4e6);
    s.stretch = 1e8;
    s.damping = 30;
    s.tip_segments = 5;
    return s;
}

TEST(Wire, MovesAsTheRodDoes) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        WireSettings s = straight(20);
        s.entry = random.vector(10);
        s.frame = rotation_by(random.vector(2));
        // The rod's base is half a joint away from its first segment.
        s.bend[0] *= 2;
        s.twist[0] *= 2;
        Wire wire(s, 40);
        auto rod = Rod::create({.segments = 20,
                                .length = 40,
                                .mass = 0.08,
                                .bend_stiffness = 5e6,
                                .twist_stiffness = 4e6,
                                .stretch_stiffness = 1e8,
                                .shear_stiffness = 1e8,
                                .tip_segments = 5,
                                .base = s.entry,
                                .frame = s.frame,
                                .time_step = 1e-4,
                                .iterations = 4,
                                .damping = 30});
        ASSERT_TRUE(rod.ok());
        const double first = random.real(-0.8, 0.8), second = random.real(-0.8, 0.8);
        for (int n = 1; n <= 400; ++n) {
            const double share = std::min(1.0, n / 200.0), turned = 0.7 * share;
            ASSERT_TRUE(rod->set_base(s.entry, s.frame * rotation_by({0, 0, turned})).ok());
            ASSERT_TRUE(
                rod->steer(share * std::hypot(first, second), std::atan2(second, first)).ok());
            ASSERT_TRUE(rod->step(1).ok());
            wire.feed(40, turned);
            wire.bend_tip(share * first, share * second);
            wire.predict(1e-4);
            for (int i = 0; i < 4; ++i) wire.solve({});
            wire.finish();
        }
        double moved = 0, off = 0;
        for (int n = 0; n <= 20; ++n) {
            const Vec3d rest = s.entry + (2.0 * n) * rotated(s.frame, {0, 0, 1});
            moved = std::max(moved, norm(rod->position(n) - rest));
            off = std::max(off, norm(rod->position(n) - wire.positions()[std::size_t(n)]));
        }
        std::printf("moved %.3f mm, apart %.2e mm\n", moved, off);
        EXPECT_GT(moved, 0.5);
        EXPECT_LT(off, 1e-3 * moved);
        EXPECT_LT(norm(rod->base_moment() - wire.base_moment()),
                  0.01 * norm(rod->base_moment()) + 1e3);
    }
}

}  // namespace
}  // namespace pliant::test
