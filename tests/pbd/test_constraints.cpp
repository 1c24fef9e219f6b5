// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each constraint alone, at random positions: its gradient against finite differences, invariants
// of a projection, and degenerate input.
// Covers: pbd/project_*.cpp, pbd/rest.cpp, pbd/solver.cpp.

#include <pliant/models/pbd.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "pbd/arithmetic.h"
#include "pbd/solver.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using pbd::Corner;
using Corners = Corner<double>[4];

void set_corners(const Vec3d (&positions)[4], Corners& p) {
    for (int n = 0; n < 4; ++n) p[n] = {{positions[n].x, positions[n].y, positions[n].z}, 1};
}
Vec3d as_vec(const pbd::Triple<double>& t) {
    return {t.x, t.y, t.z};
}

/// Four positions that are a tetrahedron of some volume.
void random_tetrahedron(Random& random, Vec3d (&positions)[4]) {
    double volume = 0;
    while (volume < 0.02) {
        for (Vec3d& p : positions) p = random.vector(1);
        volume = dot(cross(positions[1] - positions[0], positions[2] - positions[0]),
                     positions[3] - positions[0]);
    }
}

/// Central differences of order four, good to about 1e-11.
Vec3d derivative(const std::function<double(const Vec3d (&)[4])>& f, const Vec3d (&at)[4],
                 int node) {
    constexpr double kStep = 1e-3;
    Vec3d result{0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = [&](double steps) {
            Vec3d moved[4] = {at[0], at[1], at[2], at[3]};
            moved[node][axis] += steps * kStep;
            return f(moved);
        };
        result[axis] = (8 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12 * kStep);
    }
    return result;
}

// Test case 1 of the references: 1e-12 and 1e-6.
TEST(Constraints, VolumeGradientsSumToZeroAndAgreeWithFiniteDifferences) {
    const auto volume = [](const Vec3d(&x)[4]) {
        return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6;
    };
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Vec3d positions[4];
        random_tetrahedron(random, positions);
        Corners p;
        set_corners(positions, p);
        const auto c = pbd::volume_constraint(p, 0.25);
        EXPECT_NEAR(c.value, volume(positions) - 0.25, 1e-15);
        Vec3d sum{0, 0, 0};
        for (int n = 0; n < 4; ++n) {
            const Vec3d g = as_vec(c.g[n]);
            sum = sum + g;
            EXPECT_LT(norm(g - derivative(volume, positions, n)), 1e-6 * norm(g));
        }
        EXPECT_LT(norm(sum), 1e-12);
        // As the paper writes the first one [VesselPbd2016, Eq. 7].
        const Vec3d paper =
            (1.0 / 6) * cross(positions[3] - positions[1], positions[2] - positions[1]);
        EXPECT_LT(norm(as_vec(c.g[0]) - paper), 1e-14);
    }
}

TEST(Constraints, BendGradientsAgreeWithFiniteDifferencesOfAnAngleFoundInAnotherWay) {
    // The signed angle between the triangles' planes, from vectors across the common edge.
    const auto angle = [](const Vec3d(&x)[4]) {
        const Vec3d e = normalized(x[1] - x[0]);
        const Vec3d a = normalized((x[2] - x[0]) - dot(x[2] - x[0], e) * e);
        const Vec3d b = normalized(-1.0 * ((x[3] - x[0]) - dot(x[3] - x[0], e) * e));
        const double size = 2 * std::asin(std::min(1.0, 0.5 * norm(a - b)));
        return dot(cross(a, b), e) > 0 ? size : -size;
    };
    int signs[2] = {0, 0};
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Vec3d positions[4];
        random_tetrahedron(random, positions);
        if (seed % 2) std::swap(positions[2], positions[3]);
        const double expected = angle(positions);
        if (std::abs(std::abs(expected) - std::numbers::pi) < 0.05 || std::abs(expected) < 0.01)
            continue;  // where this angle can't be differentiated by steps; the constraint's can
        ++signs[expected > 0];
        Corners p;
        set_corners(positions, p);
        const auto c = pbd::bend_constraint(p, 0.0);
        EXPECT_NEAR(c.value, expected, 1e-9);
        for (int n = 0; n < 4; ++n) {
            const Vec3d g = as_vec(c.g[n]);
            EXPECT_LT(norm(g - derivative(angle, positions, n)), 1e-4 * (1 + norm(g))) << n;
        }
    }
    EXPECT_GT(signs[0], 50);
    EXPECT_GT(signs[1], 50);
}

