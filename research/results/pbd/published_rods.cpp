// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases 6 to 9: the elastica, joints, an arc, and the twist at which a ring leaves its plane
// [Michell1889].

#include <pliant/models/pbd.h>
#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "published.h"
#include "value_of.h"

namespace pliant::results {
namespace {

using std::numbers::pi;

/// A ring of length 1 in the plane z = 0, EI = GJ = 1, cut at (R, 0, 0) and closed again after its
/// end was rotated by `twist`. It is held there, which fixes only rigid motions.
class TwistedRing {
  public:
    TwistedRing(int segments, double twist)
        : m_segments(segments), m_radius(0.5 / (segments * std::sin(pi / segments))) {
        // All velocity is removed in each step, so that perturbations grow by a constant factor.
        auto rod = value_of(Rod::create({.segments = segments,
                                         .stretch_stiffness = 1e6,
                                         .shear_stiffness = 1e6,
                                         .base = {m_radius, 0, 0},
                                         .frame = frame(0, 0),
                                         .time_step = kStep,
                                         .iterations = 4,
                                         .damping = 1 / kStep}));
        m_rod = std::make_unique<Rod>(std::move(rod));
        for (int n = 1; n <= segments; ++n) {
            const double angle = 2 * pi * n / segments;
            const Vec3d to{m_radius * std::cos(angle), m_radius * std::sin(angle),
                           n < segments ? 1e-5 * std::sin(2 * angle + 1) : 0};
            m_rod->displace(n, to - m_rod->position(n));
        }
        for (int i = 0; i < segments; ++i) {
            const double share = (i + 0.5) / segments;
            const Rotation is = m_rod->orientation(i), back{is.w, -is.x, -is.y, -is.z};
            m_rod->displace_segment(i,
                                    rotation_vector(frame(2 * pi * share, twist * share) * back));
        }
        must(m_rod->hold_tip({m_radius, 0, 0}, frame(2 * pi, twist)));
    }

    /// Growth rate of the distance from a plane; negative: it shrinks.
    double growth() {
        must(m_rod->step(300));
        const double before = out_of_plane();
        must(m_rod->step(100));
        return std::log(out_of_plane() / before) / 100;
    }
    const Rod& rod() const { return *m_rod; }

  private:
    static constexpr double kStep = 0.01;

    /// Frame of a section at an angle around the ring: its third axis is the tangent.
    static Rotation frame(double angle, double twist) {
        return rotation_by({0, 0, angle}) * rotation_by({-pi / 2, 0, 0}) *
               rotation_by({0, 0, twist});
    }
    /// Root mean square distance from the best plane z = a + bx + cy, because the ring may tilt
    /// about its tangent at the held point without energy.
    double out_of_plane() const {
        double m[3][4] = {};
        for (int n = 0; n < m_segments; ++n) {
            const Vec3d p = m_rod->position(n);
            const double row[4] = {1, p.x, p.y, p.z};
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 4; ++c) m[r][c] += row[r] * row[c];
        }
        for (int k = 0; k < 3; ++k)
            for (int r = 0; r < 3; ++r) {
                if (r == k) continue;
                const double f = m[r][k] / m[k][k];
                for (int c = k; c < 4; ++c) m[r][c] -= f * m[k][c];
            }
        double sum = 0;
        for (int n = 0; n < m_segments; ++n) {
            const Vec3d p = m_rod->position(n);
            const double off =
                p.z - m[0][3] / m[0][0] - m[1][3] / m[1][1] * p.x - m[2][3] / m[2][2] * p.y;
            sum += off * off;
        }
        return std::sqrt(sum / m_segments);
    }

    int m_segments;
    double m_radius;
    std::unique_ptr<Rod> m_rod;
};

}  // namespace

