// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wire of tetrahedra against beams, and its cut into tetrahedra.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "rods/tet_wire.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using catheter::Corners;
using catheter::TetWire;
using catheter::WireContact;
using catheter::WireSettings;

WireSettings straight_body(int segments, double bend = 5e6, double twist = 2e6) {
    WireSettings s;
    s.segments = segments;
    s.segment_mm = 2;
    s.mass_g_mm = 2e-3;
    s.bend.assign(std::size_t(segments), bend);
    s.twist.assign(std::size_t(segments), twist);
    s.damping = 30;
    s.tip_segments = 5;
    return s;
}

TEST(TetSegment, TetrahedraFillItAndFitTheirNeighbours) {
    for (const bool odd : {false, true}) {
        const Corners x = catheter::corners_at_rest(0.9, 2, {0, 0, 0});
        double volume = 0;
        const auto bars = catheter::bars_across(odd);
        const auto ring = catheter::bars_in_ring();
        const auto is_bar = [&](std::uint8_t a, std::uint8_t b) {
            const auto same = [&](int p, int q) {
                return (p == a && q == b) || (p == b && q == a);
            };
            for (const auto& bar : bars)
                if (same(bar.a, bar.b)) return true;
            for (const auto& bar : ring)
                if (same(bar[0], bar[1]) || same(bar[0] + 4, bar[1] + 4)) return true;
            return false;
        };
        for (const auto& tet : catheter::tetrahedra(odd)) {
            EXPECT_GT(catheter::volume_of(tet, x), 0);
            volume += catheter::volume_of(tet, x);
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t b = 0; b < a; ++b)
                    // Of the middle, aslant, is none.
                    EXPECT_EQ(is_bar(tet[a], tet[b]), tet[a] / 4 == tet[b] / 4 ||
                                                          (tet[a] + tet[b]) % 2 == 1 ||
                                                          (tet[a] - tet[b]) % 4 == 0);
        }
        EXPECT_NEAR(volume, 2 * 2 * 0.9 * 0.9, 1e-12);  // a square with diagonals of 1.8
    }
}

TEST(TetSegment, VolumesGradientsAreThoseOfFiniteDifferences) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Corners x;
        for (Vec3d& p : x) p = random.vector(1);
        const auto tet = catheter::tetrahedra(seed % 2)[seed % 6];
        const auto g = catheter::volume_gradient(tet, x);
        EXPECT_LT(norm(g[0] + g[1] + g[2] + g[3]), 1e-12);
        for (std::size_t k = 0; k < 4; ++k)
            for (int c = 0; c < 3; ++c) {
                Corners more = x, less = x;
                more[tet[k]][c] += 1e-5;
                less[tet[k]][c] -= 1e-5;
                const double found =
                    (catheter::volume_of(tet, more) - catheter::volume_of(tet, less)) / 2e-5;
                EXPECT_NEAR(found, g[k][c], 1e-9);
            }
    }
}

/// Steps until it rests; the contact's position goes `by` aside little by little.
void settle(TetWire& wire, WireContact* c, double by, int steps = 600) {
    for (int n = 1; n <= steps; ++n) {
        if (c) c->least = by * std::min(1.0, 3.0 * n / steps);
        wire.predict(1e-3);
        for (int i = 0; i < 4; ++i)
            wire.solve(c ? std::span<WireContact>(c, 1) : std::span<WireContact>());
        wire.finish();
    }
}

TEST(TetWire, BendsAsABeam) {
    for (const Vec3d& normal : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0.6, -0.8, 0}})
        for (const double along : {0.4, 1.0}) {
            TetWire wire(straight_body(40), 0.9, 80);
            WireContact c;
            c.segment = 39;
            c.along = along;
            c.normal = normal;
            c.compliance = 1e-9;
            const double at = 2 * (39 + along), by = 0.02 * at;
            settle(wire, &c, by);
            const double expected = 3 * 5e6 * by / (at * at * at), force = dot(c.force, normal);
            std::printf("at %.1f mm: %.1f expected %.1f\n", at, force, expected);
            EXPECT_NEAR(force, expected, 0.03 * expected);
            EXPECT_NEAR(dot(wire.base_force(), normal), force, 1e-3 * expected);
            EXPECT_NEAR(norm(wire.base_moment()), at * force, 5e-3 * at * expected);
            EXPECT_NEAR(wire.elastic_energy(), 0.5 * force * by, 0.01 * force * by);
        }
}

