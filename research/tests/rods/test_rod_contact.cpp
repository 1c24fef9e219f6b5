// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of a rod with a vessel: momentum, Coulomb's law, and that nothing gets through.

#include <gtest/gtest.h>
#include <pliant/models/vessel.h>
#include <pliant/research/rod.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "support/count_allocations.h"
#include "support/inside.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using std::numbers::pi;

constexpr double kStep = 2e-4;

VesselWall bent_tube() {
    const auto way = bent_way({.inner_mm = 3,
                               .from_mm = -4,
                               .to_mm = 62,
                               .radius_mm = 30,
                               .angle_rad = pi / 2,
                               .last_mm = 30});
    return made(swept_tube(way, {.thickness_mm = 1, .layers = 2, .sectors = 16}));
}

PbdBody body_of(const VesselWall& wall, double young_modulus, double step = kStep) {
    PbdParts parts;
    if (young_modulus > 0) {
        parts = made(pbd_of_mesh(wall.mesh, {.density = 1e-3,
                                             .edges = false,
                                             .volumes = false,
                                             .solids = true,
                                             .young_modulus = young_modulus,
                                             .poisson_ratio = 0.45}));
        // Held by surrounding tissue.
        for (std::size_t n = 0; n < parts.positions.size(); n += 16)
            parts.attachments.push_back({.nodes = {std::int32_t(n), 0, 0, 0},
                                         .target = parts.positions[n],
                                         .compliance = 1e-3});
    } else {
        parts.positions = wall.mesh.nodes_mm;
        parts.inverse_masses.assign(parts.positions.size(), 0);
    }
    return made(
        PbdBody::create(std::move(parts), {.time_step = step, .sub_steps = 1, .damping = 20}));
}

RodSettings wire(double step = kStep) {
    return {.segments = 30,
            .length = 60,
            .mass = 0.06,
            .bend_stiffness = 1e6,
            .twist_stiffness = 1e6,
            .stretch_stiffness = 1e7,
            .shear_stiffness = 1e7,
            .time_step = step,
            .damping = 20};
}

/// How far the rod's surface is beyond the ghost, at most: all triangles for many points of it.
double deepest(const Rod& rod, const VesselWall& wall, const PbdBody& body, double radius) {
    TetMesh now = wall.mesh;
    body.get_positions(now.nodes_mm);
    std::vector<Vec3d> positions;
    for (const Embedded& e : wall.ghost_positions) positions.push_back(position_of(e, now));
    double most = -1e9;
    for (int s = 0; s < rod.settings().segments; ++s)
        for (int k = 0; k <= 8; ++k) {
            const Vec3d x = (1 - k / 8.0) * rod.position(s) + (k / 8.0) * rod.position(s + 1);
            most = std::max(most, radius - inside_by(x, positions, wall.ghost));
        }
    return most;
}

double curvature_of(const Rod& rod) {
    double sum = 0;
    for (int s = 0; s < rod.settings().segments; ++s) sum += norm(rod.turn(s));
    return sum;
}

struct Pushed {
    double depth = -1e9, reported = 0, bent = 0, wall_moved = 0, way = 0;
    std::uint64_t hash = 0;
};
/// 50 mm at a speed, into the bend.
Pushed push_in(const VesselWall& wall, double young_modulus, double speed, int threads,
               double way = 50, double step = kStep) {
    const TaskArena arena(threads);
    PbdBody body = body_of(wall, young_modulus, step);
    Rod rod = made(Rod::create(wire(step)));
    RodContact contact = made(RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
                                                 {.radius = 0.5, .friction = 0.1}));
    Pushed found;
    const int steps = int(std::lround(way / (speed * step)));
    for (int n = 1; n <= steps; ++n) {
        EXPECT_TRUE(rod.set_base({0, 0, way * n / steps}, Rotation{}).ok());
        const Status s = contact.step(1, rod, body, arena);
        EXPECT_TRUE(s.ok()) << s.error().message;
        if (!s.ok()) return found;
        found.reported = std::max(found.reported, contact.depth_left());
        if (n % (steps / 12) == 0)
            found.depth = std::max(found.depth, deepest(rod, wall, body, 0.5));
    }
    found.bent = curvature_of(rod);
    found.way = rod.position(30).x;
    for (std::int32_t p = 0; p < body.particle_count(); ++p)
        found.wall_moved =
            std::max(found.wall_moved, norm(body.position(p) - wall.mesh.nodes_mm[std::size_t(p)]));
    found.hash = body.hash();
    std::printf(
        "pushed at %g mm/s, E %g, step %g: depth %.4f mm (reported %.4f), bent by %.2f, "
        "wall moved %.3f mm, tip at x %.1f\n",
        speed, young_modulus, step, found.depth, found.reported, found.bent, found.wall_moved,
        found.way);
    return found;
}

