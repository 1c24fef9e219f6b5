// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of deformable solids with tools and with each other: searches against all triangles,
// momentum, weights, Hertz' and Coulomb's laws, and that nothing gets through.
// Covers: pbd/body_surface.cpp, pbd/ghost_surface.cpp, pbd/piece_contact.cpp.

#include <gtest/gtest.h>
#include <pliant/models/body_contact.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "pbd/body_surface.h"
#include "pbd/piece_contact.h"
#include "pbd/segment_triangle.h"
#include "support/count_allocations.h"
#include "support/each_allocation.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using std::numbers::pi;

/// A block with one corner at a position. Its cells are cubes.
TetMesh block_at(Vec3i cells, double side, Vec3d corner) {
    TetMesh mesh = five_tet_block(cells, side);
    for (Vec3d& p : mesh.nodes_mm) p = p + corner;
    return mesh;
}

TetMesh both(TetMesh a, const TetMesh& b) {
    const auto offset = std::int32_t(a.nodes_mm.size());
    a.nodes_mm.insert(a.nodes_mm.end(), b.nodes_mm.begin(), b.nodes_mm.end());
    for (auto cell : b.cells) {
        for (std::int32_t& n : cell) n += offset;
        a.cells.push_back(cell);
    }
    return a;
}

constexpr double kSecond = 1e-3;  // a step

struct Soft {
    double young_modulus = 15000, density = 1e-3, damping = 5;
    double step = kSecond;
    Vec3d gravity{0, 0, 0};
    PbdPrecision precision = PbdPrecision::Float;
};
/// @param held  whether a node at rest is fixed
template <class Held>
PbdBody body_of(const TetMesh& mesh, const Soft& soft, const Held& held) {
    PbdParts parts = made(pbd_of_mesh(mesh, {.density = soft.density,
                                             .edges = false,
                                             .volumes = false,
                                             .solids = true,
                                             .young_modulus = soft.young_modulus,
                                             .poisson_ratio = 0.45}));
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (held(parts.positions[n])) parts.inverse_masses[n] = 0;
    return made(PbdBody::create(std::move(parts), {.time_step = soft.step,
                                                   .sub_steps = 1,
                                                   .gravity = soft.gravity,
                                                   .damping = soft.damping,
                                                   .precision = soft.precision}));
}
bool is_low(Vec3d p) {
    return p.z < 1e-9;
}
bool is_nothing(Vec3d) {
    return false;
}

BodyTool sphere(Vec3d p, double radius) {
    return {p, p, radius};
}
Status move(BodyContact& contact, std::int32_t count, PbdBody& body, const BodyTool& from,
            const BodyTool& to, const TaskArena& arena) {
    return contact.step(count, body, {&from, 1}, {&to, 1}, arena);
}

/// Depth of a tool whose axis is outside: radius − distance of the axis, over all triangles.
double brute_depth(const TetMesh& mesh, const PbdBody& body, const BodyTool& tool) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& f : boundary_faces(mesh)) {
        const auto pair = pbd::nearest_pair(tool.from, tool.to, body.position(f[0]),
                                            body.position(f[1]), body.position(f[2]));
        least = std::min(least, std::sqrt(pbd::distance2(pair)));
    }
    return tool.radius - least;
}

double smallest_volume(const PbdBody& body) {
    double least = 1e300;
    for (const PbdSolid& s : body.parts().solids) {
        const auto at = [&](std::size_t n) { return body.position(s.nodes[n]); };
        const auto rest = [&](std::size_t n) {
            return body.parts().positions[std::size_t(s.nodes[n])];
        };
        const auto volume = [](const auto& x) {
            return dot(cross(x(1) - x(0), x(2) - x(0)), x(3) - x(0));
        };
        least = std::min(least, volume(at) / volume(rest));
    }
    return least;
}

double fastest(const PbdBody& body) {
    double most = 0;
    for (std::int32_t n = 0; n < body.particle_count(); ++n)
        most = std::max(most, norm(body.velocity(n)));
    return most;
}