TEST(Constraints, BendAnglesAreTakenTheShortWayRound) {
    const Vec3d positions[4] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0.99, 0.05}};
    Corners p;
    set_corners(positions, p);
    const double angle = pbd::bend_constraint(p, 0.0).value;
    EXPECT_GT(std::abs(angle), 3);
    const double other_side = angle > 0 ? -3.1 : 3.1;
    EXPECT_LT(std::abs(pbd::bend_constraint(p, other_side).value), 0.2);
}

TEST(Constraints, ArcTangentsOfFloatsAreGoodToTheLastBits) {
    double largest = 0;
    Random random(1);
    for (int n = 0; n < 100000; ++n) {
        const float x = float(random.real(-1, 1)), y = float(random.real(-1, 1));
        largest =
            std::max(largest, std::abs(double(pbd::arc_tangent(y, x)) - std::atan2(double(y), x)));
    }
    EXPECT_LT(largest, 4e-7);
    EXPECT_EQ(pbd::arc_tangent(0.0F, 0.0F), 0.0F);
    EXPECT_NEAR(pbd::arc_tangent(0.0F, -1.0F), std::numbers::pi, 1e-6);
    EXPECT_NEAR(pbd::arc_tangent(-1.0F, 0.0F), -std::numbers::pi / 2, 1e-6);
}

TEST(Constraints, TheSolidsEnergyIsNeoHookesAndItsGradientsAreItsForces) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Vec3d rest[4], positions[4];
        random_tetrahedron(random, rest);
        random_tetrahedron(random, positions);
        PbdParts parts{.positions = {rest[0], rest[1], rest[2], rest[3]}};
        const PbdSolid solid{{0, 1, 2, 3}, random.real(1, 10), random.real(0.1, 0.49)};
        const auto numbers = pbd::solid_numbers(parts, solid);
        pbd::Solid<double> s{};
        for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = numbers.inverse[n];
        // ½ µ (tr FᵀF − 3) + ½ λ (det F − 1 − µ/λ)², λ = Lamé's + µ
        const double nu = solid.poisson_ratio, e = solid.young_modulus;
        const double mu = e / (2 * (1 + nu)), lambda = e * nu / ((1 + nu) * (1 - 2 * nu)) + mu;
        const double volume =
            dot(cross(rest[1] - rest[0], rest[2] - rest[0]), rest[3] - rest[0]) / 6;
        const Mat3d inverse_rest =
            inverse(Mat3d{{rest[1] - rest[0], rest[2] - rest[0], rest[3] - rest[0]}});
        const auto energy = [&](const Vec3d(&x)[4]) {
            const Mat3d f = Mat3d{{x[1] - x[0], x[2] - x[0], x[3] - x[0]}} * inverse_rest;
            double trace = 0;
            for (const Vec3d& column : f.columns) trace += dot(column, column);
            const double j = determinant(f) - 1 - mu / lambda;
            return volume * (0.5 * mu * (trace - 3) + 0.5 * lambda * j * j);
        };
        Corners p;
        set_corners(positions, p);
        const auto c = pbd::solid_constraints(p, s);
        for (int n = 0; n < 4; ++n) {
            const Vec3d force = (c.h / numbers.h_compliance) * as_vec(c.gh[n]) +
                                (c.e / numbers.e_compliance) * as_vec(c.ge[n]);
            const Vec3d expected = derivative(energy, positions, n);
            EXPECT_LT(norm(force - expected), 1e-6 * (norm(expected) + e)) << n;
        }
    }
}

TEST(Constraints, AtRestAWarmProjectionKeepsTheLawsForces) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Vec3d rest[4], positions[4];
        random_tetrahedron(random, rest);
        random_tetrahedron(random, positions);
        const PbdParts parts{.positions = {rest[0], rest[1], rest[2], rest[3]}};
        const auto numbers =
            pbd::solid_numbers(parts, {{0, 1, 2, 3}, random.real(1, 10), random.real(0.1, 0.49)});
        pbd::Solid<double> s{};
        for (int n = 0; n < 9; ++n) s.inverse[n / 3][n % 3] = numbers.inverse[n];
        const pbd::WarmSolid<double> warm = pbd::warm_solid(numbers);
        Corners p;
        set_corners(positions, p);
        for (pbd::Corner<double>& corner : p) corner.w = random.real(0.5, 2);
        pbd::Balanced<double> forces;
        EXPECT_GT(pbd::recall_solid(p, warm, forces), 0);
        const auto c = pbd::solid_constraints(p, s);
        double largest = 0;
        for (int n = 1; n < 4; ++n) {
            const Vec3d law = (-c.h / numbers.h_compliance) * as_vec(c.gh[n]) -
                              (c.e / numbers.e_compliance) * as_vec(c.ge[n]);
            largest = std::max(largest, norm(law));
            EXPECT_LT(norm(as_vec(forces[n]) - law), 1e-9 * (1 + norm(law))) << n;
        }
        pbd::Balanced<double> kept;
        std::copy(forces, forces + 4, kept);
        pbd::project_warm(p, warm, kept);
        for (int n = 0; n < 4; ++n) {
            EXPECT_LT(norm(as_vec(kept[n]) - as_vec(forces[n])), 1e-9 * (1 + largest)) << n;
            EXPECT_LT(norm(as_vec(p[n].p) - positions[n]), 1e-9 * (1 + largest)) << n;
        }
        // From none, it finds a part of them, and momentum is kept.
        for (auto& f : kept) f = {0, 0, 0};
        pbd::project_warm(p, warm, kept);
        Vec3d momentum{0, 0, 0};
        for (int n = 0; n < 4; ++n)
            momentum = momentum + (1 / p[n].w) * (as_vec(p[n].p) - positions[n]);
        EXPECT_LT(norm(momentum), 1e-9 * (1 + largest));
    }
}