TEST(RodContact, AWirePushedThroughABentStiffTubeStaysInside) {
    const VesselWall wall = bent_tube();
    for (const double speed : {100.0, 400.0}) {
        const Pushed found = push_in(wall, 0, speed, 1);
        EXPECT_LE(found.depth, 0.1);
        EXPECT_GT(found.depth, -0.01);  // it does touch
        EXPECT_GT(found.bent, 1.0);
        EXPECT_GT(found.way, 10);
        EXPECT_LT(found.wall_moved, 1e-5);  // positions are floats
    }
}

TEST(RodContact, ASoftTubeGivesWayAndHoldsTheWire) {
    const VesselWall wall = bent_tube();
    const Pushed found = push_in(wall, 3e5, 100, 2);
    EXPECT_LE(found.depth, 0.1);
    EXPECT_GT(found.bent, 0.8);
    EXPECT_GT(found.wall_moved, 0.02);
    EXPECT_LT(found.wall_moved, 10);
}

TEST(RodContact, IsTheSameForAnyNumberOfThreads) {
    const VesselWall wall = bent_tube();
    const std::uint64_t one = push_in(wall, 3e5, 500, 1, 16).hash;
    EXPECT_EQ(push_in(wall, 3e5, 500, 2, 16).hash, one);
    EXPECT_EQ(push_in(wall, 3e5, 500, 4, 16).hash, one);
    EXPECT_NE(push_in(wall, 3e5, 500, 1, 17).hash, one);
}

/// A flat sheet of triangles in the plane y = 0 on tetrahedra below it.
VesselWall floor_of(int cells) {
    VesselWall wall;
    wall.mesh = five_tet_block({cells, 1, cells}, 2);
    for (Vec3d& p : wall.mesh.nodes_mm) p = p - Vec3d{double(cells), 2, 4};
    std::vector<std::int32_t> owners, nodes;
    std::vector<std::array<std::int32_t, 3>> top;
    for (const auto& f : boundary_faces(wall.mesh, &owners)) {
        const auto on_top = [&](std::int32_t n) {
            return wall.mesh.nodes_mm[std::size_t(n)].y > -1e-9;
        };
        if (on_top(f[0]) && on_top(f[1]) && on_top(f[2])) top.push_back(f);
    }
    wall.ghost = part_of(wall.mesh.nodes_mm, top, &nodes);
    for (const std::int32_t n : nodes)
        for (std::size_t c = 0; c < wall.mesh.cells.size(); ++c) {
            const auto& cell = wall.mesh.cells[c];
            const auto at = std::find(cell.begin(), cell.end(), n);
            if (at == cell.end()) continue;
            Embedded e{std::int32_t(c), {0, 0, 0, 0}};
            e.weights[std::size_t(at - cell.begin())] = 1;
            wall.ghost_positions.push_back(e);
            break;
        }
    return wall;
}

// The same step with and without contact: the changes of momentum add up to zero.
TEST(RodContact, KeepsMomentumAndAngularMomentum) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const VesselWall wall = floor_of(16);
        auto parts = made(pbd_of_mesh(wall.mesh, {.density = 1e-3, .edge_compliance = 1e-6}));
        const PbdSettings settings{
            .time_step = 1e-3, .sub_steps = 1, .precision = PbdPrecision::Double};
        RodSettings wires = wire(1e-3);
        wires.segments = 8;
        wires.length = 16;
        wires.iterations = 1;
        wires.base = {random.real(-3, 3), 0.6, 1};
        wires.frame = rotation_by({random.real(0.02, 0.06), random.real(-0.2, 0.2), 0});
        Rod rods[2] = {made(Rod::create(wires)), made(Rod::create(wires))};
        PbdBody bodies[2] = {made(PbdBody::create(parts, settings)),
                             made(PbdBody::create(parts, settings))};
        for (Rod& rod : rods)
            for (int n = 1; n <= 8; ++n) {
                const double s = double(n) / 8;
                ASSERT_TRUE(rod.load(n, 400 * s * Vec3d{0.3, -1, -0.5}).ok());
            }
        RodContact contact = made(RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
                                                     {.friction = 0.3, .rounds = 1}));
        ASSERT_TRUE(contact.step(1, rods[0], bodies[0], arena).ok());
        ASSERT_TRUE(rods[1].step(1).ok());
        ASSERT_TRUE(bodies[1].step(1, arena).ok());
        Vec3d sum{0, 0, 0}, moments{0, 0, 0};
        double size = 0;
        const auto add = [&](Vec3d place, double mass, Vec3d change) {
            sum = sum + mass * change;
            moments = moments + cross(place, mass * change);
            size += mass * norm(change);
        };
        for (int n = 1; n <= 8; ++n)
            add(rods[1].position(n), 1 / rods[1].inverse_mass(n),
                rods[0].velocity(n) - rods[1].velocity(n));
        for (int s = 0; s < 8; ++s)
            moments =
                moments + (1 / rods[1].inverse_inertia()) * (rods[0].spin(s) - rods[1].spin(s));
        for (int p = 0; p < bodies[1].particle_count(); ++p)
            add(bodies[1].position(p), 1 / bodies[1].inverse_mass(p),
                bodies[0].velocity(p) - bodies[1].velocity(p));
        EXPECT_GT(contact.touches().size(), 0u);
        EXPECT_GT(size, 1e-3);
        EXPECT_LT(norm(sum), 1e-9 * size);
        EXPECT_LT(norm(moments), 1e-8 * size);
    }
}

