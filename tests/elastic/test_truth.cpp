// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic scan beside solutions that share nothing with it: Hertz' force on a sphere, and a
// cantilever of neo-Hookean material that is bent by 30 degrees.
// Covers: elastic/levels.cpp, elastic/level.cpp, elastic/stiffness_map.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "elastic/lattices.h"
#include "elastic/levels.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr double kModulusPa = 1e4;
constexpr int kValue = 1000;  ///< of a voxel with this modulus, in plain_settings()

double sum_along_z(ElasticLevels& levels, const std::vector<HeldNode>& held) {
    std::vector<Vec3i> nodes;
    for (const HeldNode& node : held) nodes.push_back(node.node);
    double sum = 0;
    for (const Vec3d& force : levels.forces_un(nodes)) sum += force.z;
    return sum;
}

/// A sphere above the top of a layer, in mm.
struct Indenter {
    double radius, depth;  ///< depth of its lowest point below the layer's top at rest
    Vec3d above;           ///< node above which it is; x and y are fractions
};

/// Hertz' force [uN] in a layer of a thickness that is bonded to a rigid ground [Dimitriadis2002].
double hertz_un(const Indenter& sphere, double thickness, double nu) {
    const double pi = std::numbers::pi;
    const double chi = std::sqrt(sphere.radius * sphere.depth) / thickness;
    const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu);
    const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
    const double layer =
        1 - 2 * a / pi * chi + 4 * a * a / (pi * pi) * chi * chi -
        8 / std::pow(pi, 3) * (std::pow(a, 3) + 4 * pi * pi / 15 * b) * std::pow(chi, 3) +
        16 * a / std::pow(pi, 4) * (std::pow(a, 3) + 3 * pi * pi / 5 * b) * std::pow(chi, 4);
    return 4.0 / 3 * kModulusPa / (1 - nu * nu) * std::sqrt(sphere.radius) *
           std::pow(sphere.depth, 1.5) * layer;
}

/// Force [uN] on a frictionless sphere: an active set of the nodes of the top.
double indent_un(ElasticLevels& levels, const Indenter& sphere) {
    const auto surface = [&](Vec3i node) {  // of the sphere, from the top at rest
        const double x = node.x - sphere.above.x, y = node.y - sphere.above.y;
        const double square = sphere.radius * sphere.radius - x * x - y * y;
        return sphere.radius - sphere.depth - std::sqrt(std::max(square, 0.0));
    };
    std::vector<Vec3i> candidates;
    const int reach = int(std::sqrt(2 * sphere.radius * sphere.depth)) + 2;
    for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
            const Vec3i node{int(sphere.above.x) + i, int(sphere.above.y) + j, int(sphere.above.z)};
            if (surface(node) < 0) candidates.push_back(node);
        }
    const auto held_at = [&](Vec3i node) {
        return HeldNode{node, {0, 0, surface(node)}, Vec3d{0, 0, -1}};
    };
    std::vector<HeldNode> held;
    for (const Vec3i node : candidates) held.push_back(held_at(node));
    for (int round = 0; round < 20; ++round) {
        levels.hold(held);
        (void)levels.start();
        for (int n = 0; n < 4; ++n) (void)levels.iterate();
        const std::vector<Vec3d> forces = levels.forces_un(candidates);
        std::vector<HeldNode> next;
        for (std::size_t n = 0; n < candidates.size(); ++n) {
            const Vec3i node = candidates[n];
            const bool was_held = std::any_of(held.begin(), held.end(),
                                              [&](const HeldNode& h) { return h.node == node; });
            // Contacts push the tissue down; other nodes of the top stay below the sphere.
            if (was_held ? forces[n].z < 0 : displacement(levels, node).z > surface(node) + 1e-5)
                next.push_back(held_at(node));
        }
        const bool same =
            next.size() == held.size() &&
            std::equal(next.begin(), next.end(), held.begin(),
                       [](const HeldNode& p, const HeldNode& q) { return p.node == q.node; });
        held = std::move(next);
        if (same) return -sum_along_z(levels, held);
    }
    ADD_FAILURE() << "the contacts don't settle";
    return 0;
}