/// A body of one constraint between four free particles, far from its rest shape.
PbdParts one_constraint(Random& random, PbdKind kind, double compliance) {
    PbdParts parts;
    Vec3d positions[4];
    random_tetrahedron(random, positions);
    for (const Vec3d& p : positions) {
        parts.positions.push_back(p);
        parts.inverse_masses.push_back(1 / random.real(0.5, 2));
    }
    if (kind == PbdKind::Distance)
        parts.distances = {{{0, 1}, random.real(0.1, 2), compliance}};
    else if (kind == PbdKind::Bend)
        parts.bends = {{{0, 1, 2, 3}, random.real(-1, 1), compliance}};
    else if (kind == PbdKind::Volume)
        parts.volumes = {{{0, 1, 2, 3}, random.real(0.001, 0.5), compliance}};
    else
        parts.solids = {{{0, 1, 2, 3}, 10, random.real(0.1, 0.49)}};
    return parts;
}

class EachKind : public ::testing::TestWithParam<PbdKind> {};

// Test case 2 of the references: 1e-12.
TEST_P(EachKind, AProjectionKeepsMomentumAndAngularMomentum) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const PbdParts parts = one_constraint(random, GetParam(), seed % 2 ? 0 : 1e-2);
        auto body = PbdBody::create(
            parts, {.time_step = 0.1, .sub_steps = 1, .precision = PbdPrecision::Double});
        ASSERT_TRUE(body.ok()) << body.error().message;
        std::vector<Vec3d> x = parts.positions;
        if (GetParam() == PbdKind::Solid)  // at rest it would stay
            for (std::size_t n = 0; n < 4; ++n) {
                x[n] = x[n] + random.vector(0.2);
                ASSERT_TRUE(body->set_state(std::int32_t(n), x[n], {0, 0, 0}).ok());
            }
        ASSERT_TRUE(body->step(1, arena).ok());
        Vec3d momentum{0, 0, 0}, angular{0, 0, 0};
        double size = 0;
        for (std::size_t n = 0; n < 4; ++n) {
            const double mass = 1 / parts.inverse_masses[n];
            const Vec3d moved = body->position(std::int32_t(n)) - x[n];
            momentum = momentum + mass * moved;
            angular = angular + cross(x[n], mass * moved);
            size = std::max(size, mass * norm(moved));
        }
        EXPECT_GT(size, 1e-6);
        EXPECT_LT(norm(momentum), 1e-12 * size);
        EXPECT_LT(norm(angular), 4e-12 * size);
    }
}

TEST_P(EachKind, CollapsedAndHeldConstraintsMoveNothingAndStayNumbers) {
    const TaskArena arena(1);
    for (const PbdPrecision numbers : {PbdPrecision::Float, PbdPrecision::Double})
        for (const bool held : {false, true}) {
            Random random(7);
            PbdParts parts = one_constraint(random, GetParam(), 0);
            if (held) parts.inverse_masses.assign(4, 0);
            auto body = PbdBody::create(parts, {.precision = numbers});
            ASSERT_TRUE(body.ok());
            const Vec3d middle{0.25, -0.5, 1};
            for (std::int32_t n = 0; n < 4 && !held; ++n) {
                ASSERT_TRUE(body->set_state(n, middle, {0, 0, 0}).ok());
            }
            ASSERT_TRUE(body->step(2, arena).ok());
            for (std::int32_t n = 0; n < 4; ++n) {
                const Vec3d expected = held ? parts.positions[std::size_t(n)] : middle;
                EXPECT_LT(norm(body->position(n) - expected), 1e-6) << n;
            }
        }
}

INSTANTIATE_TEST_SUITE_P(All, EachKind,
                         ::testing::Values(PbdKind::Distance, PbdKind::Bend, PbdKind::Volume,
                                           PbdKind::Solid));