// Random spheres and capsules, larger and smaller than a triangle, go on random ways into a block.
TEST(BodyContact, NoTriangleRemainsInATool) {
    const TaskArena arena(1);
    int touched = 0;
    double deepest = 0, deepest_reported = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TetMesh mesh = block_at({6, 6, 4}, 2, {-6, -6, 0});
        PbdBody body = body_of(mesh, {}, is_low);
        BodyContact contact = made(BodyContact::create(mesh, {}, {.friction = 0.2 * (seed % 2)}));
        const double radius = random.ratio(0.2, 5);
        const Vec3d axis = random.whole(0, 1) ? random.vector(3) : Vec3d{0, 0, 0};
        const Vec3d from{random.real(-7, 7), random.real(-7, 7), 8.5 + radius + std::abs(axis.z)};
        const Vec3d by = Vec3d{random.real(-6, 6), random.real(-6, 6), 6.5} - from;
        const auto at = [&](double share) {
            const Vec3d p = from + share * by;
            return BodyTool{p, p + axis, radius};
        };
        for (int n = 0; n < 8; ++n) {
            const Status s = move(contact, 5, body, at(n / 8.0), at((n + 1) / 8.0), arena);
            ASSERT_TRUE(s.ok()) << s.error().message;
            const double depth = brute_depth(mesh, body, at((n + 1) / 8.0));
            deepest = std::max(deepest, depth / radius);
            deepest_reported = std::max(deepest_reported, contact.depth_left() / radius);
            EXPECT_LE(depth, 0.02 * radius);
            EXPECT_NEAR(contact.depth_left(), std::max(0.0, depth), 1e-4 * radius + 1e-5);
            touched += contact.touches() > 0;
        }
    }
    std::printf("deepest %.5f, reported %.5f radii; touched %d times\n", deepest, deepest_reported,
                touched);
    EXPECT_GT(touched, 100);
}

// The lists and the patches that are skipped leave out no touch, wherever nodes go.
TEST(PieceContact, FindsTheTouchesThatAllTrianglesHave) {
    const TaskArena arena(1);
    std::int64_t found_all = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        TetMesh mesh = both(block_at({5, 5, 3}, 1, {0, 0, 0}),
                            block_at({5, 4, 3}, 1.1, {0.2, 0.3, random.real(2.8, 3.1)}));
        mesh = both(std::move(mesh), block_at({3, 5, 5}, 0.9, {4.9, 0, 0}));
        const std::vector<std::int32_t> of_nodes = pieces(mesh);
        std::vector<std::int32_t> numbers;
        for (const auto& cell : mesh.cells) numbers.push_back(of_nodes[std::size_t(cell[0])]);
        const pbd::BodySurface surface(mesh, numbers);
        std::vector<Vec3d> x;
        for (const std::int32_t p : surface.particles()) x.push_back(mesh.nodes_mm[std::size_t(p)]);
        pbd::PieceContact contact(surface, x, 0.05);
        std::vector<pbd::PieceTouch> touches;
        for (int step = 0; step < 60; ++step) {
            const std::int32_t piece = random.whole(0, 2);
            const Vec3d by = random.vector(step % 10 == 0 ? 0.3 : 0.01);
            const double wave = random.real(0, 0.02);
            for (std::size_t n = 0; n < x.size(); ++n)
                if (surface.pieces()[n] == piece && (step % 3 != 0 || x[n].x > 2))
                    x[n] = x[n] + by + Vec3d{0, 0, wave * std::sin(3 * x[n].x)};
            contact.find(surface, x, x, arena, touches);
            std::vector<std::array<std::int32_t, 2>> found, expected;
            for (const pbd::PieceTouch& t : touches)
                found.push_back({t.node, surface.piece_of(t.triangle)});
            for (std::size_t n = 0; n < x.size(); ++n)
                for (std::int32_t other = 0; other < 3; ++other) {
                    if (other == surface.pieces()[n]) continue;
                    pbd::SurfacePoint best;
                    best.distance2 = std::numeric_limits<double>::infinity();
                    for (std::size_t p = 0; p < surface.patches().size(); ++p)
                        if (surface.patches()[p].piece == other)
                            surface.nearest_in_patch(p, x[n], x, best);
                    const double limit = contact.limit_of(std::int32_t(n), other);
                    if (std::sqrt(best.distance2) <= surface.mean_edge() &&
                        surface.signed_distance(x[n], best, x) < limit)
                        expected.push_back({std::int32_t(n), other});
                }
            std::sort(found.begin(), found.end());
            EXPECT_EQ(found, expected) << "step " << step;
            found_all += std::int64_t(found.size());
        }
    }
    EXPECT_GT(found_all, 3000);
}

/// Two blocks, the second of which moves: from one position to another, in a sub-step.
struct TwoBlocks {
    TetMesh mesh;
    pbd::BodySurface surface;
    std::vector<Vec3d> rest;
    pbd::PieceContact contact;