// The contact radius is 9 to 13 cells. Results fluctuate by some per mille with the position of
// the sphere between nodes.
TEST(Truth, ASphereFeelsHertzForce) {
    const TaskArena arena(1);
    constexpr int kThickness = 128;
    const Volume scan =
        scan_of({257, 257, kThickness + 1}, {1, 1, 1}, [](Vec3i) { return kValue; });
    for (const double nu : {0.3, 0.45}) {
        auto settings = plain_settings(nu);
        settings.held_sides = {"-z"};
        const StiffnessMap map(scan, settings, arena);
        for (const int seed : {3, 7}) {
            Random random{std::uint64_t(seed)};
            const double contact = random.real(9, 13), radius = random.real(80, 160);
            const Indenter sphere{
                radius,
                contact * contact / radius,
                {128 + random.real(0, 1), 128 + random.real(0, 1), double(kThickness)}};
            ElasticLevels levels(map, 46, false, arena);
            levels.focus(sphere.above);
            const double found = indent_un(levels, sphere);
            const double hertz = hertz_un(sphere, kThickness, nu);
            std::printf("nu %.2f, seed %d, contact %.1f: %.0f uN, by Hertz %.0f (%+.2f %%)\n", nu,
                        seed, contact, found, hertz, 100 * (found / hertz - 1));
            EXPECT_NEAR(found, hertz, 0.03 * hertz) << "nu " << nu << ", seed " << seed;
        }
    }
}

/// A bent bar, from research/results/elastic/cantilever.py.
struct Bent {
    double nu, force_un;
    Vec3d tip_mm;
};
constexpr Bent kBent[] = {{0.3, -2103.13, {-6.5359, 0, -32}}, {0.45, -2127.35, {-6.5466, 0, -32}}};

TEST(Truth, ACantileverBendsByThirtyDegrees) {
    const TaskArena arena(1);
    const Volume scan = scan_of({65, 9, 9}, {1.5, 1.5, 1.5}, [](Vec3i) { return kValue; });
    for (const Bent& bent : kBent) {
        auto settings = plain_settings(bent.nu);
        settings.held_sides = {"-x"};
        const StiffnessMap map(scan, settings, arena);
        ElasticLevels levels(map, 512, true, arena);
        std::vector<HeldNode> row;
        for (int j = 0; j < 9; ++j) row.push_back({{64, j, 4}, {}, Vec3d{0, 0, -1}});
        // The displacement along z under which the row has the reference's force.
        constexpr int kSteps = 10, kTrials = 4;
        double down = bent.tip_mm.z, force = 0;
        const auto solve_at = [&](double z, int starts) {
            for (HeldNode& node : row) node.displacement_mm = {0, 0, z};
            levels.hold(row);
            for (int n = 0; n < starts; ++n) {
                (void)levels.start();
                for (int k = 0; k < 4; ++k)
                    if (levels.iterate() == 0) break;
            }
        };
        for (int n = 1; n < kSteps; ++n) solve_at(down * n / kSteps, 2);
        for (int trial = 0; trial < kTrials; ++trial) {
            if (trial > 0) down *= bent.force_un / force;
            solve_at(down, 20);
            force = sum_along_z(levels, row);
        }
        EXPECT_NEAR(force, bent.force_un, 1e-3 * std::abs(bent.force_un));
        const Vec3d tip = displacement(levels, {64, 4, 4});
        const double error = norm(tip - bent.tip_mm) / norm(bent.tip_mm);
        std::printf("nu %.2f: tip (%.3f, %.3f) mm, expected (%.3f, %.3f): %.2f %%\n", bent.nu,
                    tip.x, tip.z, bent.tip_mm.x, bent.tip_mm.z, 100 * error);
        EXPECT_LT(error, 0.02);
    }
}

}  // namespace
}  // namespace pliant::test