Cases elastica_cases() {
    const struct {
        double load, across, along;
    } runs[] = {{1, 0.30172, 0.05643},
                {2, 0.49346, 0.16064},
                {5, 0.71379, 0.38763},
                {10, 0.81061, 0.55500}};
    Cases cases;
    for (const auto& c : runs) {
        const Rotation frame = rotation_by(Numbers(1).vector(2));
        Rod rod = value_of(Rod::create(
            {.stretch_stiffness = 1e6, .shear_stiffness = 1e6, .frame = frame, .damping = 4}));
        const Vec3d across = rotated(frame, {std::cos(0.7), std::sin(0.7), 0});
        must(rod.load(50, c.load * across));
        must(rod.step(1000));
        const Vec3d tip = rod.position(50);
        const std::string what =
            "elastica, 50 segments, PL²/EI " + std::to_string(int(c.load)) + ": tip ";
        cases.push_back(
            within_share(6, what + "across, over L", c.across, dot(tip, across), 0.005));
        cases.push_back(within_share(6, what + "along, over L", c.along,
                                     1 - dot(tip, rotated(frame, {0, 0, 1})), 0.005));
        const double reaction = norm(rod.base_force() - c.load * across) / c.load;
        cases.push_back(
            at_most(6, what + "load against the base's force, relative", reaction, 1e-6));
    }
    return cases;
}

// Joints of k = EI/h, the base's joint twice that: the sum over joints, and the beam.
Cases joint_cases() {
    Cases cases;
    for (const int n : {7, 14, 28, 56}) {
        const double force = 1e-4, h = 1.0 / n;
        Rod rod = value_of(Rod::create(
            {.segments = n, .stretch_stiffness = 1e8, .shear_stiffness = 1e8, .damping = 4}));
        must(rod.load(n, {force, 0, 0}));
        must(rod.step(800));
        double sum = 0.5 * n * n;
        for (int j = 1; j < n; ++j) sum += double(j) * j;
        const double joints = force * h * h * h * sum, beam = force / 3, tip = rod.position(n).x;
        const std::string what = "cantilever of " + std::to_string(n) + " joints: deflection over ";
        cases.push_back(
            within_share(7, what + "that of the sum over joints", 1, tip / joints, 1e-4));
        if (n == 56) cases.push_back(within_share(7, what + "the beam's", 1, tip / beam, 0.03));
    }
    return cases;
}

// A moment at the tip, 14 segments of 0.1, joints of k_b 400 and k_t 1000: 60° in all.
Cases arc_cases() {
    const double per_joint = 60.0 / 13 * pi / 180, length = 1.4;
    Rod rod = value_of(Rod::create({.segments = 14,
                                    .length = length,
                                    .bend_stiffness = 40,
                                    .twist_stiffness = 100,
                                    .stretch_stiffness = 1e7,
                                    .shear_stiffness = 1e7,
                                    .damping = 20}));
    must(rod.load_moment(13, {0, 400 * per_joint, 0}));
    must(rod.step(1000));
    double bends = 0, positions = 0, aside = 0;
    double angle = per_joint / 2;  // the base's joint is half as long
    Vec3d place{0, 0, 0};
    for (int i = 0; i < 14; ++i) {
        const Vec3d expected{0, i == 0 ? per_joint / 2 : per_joint, 0};
        bends += std::pow(norm(rod.turn(i) - expected), 2);
        place = place + 0.1 * Vec3d{std::sin(angle), 0, std::cos(angle)};
        positions += std::pow(norm(rod.position(i + 1) - place), 2);
        angle += per_joint;
        aside = std::max(aside, std::abs(rod.position(i + 1).y));
    }
    return {
        at_most(8, "arc of 60°, 14 segments: bends, root mean square [°]",
                std::sqrt(bends / 14) * 180 / pi, 0.12),
        at_most(8, "the same: centre-line over length", std::sqrt(positions / 14) / length, 1e-3),
        at_most(8, "the same: out of its plane, over length", aside / length, 1e-4)};
}

Cases ring_cases() {
    const double expected = 2 * pi * std::sqrt(3.0);
    TwistedRing below(60, 0.985 * expected), above(60, 1.015 * expected);
    const double shrinks = below.growth(), grows = above.growth();
    // Bent to a circle and uniformly twisted: ½(2π)² + ½φ², up to the polygon's sides.
    const double energy = 2 * pi * pi + 0.5 * std::pow(0.985 * expected, 2);
    // Between a twist with a stable plane and one with an unstable plane.
    const bool between = shrinks < 0 && grows > 0;
    return {within_share(
                9, "ring, EI = GJ, 60 segments: twist at which it leaves its plane [rad]", expected,
                between ? expected * (0.985 + 0.03 * shrinks / (shrinks - grows)) : 0, 0.03),
            within_share(9, "the same below it: energy over EI/L", energy,
                         below.rod().elastic_energy(), 2e-3)};
}

}  // namespace pliant::results