    explicit TwoBlocks(TetMesh blocks)
        : mesh(std::move(blocks)),
          surface(mesh, numbers()),
          rest(positions()),
          contact(surface, rest, 0) {}

    std::vector<std::int32_t> numbers() const {
        const std::vector<std::int32_t> of_nodes = pieces(mesh);
        std::vector<std::int32_t> of_cells;
        for (const auto& cell : mesh.cells) of_cells.push_back(of_nodes[std::size_t(cell[0])]);
        return of_cells;
    }
    std::vector<Vec3d> positions() const {
        std::vector<Vec3d> x;
        for (const std::int32_t p : surface.particles()) x.push_back(mesh.nodes_mm[std::size_t(p)]);
        return x;
    }
    std::vector<pbd::PieceTouch> find(Vec3d from, Vec3d to) {
        const TaskArena arena(1);
        std::vector<Vec3d> start = rest, end = rest;
        for (std::size_t n = 0; n < rest.size(); ++n) {
            if (surface.pieces()[n] != 1) continue;
            start[n] = rest[n] + from;
            end[n] = rest[n] + to;
        }
        std::vector<pbd::PieceTouch> touches;
        contact.find(surface, start, end, arena, touches);
        return touches;
    }
};

// A block beside another one moves to the side into it: its bottom is level with the other's top,
// or below.
TEST(PieceContact, ANodeLevelWithARimIsNotCaughtByItsSide) {
    for (const double depth : {0.001, 0.01, 0.3}) {
        SCOPED_TRACE(depth);
        TwoBlocks blocks(
            both(block_at({4, 4, 3}, 1, {0, 0, 0}), block_at({3, 3, 3}, 0.9, {4.5, 0.6, 3.2})));
        const double down = -0.2 - depth;
        const auto touches = blocks.find({-0.45, 0, down}, {-0.65, 0, down});
        ASSERT_GE(touches.size(), 4u);
        for (const pbd::PieceTouch& touch : touches) {
            const double sideways = std::abs(touch.normal.x), upwards = std::abs(touch.normal.z);
            EXPECT_GT(depth < 0.1 ? upwards : sideways, 0.9);
        }
    }
}

// Through a wall that is thinner than the way of a sub-step, and through its middle.
TEST(PieceContact, ANodeThatCrossedAWallIsFoundOnItsFirstSide) {
    for (const double way : {0.15, 0.24}) {
        SCOPED_TRACE(way);
        TetMesh wall = block_at({6, 6, 1}, 1, {-3, -3, 0});
        for (Vec3d& p : wall.nodes_mm) p.z *= 0.1;
        TwoBlocks blocks(both(std::move(wall), block_at({2, 2, 2}, 1, {-1, -1, 0.3})));
        std::int64_t from_above = 0;
        for (const pbd::PieceTouch& touch : blocks.find({0, 0, -0.15}, {0, 0, -0.15 - 0.1 - way}))
            from_above +=
                blocks.surface.pieces()[std::size_t(touch.node)] == 1 && touch.normal.z > 0.9;
        EXPECT_EQ(from_above, 9);
    }
}

// One that has seen other positions, and a new one. Some sub-steps are so fast that the search at
// their end is left out.
TEST(PieceContact, FindsTheSameTouchesWhateverItSawBefore) {
    std::int64_t found_all = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto make = [] {
            return TwoBlocks(both(block_at({5, 5, 3}, 1, {0, 0, 0}),
                                  block_at({5, 4, 3}, 1.1, {0.2, 0.3, 3.05})));
        };
        TwoBlocks old = make();
        Vec3d from{0, 0, 0};
        for (int step = 0; step < 80; ++step) {
            const Vec3d to = from + random.vector(step % 10 == 0 ? 0.4 : 0.1) -
                             Vec3d{0, 0, 0.1 * (from.z + 0.2)};
            const auto known = old.find(from, to), expected = make().find(from, to);
            ASSERT_EQ(known.size(), expected.size()) << step;
            for (std::size_t n = 0; n < known.size(); ++n) {
                EXPECT_EQ(known[n].node, expected[n].node);
                EXPECT_EQ(known[n].triangle, expected[n].triangle);
                EXPECT_EQ(known[n].normal, expected[n].normal);
                EXPECT_EQ(known[n].weights, expected[n].weights);
                EXPECT_EQ(known[n].apart, expected[n].apart);
            }
            found_all += std::int64_t(known.size());
            from = to + random.vector(0.02);
        }
    }
    EXPECT_GT(found_all, 3000);
}

