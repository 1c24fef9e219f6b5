// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cantilevers, where trilinear elements lock and those with inner modes don't.

#include "fem/solids.h"

namespace pliant {
namespace {

using namespace test;

ElasticSolid beam(Vec3i cells, Vec3d size_mm, const ElasticMaterial& material) {
    return {hex_mesh({cells + Vec3i{1, 1, 1},
                      {size_mm.x / cells.x, size_mm.y / cells.y, size_mm.z / cells.z}}),
            {material}};
}

/// Mean way of the free end down, under a shear traction of 1 N in total on it.
double tip_mm(int across, HexElement element, const TaskArena& arena) {
    const Vec3d size{10, 10, 100};
    const ElasticSolid solid = beam({across, across, 10 * across}, size, {1e6, 0.3});
    const auto foot = nodes_where(solid.mesh, [](Vec3d x) { return x.z == 0; });
    const auto at_tip = [&](Vec3d x) { return std::abs(x.z - size.z) < 1e-9; };
    ElasticLoads loads;
    for (const HexFace& f : faces_where(solid.mesh, at_tip))
        loads.surfaces.push_back({f, {0, -1e4, 0}});
    const auto solver =
        value_of(ElasticSolver::create(solid, hold_all(foot), {.element = element}, arena));
    const auto solution = value_of(solver.solve(loads));
    EXPECT_NEAR(sum_of(solution.reaction_n).y, 1, 1e-9);
    double sum = 0;
    const auto tip = nodes_where(solid.mesh, at_tip);
    for (const std::int32_t n : tip) sum += solution.displacement_mm[std::size_t(n)].y;
    return -sum / double(tip.size());
}

TEST(Beams, ACantileverConvergesToTimoshenko) {
    const TaskArena arena(2);
    // P L³ / 3 E I + P L / κ G A with Cowper's κ of a rectangle.
    const double e = 1e6, nu = 0.3, length = 0.1, side = 0.01;
    const double inertia = side * side * side * side / 12, g = e / (2 * (1 + nu));
    const double kappa = 10 * (1 + nu) / (12 + 11 * nu);
    const double exact =
        1e3 * (length * length * length / (3 * e * inertia) + length / (kappa * g * side * side));
    const double error[3] = {1 - tip_mm(1, HexElement::Trilinear, arena) / exact,
                             1 - tip_mm(2, HexElement::Trilinear, arena) / exact,
                             1 - tip_mm(4, HexElement::Trilinear, arena) / exact};
    for (int n = 0; n < 3; ++n)
        RecordProperty("trilinear_" + std::to_string(n), std::to_string(error[n]));
    EXPECT_GT(error[0], 0.2);  // locks
    EXPECT_LT(error[1], error[0] / 2.5);
    EXPECT_LT(error[2], error[1] / 2.5);
    EXPECT_NEAR(tip_mm(2, HexElement::IncompatibleModes, arena) / exact, 1, 0.01);
    EXPECT_NEAR(tip_mm(4, HexElement::IncompatibleModes, arena) / exact, 1, 0.006);
}

TEST(Beams, TheCantileverOfPhysicsCaseFive) {
    // 20 × 20 × 200 mm under its own weight, on SOFA's grid of 5 × 5 × 30 nodes.
    const TaskArena arena(2);
    const ElasticSolid solid = beam({4, 4, 29}, {20, 20, 200}, {1e7, 0.3, 1100});
    const auto foot = nodes_where(solid.mesh, [](Vec3d x) { return x.z == 0; });
    const auto tip_of = [&](HexElement element) {
        const auto solver =
            value_of(ElasticSolver::create(solid, hold_all(foot), {.element = element}, arena));
        const auto solution = value_of(solver.solve({.gravity_m_per_s2 = {0, -9.81, 0}}));
        return -solution.displacement_mm.back().y;
    };
    constexpr double kExpected = 6.541;
    EXPECT_NEAR(tip_of(HexElement::IncompatibleModes), kExpected, 0.02 * kExpected);
    // What full integration costs on this grid, so that nobody is surprised.
    EXPECT_LT(tip_of(HexElement::Trilinear), 0.98 * kExpected);
    EXPECT_GT(tip_of(HexElement::Trilinear), 0.90 * kExpected);
}

}  // namespace
}  // namespace pliant