TEST(Constraints, AStiffnessTakesItsShareAway) {
    const TaskArena arena(1);
    for (const double k : {0.0, 0.25, 1.0}) {
        PbdParts parts{.positions = {{0, 0, 0}, {3, 0, 0}}, .inverse_masses = {1, 0.5}};
        parts.distances = {{.nodes = {0, 1}, .rest_length = 1, .stiffness = k}};
        auto body = PbdBody::create(parts, {.sub_steps = 1, .method = PbdMethod::Stiffness});
        ASSERT_TRUE(body.ok());
        ASSERT_TRUE(body->step(1, arena).ok());
        EXPECT_NEAR(norm(body->position(1) - body->position(0)), 3 - 2 * k, 1e-6);
        EXPECT_NEAR(body->position(0).x, 2 * k * 2 / 3, 1e-6);  // twice as light
    }
}

// It sags by g m α, with both methods.
TEST(Constraints, AnAttachmentIsASpringBesideStiffnessesToo) {
    const TaskArena arena(1);
    for (const PbdMethod method : {PbdMethod::Compliance, PbdMethod::Stiffness}) {
        PbdParts parts{.positions = {{0, 0, 0}}, .inverse_masses = {0.5}};
        parts.attachments = {{.nodes = {0, 0, 0, 0}, .compliance = 0.01}};
        auto body = made(PbdBody::create(parts, {.gravity = {0, 0, -10},
                                                 .damping = 20,
                                                 .method = method,
                                                 .precision = PbdPrecision::Double}));
        ASSERT_TRUE(body.step(600, arena).ok());
        EXPECT_NEAR(body.position(0).z, -10 * 2 * 0.01, 1e-6);
    }
}

TEST(Constraints, AnAttachmentPullsItsPointToTheTargetAndTellsTheForce) {
    const TaskArena arena(1);
    for (const double compliance : {0.0, 0.01}) {
        PbdParts parts{.positions = {{100, 0, 0}, {101, 0, 0}, {100, 1, 0}, {100, 0, 1}},
                       .inverse_masses = {1, 1, 1, 1}};
        const Vec3d target{100.5, 0.5, 0.75};
        parts.attachments = {{{0, 1, 2, 3}, {0.1, 0.2, 0.3, 0.4}, target, compliance}};
        const Vec3d g{0, 0, -10};
        auto body = PbdBody::create(
            parts, {.gravity = g, .damping = 30, .precision = PbdPrecision::Double});
        ASSERT_TRUE(body.ok());
        ASSERT_TRUE(body->step(1, arena).ok());
        const auto point = [&] {
            return 0.1 * body->position(0) + 0.2 * body->position(1) + 0.3 * body->position(2) +
                   0.4 * body->position(3);
        };
        if (compliance == 0) {
            EXPECT_LT(norm(point() - target), 1e-12);
        }
        // One particle at rest hangs from the target by its weight.
        parts.attachments[0].weights = {1, 0, 0, 0};
        parts.attachments[0].target = parts.positions[0];
        auto hanging = PbdBody::create(
            parts, {.gravity = g, .damping = 30, .precision = PbdPrecision::Double});
        ASSERT_TRUE(hanging->step(600, arena).ok());
        EXPECT_LT(norm(hanging->attachment_force(0) - Vec3d{0, 0, 10}), 1e-6);
        EXPECT_NEAR(hanging->position(0).z, -10 * compliance, 1e-6);
        ASSERT_TRUE(hanging->move_attachment(0, {100, 0, 2}).ok());
        ASSERT_TRUE(hanging->step(600, arena).ok());
        EXPECT_NEAR(hanging->position(0).z, 2 - 10 * compliance, 1e-6);
    }
}

TEST(Constraints, ASlopeHoldsABodyUpToItsFriction) {
    const TaskArena arena(1);
    for (const double angle : {0.2, 0.4}) {
        const double friction = std::tan(0.3), g = 10;
        PbdParts parts{.positions = {{0, 0, 0}}, .inverse_masses = {1}};
        parts.planes = {{{0, 0, 0}, {std::sin(angle), 0, std::cos(angle)}, friction}};
        auto body = PbdBody::create(
            parts, {.time_step = 0.01, .gravity = {0, 0, -g}, .precision = PbdPrecision::Double});
        ASSERT_TRUE(body.ok());
        ASSERT_TRUE(body->step(100, arena).ok());
        const double way = norm(body->position(0));
        const double expected =
            angle < 0.3 ? 0 : 0.5 * g * (std::sin(angle) - friction * std::cos(angle));
        EXPECT_NEAR(way, expected, 0.01 * expected + 1e-9);
    }
}

}  // namespace
}  // namespace pliant::test