/// Sums over the particles with a mass.
struct Momenta {
    Vec3d momentum{0, 0, 0}, angular{0, 0, 0};
    double size = 0;
};
/// Change of momentum by contact: the same step with and without it.
Momenta change(const PbdBody& with, const PbdBody& without) {
    Momenta sum;
    for (std::int32_t p = 0; p < with.particle_count(); ++p) {
        if (!(with.inverse_mass(p) > 0)) continue;
        const Vec3d by = (1 / with.inverse_mass(p)) * (with.velocity(p) - without.velocity(p));
        sum.momentum = sum.momentum + by;
        sum.angular = sum.angular + cross(without.position(p), by);
        sum.size += norm(by);
    }
    return sum;
}

TEST(BodyContact, PiecesKeepMomentumAndAngularMomentum) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const bool rubs = seed % 2 == 0;
        TetMesh mesh =
            both(block_at({4, 4, 3}, 1, {0, 0, 0}), block_at({3, 3, 3}, 1.1, {0.3, 0.4, 3.05}));
        PbdBody body = body_of(mesh, {.precision = PbdPrecision::Double}, is_nothing),
                twin = body_of(mesh, {.precision = PbdPrecision::Double}, is_nothing);
        const Vec3d v{random.real(-20, 20), random.real(-20, 20), -150}, spin = random.vector(3);
        for (std::int32_t n = 100; n < body.particle_count(); ++n)
            for (PbdBody* each : {&body, &twin}) {
                const Vec3d x = each->position(n);
                ASSERT_TRUE(each->set_state(n, x, v + cross(spin, x)).ok());
            }
        BodyContact contact = made(BodyContact::create(mesh, {}, {.friction = rubs ? 0.5 : 0}));
        ASSERT_TRUE(contact.step(1, body, {}, {}, arena).ok());
        ASSERT_TRUE(twin.step(1, arena).ok());
        const Momenta sum = change(body, twin);
        EXPECT_GT(contact.touches(), 3);
        EXPECT_GT(sum.size, 1e-3);
        EXPECT_LT(norm(sum.momentum), 1e-10 * sum.size);
        // Friction acts at a node and a point of a triangle, apart by the way of the sub-step.
        EXPECT_LT(norm(sum.angular), (rubs ? 0.5 * 0.15 : 1e-9) * sum.size);
        EXPECT_LT(norm(contact.piece_force(0) + contact.piece_force(1)),
                  1e-10 * norm(contact.piece_force(0)));
    }
}

TEST(BodyContact, ABlockRestsOnABlockWithItsWeight) {
    const TaskArena arena(1);
    const TetMesh mesh =
        both(block_at({8, 8, 4}, 2, {0, 0, 0}), block_at({5, 5, 5}, 2, {3.1, 2.7, 8.01}));
    const double weight = 1e-3 * 1000 * 9810;  // of 10 mm cubed [µN]
    PbdBody body = body_of(mesh, {.damping = 20, .gravity = {0, 0, -9810}}, is_low);
    BodyContact contact = made(BodyContact::create(mesh, {}, {}));
    for (int n = 0; n < 1500; ++n) ASSERT_TRUE(contact.step(1, body, {}, {}, arena).ok());
    ASSERT_TRUE(contact.step(100, body, {}, {}, arena).ok());
    const Vec3d force = contact.piece_force(1);
    std::printf("on the block %.1f %.1f %.1f, weight %.1f; depth %.5f, fastest %.4f\n", force.x,
                force.y, force.z, weight, contact.depth_left(), fastest(body));
    EXPECT_NEAR(force.z, weight, 0.01 * weight);
    EXPECT_NEAR(std::hypot(force.x, force.y), 0, 0.01 * weight);
    EXPECT_LT(contact.depth_left(), 0.02);
}

// Blocks with surfaces that coincide, that overlap by a part of an edge, and that are apart.
TEST(BodyContact, PiecesAtRestStayThereBitForBit) {
    const TaskArena arena(1);
    for (const double overlap : {0.0, 0.7, -0.2}) {
        SCOPED_TRACE(overlap);
        TetMesh mesh = both(block_at({4, 4, 4}, 1.3, {50, 3, 100}),
                            block_at({4, 4, 4}, 1.3, {50, 3, 105.2 - overlap}));
        mesh = both(std::move(mesh), block_at({3, 6, 5}, 1.1, {55.2 - overlap, 2, 101}));
        PbdBody body = body_of(mesh, {}, is_nothing), twin = body_of(mesh, {}, is_nothing);
        BodyContact contact = made(BodyContact::create(mesh, {}, {.gap = 0.1}));
        ASSERT_TRUE(contact.step(50, body, {}, {}, arena).ok());
        ASSERT_TRUE(twin.step(50, arena).ok());
        EXPECT_EQ(body.hash(), twin.hash());
        EXPECT_EQ(contact.touches(), 0);
        // But they can't be pushed into each other.
        for (std::int32_t n = 125; n < 250; ++n)
            ASSERT_TRUE(body.set_state(n, body.position(n), {0, 0, -100}).ok());
        ASSERT_TRUE(contact.step(8, body, {}, {}, arena).ok());
        EXPECT_GT(contact.touches(), 0);
        EXPECT_LT(contact.depth_left(), 0.05);
    }
}