// A wire is drawn over a floor: the force at its base is its weight times the coefficient.
TEST(RodContact, FrictionIsCoulombs) {
    const TaskArena arena(1);
    const VesselWall wall = floor_of(24);
    for (const double friction : {0.0, 0.2, 0.5}) {
        RodSettings wires = wire(1e-3);
        wires.segments = 10;
        wires.length = 20;
        wires.base = {0, 0.5, 5};
        wires.gravity = {0, -9810, 0};
        Rod rod = made(Rod::create(wires));
        PbdBody body = body_of(wall, 0, 1e-3);
        RodContact contact = made(RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions,
                                                     {.radius = 0.5, .friction = friction}));
        Vec3d mean{0, 0, 0}, base{0, 0, 0};
        const int steps = 800, counted = 400;
        for (int n = 1; n <= steps; ++n) {
            ASSERT_TRUE(rod.set_base({0, 0.5, 5 + 10 * n * 1e-3}, Rotation{}).ok());
            ASSERT_TRUE(contact.step(1, rod, body, arena).ok());
            if (n <= steps - counted) continue;
            for (const WallTouch& t : contact.touches()) mean = mean + (1.0 / counted) * t.force;
            base = base + (1.0 / counted) * rod.base_force();
        }
        std::printf("friction %g: on the wire %.3f %.3f %.3f, at the base %.3f\n", friction, mean.x,
                    mean.y, mean.z, base.z);
        // Without the base's node, which is held; its clamp bears the rest.
        const double mass = 0.06 * 9.5 / 10, weight = 9810 * mass;
        EXPECT_GT(mean.y, 0.5 * weight);
        EXPECT_NEAR(mean.y - base.y, weight, 0.01 * weight);
        EXPECT_NEAR(mean.z, -friction * mean.y, 0.01 * mean.y);
        EXPECT_NEAR(base.z, mean.z - 20 * mass * 10, 0.01 * mean.y);  // with damping
        EXPECT_NEAR(mean.x, 0, 0.01 * mean.y);
    }
}

TEST(RodContact, AllocatesNothingOnceWarm) {
    const TaskArena arena(1);
    const VesselWall wall = bent_tube();
    PbdBody body = body_of(wall, 3e5);
    Rod rod = made(Rod::create(wire()));
    RodContact contact =
        made(RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions, {.friction = 0.1}));
    const auto push = [&](int from, int to) {
        for (int n = from; n < to; ++n) {
            EXPECT_TRUE(rod.set_base({0, 0, 0.08 * n}, Rotation{}).ok());
            EXPECT_TRUE(contact.step(1, rod, body, arena).ok());
        }
    };
    push(0, 400);
    const std::int64_t before = allocation_count();
    push(400, 401);
    for (int n = 0; n < 50; ++n) EXPECT_TRUE(contact.step(1, rod, body, arena).ok());
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(contact.touches().size(), 0u);
}

TEST(RodContact, SaysWhatIsWrong) {
    const TaskArena arena(1);
    VesselWall wall = floor_of(4);
    const auto message = [&](const RodContactSettings& settings) {
        const auto made_ =
            RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions, settings);
        return made_.ok() ? std::string() : made_.error().message;
    };
    EXPECT_EQ(message({}), "");
    EXPECT_NE(message({.radius = 0}).find("radius: expected a number above 0"), std::string::npos);
    EXPECT_NE(message({.friction = -1}).find("friction: expected 0 or more"), std::string::npos);
    EXPECT_NE(message({.iterations = 0}).find("iterations: expected 1"), std::string::npos);
    EXPECT_NE(message({.rounds = 0}).find("rounds: expected 1"), std::string::npos);
    RodContact contact = made(RodContact::create(wall.mesh, wall.ghost, wall.ghost_positions, {}));
    Rod rod = made(Rod::create(wire(1e-3)));
    PbdBody body = body_of(wall, 0, 2e-3);
    const Status steps = contact.step(1, rod, body, arena);
    ASSERT_FALSE(steps.ok());
    EXPECT_NE(steps.error().message.find("time_step"), std::string::npos);
    PbdBody other = body_of(floor_of(3), 0, 1e-3);
    EXPECT_FALSE(contact.step(1, rod, other, arena).ok());
    wall.ghost_positions[3].tetrahedron = 100000;
    EXPECT_NE(message({}).find("node 3: expected a tetrahedron below"), std::string::npos);
    wall.ghost_positions.pop_back();
    EXPECT_NE(message({}).find("ghost_positions: expected one for each"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
