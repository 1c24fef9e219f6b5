// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases 1, 2 and 13, through the public interface: a constraint's force over its multiplier is its
// gradient; a step of a free body has no momentum; a rigidly rotated body has no forces.

#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>

#include "published.h"
#include "value_of.h"

namespace pliant::results {
namespace {

double volume_of(const std::array<Vec3d, 4>& x) {
    return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6;
}

/// Four positions with a nonzero volume.
std::vector<Vec3d> tetrahedron(Numbers& random) {
    std::array<Vec3d, 4> x{};
    while (!(volume_of(x) > 0.02))
        for (Vec3d& p : x) p = random.vector(1);
    return {x.begin(), x.end()};
}

/// Central differences of order four.
double slope(std::array<Vec3d, 4> x, std::size_t node, int axis) {
    constexpr double kStep = 1e-3;
    const auto value = [&](double steps) {
        std::array<Vec3d, 4> moved = x;
        moved[node][axis] += steps * kStep;
        return volume_of(moved);
    };
    return (8 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12 * kStep);
}

/// One violated constraint on four free particles.
PbdParts one_constraint(Numbers& random, PbdKind kind) {
    PbdParts parts;
    parts.positions = tetrahedron(random);
    for (int n = 0; n < 4; ++n) parts.inverse_masses.push_back(random.real(0.2, 2));
    if (kind == PbdKind::Distance) parts.distances = {{.nodes = {0, 1}, .rest_length = 0.3}};
    if (kind == PbdKind::Bend) parts.bends = {{.nodes = {0, 1, 2, 3}, .rest_angle = 0.1}};
    if (kind == PbdKind::Volume) parts.volumes = {{.nodes = {0, 1, 2, 3}, .rest_volume = 0.5}};
    if (kind == PbdKind::Solid) parts.solids = {{{0, 1, 2, 3}, 10, random.real(0.1, 0.49)}};
    return parts;
}

}  // namespace

Cases gradient_cases() {
    double sum = 0, off = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Numbers random(seed);
        PbdParts parts;
        parts.positions = tetrahedron(random);
        parts.inverse_masses.assign(4, 1);
        parts.volumes = {{.nodes = {0, 1, 2, 3}, .rest_volume = 0.25, .compliance = 1e-2}};
        auto body = value_of(PbdBody::create(
            parts, {.time_step = 0.1, .sub_steps = 1, .precision = PbdPrecision::Double}));
        must(body.step(1, one_thread()));
        std::array<Vec3d, 4> now{};
        body.get_positions(now);
        const auto forces = body.constraint_forces();
        const double multiplier = body.multiplier(PbdKind::Volume, 0);
        Vec3d all{0, 0, 0};
        for (std::size_t n = 0; n < 4; ++n) {
            const Vec3d g = (1 / multiplier) * forces[n];
            all = all + g;
            Vec3d difference{0, 0, 0};
            for (int axis = 0; axis < 3; ++axis) difference[axis] = slope(now, n, axis);
            off = std::max(off, norm(g - difference) / norm(g));
        }
        sum = std::max(sum, norm(all));
    }
    return {at_most(1, "gradients of a volume: their sum, 100 random tetrahedra", sum, 1e-12),
            at_most(1, "the same against finite differences, relative", off, 1e-6)};
}

Cases momentum_cases() {
    Cases cases;
    const struct {
        PbdKind kind;
        const char* name;
    } kinds[] = {{PbdKind::Distance, "distance"},
                 {PbdKind::Bend, "bend"},
                 {PbdKind::Volume, "volume"},
                 {PbdKind::Solid, "neo-Hookean solid"}};
    for (const auto& k : kinds) {
        double linear = 0, angular = 0;
        for (std::uint64_t seed = 1; seed <= 50; ++seed) {
            Numbers random(seed);
            const PbdParts parts = one_constraint(random, k.kind);
            auto body = value_of(PbdBody::create(
                parts, {.time_step = 0.1, .sub_steps = 1, .precision = PbdPrecision::Double}));
            std::vector<Vec3d> x = parts.positions;
            if (k.kind == PbdKind::Solid)  // at rest there would be no force
                for (std::size_t n = 0; n < 4; ++n) {
                    x[n] = x[n] + random.vector(0.2);
                    must(body.set_state(std::int32_t(n), x[n], {0, 0, 0}));
                }
            must(body.step(1, one_thread()));
            Vec3d momentum{0, 0, 0}, turning{0, 0, 0};
            double size = 0;
            for (std::size_t n = 0; n < 4; ++n) {
                const Vec3d moved =
                    (1 / parts.inverse_masses[n]) * (body.position(std::int32_t(n)) - x[n]);
                momentum = momentum + moved;
                turning = turning + cross(x[n], moved);
                size = std::max(size, norm(moved));
            }
            linear = std::max(linear, norm(momentum) / size);
            angular = std::max(angular, norm(turning) / size);
        }
        const std::string what = std::string("one projection of a ") + k.name;
        cases.push_back(at_most(2, what + ": momentum, relative", linear, 1e-12));
        cases.push_back(at_most(2, what + ": angular momentum", angular, 4e-12));
    }
    return cases;
}

Cases turned_cases() {
    double force[2] = {0, 0};
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        Numbers random(seed);
        const double young = 1e5;
        TetMesh mesh = five_tet_block({4, 3, 3}, 0.02);
        for (Vec3d& p : mesh.nodes_mm) p = p + random.vector(0.003);
        const PbdParts parts = value_of(pbd_of_mesh(mesh, {.density = 1000,
                                                           .edge_compliance = 1e-3,
                                                           .volume_compliance = 1e-12,
                                                           .bend_compliance = 10,
                                                           .bends = true,
                                                           .solids = true,
                                                           .young_modulus = young}));
        const Rotation turn = rotation_by(random.vector(3));
        const Vec3d shift = random.vector(0.1);
        for (const PbdPrecision numbers : {PbdPrecision::Double, PbdPrecision::Float}) {
            auto body = value_of(PbdBody::create(parts, {.time_step = 1e-3, .precision = numbers}));
            for (std::size_t n = 0; n < parts.positions.size(); ++n)
                must(body.set_state(std::int32_t(n), rotated(turn, parts.positions[n]) + shift,
                                    {0, 0, 0}));
            must(body.step(1, one_thread()));
            // Relative to the force of a strain of 1 on a tetrahedron's face.
            for (const Vec3d& f : body.constraint_forces()) {
                double& most = force[numbers == PbdPrecision::Float];
                most = std::max(most, norm(f) / (young * 0.02 * 0.02));
            }
        }
    }
    return {at_most(13, "a body turned as a whole: force, relative, as doubles", force[0], 1e-6),
            at_most(13, "the same as floats", force[1], 1e-2)};
}

}  // namespace pliant::results