// A wall thinner than the sphere, and than a step of it, which hits a triangle in the middle, an
// edge or a node.
TEST(BodyContact, AFastSmallSphereDoesNotCrossAThinWall) {
    const TaskArena arena(1);
    for (const Vec3d hit : {Vec3d{0.3, 0.4, 0}, Vec3d{0, 0, 0}, Vec3d{0.5, 0.5, 0}})
        for (const double way : {2.0, 8.0}) {  // in one step; the radius is 0.2 mm
            TetMesh mesh = five_tet_block({12, 12, 1}, 1);
            for (Vec3d& p : mesh.nodes_mm) p = {p.x - 6, p.y - 6, 0.1 * p.z};
            PbdBody body = body_of(mesh, {}, [](Vec3d p) { return std::abs(p.x) > 5.9; });
            BodyContact contact = made(BodyContact::create(mesh, {}, {}));
            const Vec3d above = hit + Vec3d{0, 0, 0.4}, below = above - Vec3d{0, 0, way};
            const Status s = move(contact, 1, body, sphere(above, 0.2), sphere(below, 0.2), arena);
            ASSERT_TRUE(s.ok()) << s.error().message;
            EXPECT_LT(brute_depth(mesh, body, sphere(below, 0.2)), 0.03 * 0.2);
            EXPECT_LT(contact.depth_left(), 0.03 * 0.2);
            for (const auto& f : boundary_faces(mesh)) {  // none is above the sphere
                double along = 0;
                EXPECT_FALSE(pbd::goes_through(below, {0, 0, 100}, body.position(f[0]),
                                               body.position(f[1]), body.position(f[2]), along));
            }
            EXPECT_GT(contact.force(0).z, 0);
        }
}

TEST(BodyContact, AToolThatStartsInsideIsFreedWithoutAnExplosion) {
    const TaskArena arena(1);
    for (const BodyTool tool :
         {sphere({0.4, 0.3, 6.5}, 1), sphere({5.5, 0.2, 4}, 0.5), sphere({0.1, -5, 5}, 2),
          BodyTool{{-2, 0, 6.6}, {2, 0.5, 6.9}, 0.8}}) {
        const TetMesh mesh = block_at({8, 8, 5}, 1.6, {-6.4, -6.4, 0});
        PbdBody body = body_of(mesh, {.damping = 20}, is_low);
        BodyContact contact = made(BodyContact::create(mesh, {}, {}));
        double fast = 0, before = 1e9;
        for (int n = 0; n < 120; ++n) {
            ASSERT_TRUE(move(contact, 1, body, tool, tool, arena).ok());
            fast = std::max(fast, fastest(body));
            EXPECT_LT(contact.depth_left(), before + 0.02 * tool.radius) << n;
            before = contact.depth_left();
        }
        const double folded = smallest_volume(body);
        EXPECT_LT(before, 0.02 * tool.radius);
        EXPECT_LT(brute_depth(mesh, body, tool), 0.02 * tool.radius);
        EXPECT_LT(fast, 2000);  // waves go at 7500 mm/s
        ASSERT_TRUE(contact.step(400, body, {}, {}, arena).ok());
        double away = 0;
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            away = std::max(away, norm(body.position(n) - mesh.nodes_mm[std::size_t(n)]));
        std::printf("left %.4f, fastest %.0f mm/s, smallest volume %.2f; later %.4f mm from rest\n",
                    before, fast, folded, away);
        EXPECT_LT(away, 0.1);
    }
}

