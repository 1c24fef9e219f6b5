// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cantilevers, where trilinear elements lock and those with inner modes don't.
// Covers: fem/hex_element.cpp.

#include <array>
#include <string>

#include "fem/solids.h"

namespace pliant {
namespace {

using namespace test;

ElasticSolid beam(Vec3i cells, Vec3d size_mm, const ElasticMaterial& material) {
    return {hex_mesh({cells + Vec3i{1, 1, 1},
                      {size_mm.x / cells.x, size_mm.y / cells.y, size_mm.z / cells.z}}),
            {material}};
}

/// Mean downward displacement of the free end under a total shear traction of 1 N. At its foot the
/// beam can't tilt, but may change its width; a traction there bears the load. So it bends like
/// Timoshenko's beam, whose cross-sections are not clamped.
double tip_mm(int across, HexElement element, const TaskArena& arena) {
    const Vec3d size{10, 10, 100};
    const ElasticSolid solid = beam({across, across, 10 * across}, size, {1e6, 0.3});
    const auto at_foot = [&](Vec3d x) { return x.z == 0; };
    const auto at_tip = [&](Vec3d x) { return std::abs(x.z - size.z) < 1e-9; };
    std::vector<Support> supports = {{0}, {across, {false, true, false}}};
    for (const std::int32_t n : nodes_where(solid.mesh, at_foot))
        supports.push_back({n, {false, false, true}});
    ElasticLoads loads;
    for (const HexFace& f : faces_where(solid.mesh, at_tip))
        loads.surfaces.push_back({f, {0, -1e4, 0}});
    for (const HexFace& f : faces_where(solid.mesh, at_foot))
        loads.surfaces.push_back({f, {0, 1e4, 0}});
    const auto solver =
        value_of(ElasticSolver::create(solid, supports, {.element = element}, arena));
    const auto solution = value_of(solver.solve(loads));
    const auto mean_way = [&](auto&& where) {
        double sum = 0;
        const auto nodes = nodes_where(solid.mesh, where);
        for (const std::int32_t n : nodes) sum += solution.displacement_mm[std::size_t(n)].y;
        return sum / double(nodes.size());
    };
    return mean_way(at_foot) - mean_way(at_tip);
}

TEST(Beams, ACantileverConvergesToTimoshenko) {
    const TaskArena arena(2);
    // P L³ / 3 E I + P L / κ G A, with κ of a rectangle [Cowper1966].
    const double e = 1e6, nu = 0.3, length = 0.1, side = 0.01;
    const double inertia = side * side * side * side / 12, g = e / (2 * (1 + nu));
    const double kappa = 10 * (1 + nu) / (12 + 11 * nu);
    const double exact =
        1e3 * (length * length * length / (3 * e * inertia) + length / (kappa * g * side * side));
    double locked[3], error[3];
    for (int n = 0; n < 3; ++n) {
        locked[n] = 1 - tip_mm(1 << n, HexElement::Trilinear, arena) / exact;
        error[n] = 1 - tip_mm(1 << n, HexElement::IncompatibleModes, arena) / exact;
        RecordProperty("trilinear_" + std::to_string(1 << n), std::to_string(locked[n]));
        RecordProperty("incompatible_" + std::to_string(1 << n), std::to_string(error[n]));
    }
    EXPECT_GT(locked[0], 0.2);
    EXPECT_LT(locked[1], locked[0] / 2.5);
    EXPECT_LT(locked[2], locked[1] / 2.5);
    EXPECT_LT(std::abs(error[0]), 0.02);
    EXPECT_LT(std::abs(error[1]), 0.005);
    EXPECT_LT(std::abs(error[2]), 0.0025);
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
    const double good = tip_of(HexElement::IncompatibleModes);
    const double locked = tip_of(HexElement::Trilinear);
    RecordProperty("incompatible_mm", std::to_string(good));
    RecordProperty("trilinear_mm", std::to_string(locked));
    EXPECT_NEAR(good, kExpected, 0.02 * kExpected);
    // Documents the locking of full integration on this grid.
    EXPECT_LT(locked, 0.98 * kExpected);
    EXPECT_GT(locked, 0.90 * kExpected);
}

}  // namespace
}  // namespace pliant
