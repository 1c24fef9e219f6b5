// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wire's contact against beams.
// Covers: catheter/rod_wire.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "catheter/rod_wire.h"

namespace pliant::test {
namespace {

using Wire = catheter::RodWire;
using catheter::WireContact;
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

/// Pushes a cantilever aside by `by` at a point, until it rests.
WireContact pressed(Wire& wire, std::int32_t segment, double along, double by) {
    WireContact c;
    c.segment = segment;
    c.along = along;
    c.normal = {1, 0, 0};
    c.compliance = 1e-9;
    for (int n = 1; n <= 1500; ++n) {
        c.least = by * std::min(1.0, n / 500.0);
        wire.predict(1e-3);
        for (int i = 0; i < 3; ++i) wire.solve({&c, 1});
        wire.finish();
    }
    return c;
}

TEST(Wire, ContactBendsItAsABeam) {
    for (const double along : {0.0, 0.4, 1.0})
        for (const std::int32_t segment : {15, 39}) {
            WireSettings s = straight(40);
            s.bend[0] *= 2;  // clamped at the first node
            Wire wire(s, 80);
            const double at = 2 * (segment + along), by = 0.02 * at;
            const WireContact c = pressed(wire, segment, along, by);
            const double expected = 3 * 5e6 * by / (at * at * at);
            std::printf("at %.1f mm: %.1f expected %.1f\n", at, c.force.x, expected);
            EXPECT_NEAR(c.force.x, expected, 0.01 * expected);
            EXPECT_NEAR(wire.base_force().x, c.force.x, 1e-3 * expected);
            EXPECT_NEAR(wire.base_moment().y, at * c.force.x, 2e-3 * at * expected);
        }
}

/// A force that doesn't depend on where the wire goes: a spring so soft that it is always the same.
WireContact load_on(std::int32_t segment, double along, Vec3d force, Vec3d place) {
    WireContact c;
    c.segment = segment;
    c.along = along;
    c.compliance = 1;
    c.normal = normalized(force);
    c.least = dot(c.normal, place) + c.compliance * norm(force);
    return c;
}

constexpr double kStickingSpeed = 0.5;  ///< [mm/s]

/// Start of the wire's friction in a step of h seconds.
void begin_friction(WireContact& c, double friction, const Wire& wire, double h) {
    const auto s = std::size_t(c.segment);
    const auto& x = wire.positions_before();
    c.friction = friction;
    c.sticking_mm = kStickingSpeed * h;
    c.sticks = (1 - c.along) * x[s] + c.along * x[s + 1];
}

/// A floor at x = 0 under the tip of 20 segments.
WireContact floor_under_tip(double compliance, double friction, const Wire& wire, double h) {
    WireContact c;
    c.segment = 19;
    c.along = 1;
    c.normal = {1, 0, 0};
    c.compliance = compliance;
    begin_friction(c, friction, wire, h);
    return c;
}

// Its tip is pressed to a floor with 500 uN and drawn over it: the base feels the coefficient times
// that, and below the sticking speed in proportion less.
TEST(Wire, FrictionIsCoulombs) {
    const double h = 1e-3, load = 500;
    for (const double friction : {0.0, 0.2, 0.6})
        for (const double speed : {10.0, -10.0, 0.25, -0.1}) {
            const WireSettings settings = straight(20);
            Wire wire(settings, 30);
            double inserted = 30, push = 0, drag = 0, base = 0;
            for (int n = 1; n <= 600; ++n) {
                inserted += h * speed;
                wire.feed(inserted, 0);
                wire.predict(h);
                WireContact c[2] = {load_on(19, 1, {-load, 0, 0}, {0, 0, 0}),
                                    floor_under_tip(1e-8, friction, wire, h)};
                for (int i = 0; i < 3; ++i) wire.solve(c);
                wire.finish();
                if (n <= 400) continue;
                push += c[1].force.x / 200;
                drag -= c[1].force.z / 200;
                base -= (wire.base_force().z +
                         settings.damping * settings.mass_g_mm * inserted * speed) /
                        200;  // up to damping
            }
            const double share = std::clamp(speed / kStickingSpeed, -1.0, 1.0);
            std::printf("friction %g, %g mm/s: push %.2f, drag %.2f, base %.2f uN\n", friction,
                        speed, push, drag, base);
            EXPECT_NEAR(push, load, 0.002 * load);
            EXPECT_NEAR(drag, share * friction * load, 0.005 * load);
            EXPECT_NEAR(base, drag, 0.002 * load);
        }
}

// Surfaces that give way, however much, leave the friction as it is: also where a step's way, 2 µm,
// is a fraction of what they give, 50 µm. A wall goes with the wire until friction is complete.
TEST(Wire, FrictionIsCoulombsOnSoftSurfacesAndWalls) {
    const double h = 2e-4, load = 500, speed = 10, friction = 0.4;
    for (const double wall : {0.0, 2e-5, 1e-4}) {
        Wire wire(straight(20), 30);
        const double surface = 1e-4 - wall;
        double inserted = 30, push = 0, drag = 0;
        for (int n = 1; n <= 3000; ++n) {
            inserted += h * speed;
            wire.feed(inserted, 0);
            wire.predict(h);
            WireContact c[2] = {load_on(19, 1, {-load, 0, 0}, {0, 0, 0}),
                                floor_under_tip(1e-4, friction, wire, h)};
            c[1].wall_compliance = wall;
            for (int i = 0; i < 4; ++i) {
                if (i > 0) {
                    c[1].pushed = c[1].force.x;
                    c[1].dragged = {0, c[1].force.y, c[1].force.z};
                    c[1].yielded = -wall * c[1].force - Vec3d{surface * c[1].pushed, 0, 0};
                }
                wire.solve(c);
            }
            wire.finish();
            if (n <= 2000) continue;
            push += c[1].force.x / 1000;
            drag -= c[1].force.z / 1000;
        }
        std::printf("wall %g mm/uN: push %.2f, drag %.2f uN\n", wall, push, drag);
        EXPECT_NEAR(push, load, 0.04 * load);
        const double most = wall > 0 ? h * speed / wall : load;  // the wall has gone as far
        EXPECT_NEAR(drag, std::min(friction * push, most), 0.05 * drag);
    }
}

/// Until it rests. @pre damped
void settle(Wire& wire, int steps) {
    for (int n = 0; n < steps; ++n) {
        wire.predict(1e-3);
        for (int i = 0; i < 3; ++i) wire.solve({});
        wire.finish();
    }
}

TEST(Wire, ALoadedTipBendsTurnsAndTwistsItAsABeam) {
    WireSettings s = straight(40);
    s.bend[0] *= 2;  // clamped at the first node
    s.twist[0] *= 2;
    const double length = 80, bend = 5e6, twist = 4e6, rest = 2;  // of the last half segment [mm]
    {
        Wire wire(s, length);
        const double force = 20;
        wire.rig_tip(catheter::WireRig{.force = {force, 0, 0}});
        settle(wire, 3000);
        const double by = force * length * length * length / (3 * bend);
        EXPECT_NEAR(wire.positions().back().x, by, 0.02 * by);
        EXPECT_NEAR(wire.base_force().x, force, 1e-3 * force);
    }
    {
        Wire wire(s, length);
        const double moment = 5000;
        wire.rig_tip(catheter::WireRig{.moment = {0, moment, 0}});
        settle(wire, 3000);
        const double angle = moment * (length - rest / 2) / bend;
        EXPECT_NEAR(rotation_vector(wire.tip_frame()).y, angle, 1e-3 * angle);
        EXPECT_NEAR(norm(wire.base_moment()), moment, 1e-3 * moment);
    }
    {
        Wire wire(s, length);
        const double moment = 20'000;
        wire.rig_tip(catheter::WireRig{.moment = {0, 0, moment}});
        settle(wire, 3000);
        const double angle = moment * (length - rest / 2) / twist;
        EXPECT_NEAR(rotation_vector(wire.tip_frame()).z, angle, 1e-3 * angle);
    }
}

TEST(Wire, AHeldTipStaysAndSlidesOnlyWhereItMay) {
    const Rotation frame = rotation_by({0, 0.3, 0.2});
    for (const bool slides : {false, true}) {
        Wire wire(straight(40), 80);
        const Vec3d place{6, 1, 78}, along = rotated(frame, {0, 0, 1});
        wire.rig_tip(
            catheter::WireRig{.force = -50.0 * along, .hold = TipHold{place, frame, slides}});
        settle(wire, 3000);
        const Vec3d off = wire.positions().back() - place;
        EXPECT_LT(norm(off - dot(off, along) * along), 1e-4);
        EXPECT_EQ(std::abs(dot(off, along)) > 0.01, slides) << dot(off, along);
        const Rotation q = wire.tip_frame();
        EXPECT_LT(norm(rotation_vector(Rotation{frame.w, -frame.x, -frame.y, -frame.z} * q)), 1e-6);
        // Let go, it springs back.
        wire.rig_tip({});
        settle(wire, 3000);
        EXPECT_LT(norm(wire.positions().back() - Vec3d{0, 0, 80}), 1e-3);
    }
}

// A quarter turn around a cylinder, with a known force on the tip: the base's force is e^(µ π/2)
// times that during withdrawal, and 1/e^(µ π/2) times during feeding (Euler-Eytelwein).
TEST(Wire, FrictionRoundACylinderIsTheCapstans) {
    const double h = 2e-4, radius = 10, load = 4000;
    const Vec3d centre{radius, 0, 10};
    WireSettings s = straight(60);
    s.segment_mm = 1;
    s.bend.assign(60, 200);
    s.twist.assign(60, 200);
    s.damping = 20;
    const double friction = 0.3;
    {
        Wire wire(s, 40);
        double inserted = 40, drawn[2] = {0, 0};
        for (int n = 1; n <= 3500; ++n) {
            const double speed = n <= 1500 ? 0 : n <= 2500 ? -3 : 3;
            inserted += h * speed;
            wire.feed(inserted, 0);
            wire.predict(h);
            std::vector<WireContact> contacts;
            const double ramp = std::min(1.0, n / 1000.0);
            contacts.push_back(load_on(59, 1, {ramp * load, 0, 0}, wire.positions().back()));
            for (std::int32_t i = wire.first(); i < wire.segments(); ++i) {
                Vec3d out = wire.positions()[std::size_t(i) + 1] - centre;
                out.y = 0;
                WireContact c;
                c.segment = i;
                c.along = 1;
                c.normal = normalized(out);
                c.least = dot(c.normal, centre) + radius;
                c.compliance = 1e-7;
                begin_friction(c, friction, wire, h);
                contacts.push_back(c);
            }
            for (int i = 0; i < 4; ++i) wire.solve(contacts);
            wire.finish();
            ASSERT_TRUE(wire.is_good());
            if (n > 2000 && n <= 2500) drawn[0] += wire.base_force().z / 500;
            if (n > 3000) drawn[1] += wire.base_force().z / 500;
        }
        const double grows = std::exp(friction * std::numbers::pi / 2);
        std::printf("friction %g: withdrawn %.4f expected %.4f, fed %.4f expected %.4f\n", friction,
                    drawn[0] / load, grows, drawn[1] / load, 1 / grows);
        EXPECT_NEAR(drawn[0] / load, grows, 0.01 * grows);
        EXPECT_NEAR(drawn[1] / load, 1 / grows, 0.01 / grows);
    }
}

// Fed in and drawn back, it lies in the guide as if nothing had happened.
TEST(Wire, NothingJumpsWhereSegmentsLeaveTheGuide) {
    Wire wire(straight(50), 10);
    wire.bend_tip(0.5, 0);
    double inserted = 10, jump = 0, force = 0;
    for (int n = 0; n < 1600; ++n) {
        // Turned round smoothly: the mass of the wire would be felt.
        inserted += 0.05 * std::clamp((800 - n) / 100.0, -1.0, 1.0);
        wire.feed(inserted, 0);
        wire.predict(1e-3);
        for (int i = 0; i < 2; ++i) wire.solve({});
        wire.finish();
        ASSERT_TRUE(wire.is_good());
        if (n < 300) continue;  // the tip has been bent at once
        for (int i = wire.first(); i <= 50; ++i)
            jump = std::max(jump, norm(wire.positions()[std::size_t(i)] -
                                       wire.positions_before()[std::size_t(i)]));
        force = std::max(force, norm(wire.base_force()));
    }
    std::printf("largest movement %.4f mm, force %.1f uN\n", jump, force);
    EXPECT_LT(jump, 0.15);  // 0.05 are fed
    EXPECT_LT(force, 500);
    EXPECT_NEAR(wire.first(), 45, 1);
}

}  // namespace
}  // namespace pliant::test