/// Force on a sphere that is pushed into the middle of a block's top, and rests there.
struct Indented {
    double contact = 0, held = 0;  ///< by contact; on the same nodes, if they are held there
};
Indented indent(double step) {
    const TaskArena arena(1);
    const double radius = 12, by = 0.8;
    const TetMesh mesh = block_at({20, 20, 10}, 1.6, {-16, -16, 0});
    PbdBody body = body_of(mesh, {.damping = 20, .step = step}, is_low);
    BodyContact contact = made(BodyContact::create(mesh, {}, {}));
    const int count = int(std::lround(0.1 / step)), more = int(std::lround(0.2 / step));
    const BodyTool from = sphere({0, 0, 16 + radius}, radius),
                   to = sphere({0, 0, 16 + radius - by}, radius);
    EXPECT_TRUE(move(contact, count, body, from, to, arena).ok());
    EXPECT_TRUE(move(contact, more, body, to, to, arena).ok());
    EXPECT_TRUE(move(contact, more / 4, body, to, to, arena).ok());
    Indented found{contact.force(0).z, 0};
    std::vector<std::int32_t> held;
    for (std::int32_t n = 0; n < body.particle_count(); ++n)
        if (norm(body.position(n) - to.from) < radius * 1.01) {
            held.push_back(n);
            EXPECT_TRUE(body.set_inverse_mass(n, 0).ok());
        }
    EXPECT_TRUE(body.step(more, arena).ok());
    const std::vector<Vec3d> forces = body.constraint_forces();
    for (const std::int32_t n : held) found.held += forces[std::size_t(n)].z;
    return found;
}

// Hertz' force with the factor of a layer that is bonded to a rigid ground [Dimitriadis2002].
// The contact radius, 3.1 mm, is two cells.
TEST(BodyContact, ASphereFeelsHertzForce) {
    const double radius = 12, by = 0.8, poisson = 0.45;
    const double hertz =
        4.0 / 3 * 15000 / (1 - poisson * poisson) * std::sqrt(radius) * std::pow(by, 1.5);
    const double chi = std::sqrt(radius * by) / 16;
    const double a = -(1.2876 - 1.4678 * poisson + 1.3442 * poisson * poisson) / (1 - poisson),
                 b = (0.6387 - 1.0277 * poisson + 1.5164 * poisson * poisson) / (1 - poisson);
    const double layer =
        hertz * (1 - 2 * a / pi * chi + 4 * a * a / (pi * pi) * chi * chi -
                 8 / (pi * pi * pi) * (a * a * a + 4 * pi * pi / 15 * b) * chi * chi * chi);
    const Indented fine = indent(1e-4), coarse = indent(5e-4);
    std::printf("layer %.0f; steps of 0.1 ms %.0f, held %.0f; of 0.5 ms %.0f, held %.0f\n", layer,
                fine.contact, fine.held, coarse.contact, coarse.held);
    EXPECT_NEAR(fine.contact, layer, 0.1 * layer);
    EXPECT_NEAR(fine.contact, fine.held, 0.1 * fine.held);
    EXPECT_NEAR(coarse.contact, coarse.held, 0.25 * coarse.held);
}

/// A block on a fixed one, under gravity that is inclined. @returns its speed after 0.1 s
double slide(double friction, double angle) {
    const TaskArena arena(1);
    const TetMesh mesh =
        both(block_at({20, 6, 2}, 2, {0, 0, 0}), block_at({3, 3, 3}, 1.9, {2.1, 3.3, 4.001}));
    PbdBody body = body_of(mesh,
                           {.young_modulus = 1e5,
                            .damping = 0,
                            .gravity = {9810 * std::sin(angle), 0, -9810 * std::cos(angle)}},
                           [](Vec3d p) { return p.z < 4.0005; });
    BodyContact contact = made(BodyContact::create(mesh, {}, {.friction = friction}));
    EXPECT_TRUE(contact.step(100, body, {}, {}, arena).ok());
    Vec3d sum{0, 0, 0};
    for (std::int32_t n = body.particle_count() - 64; n < body.particle_count(); ++n)
        sum = sum + (1.0 / 64) * body.velocity(n);
    return sum.x;
}

// Coulomb's limit is tan(angle) = 0.42.
TEST(BodyContact, APieceSlidesDownASlopeAsCoulombsLawSays) {
    const double angle = 0.4, time = 0.1;
    for (const double friction : {0.0, 0.2}) {
        const double speed = slide(friction, angle),
                     law = 9810 * (std::sin(angle) - friction * std::cos(angle)) * time;
        std::printf("friction %.1f: %.1f, by the law %.1f mm/s\n", friction, speed, law);
        EXPECT_NEAR(speed, law, 0.05 * law);
    }
    EXPECT_LT(slide(0.6, angle), 0.02 * 9810 * std::sin(angle) * time);
}