// Near its end it is clamped between two walls with friction, while its base is turned.
TEST(TetWire, TwistsAsABeam) {
    TetWire wire(straight_body(40), 0.9, 80);
    WireContact clamp[2];
    for (const int side : {0, 1}) {
        WireContact& c = clamp[side];
        c.segment = 38;
        c.along = 0.5;
        c.normal = {side ? -1.0 : 1.0, 0, 0};
        c.lever = -0.9 * c.normal;
        c.compliance = 1e-9;
        c.friction = 10;
        c.sticking_mm = 1e-3;
        c.least = 1e-3;
    }
    for (int n = 1; n <= 1000; ++n) {
        wire.feed(80, 0.3 * std::min(1.0, n / 400.0));
        wire.predict(1e-3);
        const auto& x = wire.positions_before();
        for (WireContact& c : clamp) c.sticks = 0.5 * (x[38] + x[39]);
        for (int i = 0; i < 4; ++i) wire.solve(clamp);
        wire.finish();
    }
    const double tip = rotation_vector(wire.tip_frame()).z, moment = wire.base_moment().z;
    std::printf("tip turned by %.4f, moment %.1f\n", tip, moment);
    const double expected = -2e6 * (0.3 - tip) / 77;
    EXPECT_LT(tip, 0.1);
    EXPECT_NEAR(moment, expected, 0.03 * std::abs(expected));
}

TEST(TetWire, TurnedAtItsBaseItsTipTurns) {
    TetWire wire(straight_body(40), 0.9, 80);
    for (int n = 1; n <= 2000; ++n) {
        wire.feed(80, 1.2 * std::min(1.0, n / 1000.0));
        wire.predict(1e-3);
        for (int i = 0; i < 3; ++i) wire.solve({});
        wire.finish();
    }
    const Vec3d turned = rotation_vector(wire.tip_frame());
    EXPECT_NEAR(turned.z, 1.2, 2e-3);
    EXPECT_LT(std::hypot(turned.x, turned.y), 1e-3);
}

TEST(TetWire, ItsTipBendsAboutBothAxes) {
    for (const auto& [first, second] : {std::pair{0.8, 0.0}, {0.0, 0.8}, {-0.5, 0.6}}) {
        TetWire wire(straight_body(20), 0.9, 40);
        wire.bend_tip(first, second);
        settle(wire, nullptr, 0);
        const Vec3d ahead = rotated(wire.tip_frame(), {0, 0, 1});
        const double angle = std::hypot(first, second), across = std::hypot(ahead.x, ahead.y);
        // Of five joints, the last segment points as its middle does.
        EXPECT_NEAR(std::atan2(across, ahead.z), 0.9 * angle, 0.01);
        EXPECT_NEAR(ahead.x / across, first / angle, 0.02);
        EXPECT_NEAR(ahead.y / across, second / angle, 0.02);
        EXPECT_LT(wire.elastic_energy(), 1e-3);
        const TetMesh mesh = wire.mesh();
        for (const auto& t : mesh.cells) {
            const auto at = [&](std::size_t k) { return mesh.nodes_mm[std::size_t(t[k])]; };
            EXPECT_GT(dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)), 0);
        }
    }
}

TEST(TetWire, SomeTwistIsOutOfReach) {
    const auto bounds = catheter::twist_bounds(20, 0.9, 2);
    std::printf("twist of EI 20: %.2f to %.2f\n", bounds.least, bounds.most);
    EXPECT_LT(bounds.least, 5);
    EXPECT_GT(bounds.most, 40);
    EXPECT_GT(catheter::stiffness_for(20, bounds.least, 0.9, 2).aslant, 0);
    EXPECT_LT(catheter::stiffness_for(20, 0, 0.9, 2).aslant, 0);
}

}  // namespace
}  // namespace pliant::test