// A sphere that slides over a block drags it along by friction times the normal force.
TEST(BodyContact, FrictionOfToolsIsCoulombs) {
    const TaskArena arena(1);
    for (const double friction : {0.0, 0.3}) {
        const TetMesh mesh = block_at({16, 8, 4}, 1.6, {-12.8, -6.4, 0});
        PbdBody body = body_of(mesh, {.damping = 20}, is_low);
        BodyContact contact = made(BodyContact::create(mesh, {}, {.friction = friction}));
        const BodyTool above = sphere({-6, 0.2, 10.4}, 4), in = sphere({-6, 0.2, 9.6}, 4),
                       middle = sphere({0, 0.2, 9.6}, 4), end = sphere({4, 0.2, 9.6}, 4);
        ASSERT_TRUE(move(contact, 100, body, above, in, arena).ok());
        ASSERT_TRUE(move(contact, 300, body, in, middle, arena).ok());
        ASSERT_TRUE(move(contact, 200, body, middle, end, arena).ok());
        const Vec3d force = contact.force(0);
        std::printf("friction %.1f: force %.0f %.0f %.0f\n", friction, force.x, force.y, force.z);
        EXPECT_GT(force.z, 1000);
        EXPECT_NEAR(force.x, -friction * force.z, 0.1 * force.z);
    }
}

/// Blocks on each other, held below, that a capsule presses and wipes.
struct Scene {
    TetMesh mesh = both(block_at({6, 6, 3}, 2, {-6, -6, 0}), block_at({5, 5, 3}, 2, {-5, -5, 6}));
    PbdBody body = body_of(mesh, {.gravity = {0, 0, -9810}}, is_low);
    BodyContact contact = made(BodyContact::create(mesh, {}, {.friction = 0.2}));
    static BodyTool tool(double share) {
        const Vec3d p{-3 + 6 * share, -2, 13.8 - 3.5 * share};
        return {p, p + Vec3d{1, 3, 0.4}, 1.5};
    }
    Status go(int from, int to, const TaskArena& arena) {
        Status status = Ok{};
        for (int n = from; n < to && status.ok(); ++n)
            status = move(contact, 5, body, tool(n / 20.0), tool((n + 1) / 20.0), arena);
        return status;
    }
    std::vector<double> numbers() const {
        std::vector<double> all;
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            for (const Vec3d v : {body.position(n), body.velocity(n)})
                for (int c = 0; c < 3; ++c) all.push_back(v[c]);
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            all.push_back(body.inverse_mass(n));
        return all;
    }
};

TEST(BodyContact, IsTheSameForAnyNumberOfThreads) {
    std::vector<double> one;
    for (const int threads : {1, 2, 4}) {
        Scene scene;
        ASSERT_TRUE(scene.go(0, 20, TaskArena(threads)).ok());
        EXPECT_GT(scene.contact.touches(), 10);
        if (threads == 1) one = scene.numbers();
        EXPECT_EQ(scene.numbers(), one) << threads;
    }
}

// A state that was set gives the bits that it gave before, with the same object or a new one.
TEST(BodyContact, RemembersNothingButTheBodysState) {
    const TaskArena arena(1);
    Scene scene;
    ASSERT_TRUE(scene.go(0, 8, arena).ok());
    std::vector<Vec3d> x, v;
    for (std::int32_t n = 0; n < scene.body.particle_count(); ++n) {
        x.push_back(scene.body.position(n));
        v.push_back(scene.body.velocity(n));
    }
    const auto set_back = [&] {
        for (std::int32_t n = 0; n < scene.body.particle_count(); ++n)
            EXPECT_TRUE(scene.body.set_state(n, x[std::size_t(n)], v[std::size_t(n)]).ok());
    };
    ASSERT_TRUE(scene.go(8, 16, arena).ok());
    const std::vector<double> expected = scene.numbers();
    const Vec3d force = scene.contact.force(0);
    ASSERT_TRUE(scene.go(16, 20, arena).ok());
    set_back();
    ASSERT_TRUE(scene.go(8, 16, arena).ok());
    EXPECT_EQ(scene.numbers(), expected);
    EXPECT_EQ(scene.contact.force(0), force);
    set_back();
    scene.contact = made(BodyContact::create(scene.mesh, {}, {.friction = 0.2}));
    ASSERT_TRUE(scene.go(8, 16, arena).ok());
    EXPECT_EQ(scene.numbers(), expected);
}

TEST(BodyContact, AFailedStepChangesNothing) {
    const TaskArena one(1);
    const auto make = [&] {
        auto scene = std::make_unique<Scene>();
        EXPECT_TRUE(scene->go(0, 6, one).ok());
        // Memory of earlier steps would not be there in a longer run.
        scene->contact = made(BodyContact::create(scene->mesh, {}, {.friction = 0.2}));
        return scene;
    };
    const Failures failures = fail_each_allocation(
        make, [&](Scene& scene) { return scene.go(6, 7, one); },
        [](const Scene& scene) { return scene.numbers(); }, {.all_up_to = 60, .of_the_rest = 20});
    EXPECT_GT(failures.failed, 5);
    int failed = 0;
    for (int n = 0; n < 400; n = n < 20 ? n + 1 : n + 17) {
        const TetMesh mesh = block_at({4, 4, 4}, 1, {0, 0, 0});
        const FailingAllocation failing(n);
        const auto contact = BodyContact::create(mesh, {}, {});
        if (contact.ok()) break;
        ++failed;
        if (contact.error().code != ErrorCode::LimitExceeded) FAIL() << "allocation " << n;
    }
    EXPECT_GT(failed, 10);
}

TEST(BodyContact, AllocatesNothingOnceWarm) {
    const TaskArena arena(1);
    Scene scene;
    ASSERT_TRUE(scene.go(0, 20, arena).ok());
    for (int turn = 0; turn < 2; ++turn) {
        const std::int64_t before = allocation_count();
        for (int n = 0; n < 20; ++n)
            ASSERT_TRUE(
                move(scene.contact, 5, scene.body, Scene::tool(1), Scene::tool(1), arena).ok());
        if (turn == 1) {
            EXPECT_EQ(allocation_count(), before);
        }
    }
    EXPECT_GT(scene.contact.touches(), 0);
}

TEST(BodyContact, SaysWhatIsWrong) {
    const TaskArena arena(1);
    const TetMesh mesh = block_at({2, 2, 2}, 1, {0, 0, 0});
    const auto message = [&](const BodyContactSettings& settings,
                             const std::vector<std::int32_t>& pieces = {}) {
        const auto contact = BodyContact::create(mesh, pieces, settings);
        return contact.ok() ? std::string() : contact.error().message;
    };
    EXPECT_EQ(message({}), "");
    EXPECT_NE(message({.friction = -1}).find("friction: expected 0 or more"), std::string::npos);
    EXPECT_NE(message({.iterations = 0}).find("iterations: expected 1 or more"), std::string::npos);
    EXPECT_NE(message({}, {1, 2}).find("pieces: expected a number for each of 40 tetrahedra"),
              std::string::npos);
    EXPECT_NE(message({}, std::vector<std::int32_t>(40, -1)).find("pieces: expected numbers of 0"),
              std::string::npos);
    EXPECT_FALSE(BodyContact::create({}, {}, {}).ok());
    PbdBody body = body_of(mesh, {}, is_low);
    BodyContact contact = made(BodyContact::create(mesh, {}, {}));
    const std::uint64_t before = body.hash();
    const auto refusal = [&](const BodyTool& from, const BodyTool& to, int count = 1) {
        const Status s = move(contact, count, body, from, to, arena);
        EXPECT_FALSE(s.ok());
        EXPECT_EQ(body.hash(), before);
        return s.ok() ? std::string() : s.error().message;
    };
    const BodyTool tool = sphere({1, 1, 3}, 0.5);
    EXPECT_NE(refusal(tool, tool, -1).find("expected 0 steps or more"), std::string::npos);
    EXPECT_NE(refusal(sphere({0, 0, 0}, 0), tool).find("tool 0: expected a radius above 0"),
              std::string::npos);
    EXPECT_NE(refusal(tool, sphere({1, 1, 3}, 0.6)).find("expected the same radius"),
              std::string::npos);
    EXPECT_NE(refusal(tool, sphere({1, 1, 1000}, 0.5)).find("at most 1000 radii"),
              std::string::npos);
    EXPECT_NE(refusal(tool, sphere({1, 1, NAN}, 0.5)).find("expected finite positions"),
              std::string::npos);
    EXPECT_FALSE(contact.step(1, body, {&tool, 1}, {}, arena).ok());
    PbdBody other = body_of(block_at({2, 2, 3}, 1, {0, 0, 0}), {}, is_low);
    EXPECT_NE(move(contact, 1, other, tool, tool, arena).error().message.find("expected a body"),
              std::string::npos);
}

}  // namespace
}  // namespace pliant::test
