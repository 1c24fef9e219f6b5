// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Solids with closed-form solutions.
// Covers: fem/hex_element.cpp.

#include "fem/solids.h"

#include <numbers>

namespace pliant {
namespace {

using namespace test;

TEST(Analytic, ABlockInTension) {
    const TaskArena arena(2);
    const double e = 6e5, nu = 0.45, stress = 1000;
    ElasticSolid solid{hex_mesh({{6, 4, 5}, {2, 3, 1.5}}), {{e, nu}}};
    std::vector<Support> supports;
    for (std::size_t n = 0; n < solid.mesh.nodes_mm.size(); ++n) {
        const Vec3d x = solid.mesh.nodes_mm[n];
        supports.push_back({std::int32_t(n), {x.x == 0, x.y == 0, x.z == 0}});
    }
    ElasticLoads loads;
    for (const HexFace& f : faces_where(solid.mesh, [](Vec3d x) { return x.x == 10; }))
        loads.surfaces.push_back({f, {stress, 0, 0}});
    const auto solver = value_of(ElasticSolver::create(solid, supports, {}, arena));
    const auto solution = value_of(solver.solve(loads));
    std::vector<Vec3d> exact;
    for (const Vec3d& x : solid.mesh.nodes_mm)
        exact.push_back((stress / e) * Vec3d{x.x, -nu * x.y, -nu * x.z});
    EXPECT_LT(largest_difference(solution.displacement_mm, exact), 1e-12);
    const double area_m2 = 9e-3 * 6e-3;
    EXPECT_NEAR(sum_of(solution.reaction_n).x, -stress * area_m2, 1e-12);
    EXPECT_NEAR(solution.strain_energy_j, stress * stress / (2 * e) * area_m2 * 10e-3, 1e-15);
    const auto states =
        value_of(elastic_states(solid, solution.displacement_mm, HexElement::Trilinear, arena));
    ASSERT_EQ(states.size(), 8 * solid.mesh.cells.size());
    for (const ElasticState& s : states) {
        EXPECT_NEAR(s.stress_pa.xx, stress, 1e-8);
        EXPECT_NEAR(s.stress_pa.yy, 0, 1e-8);
        EXPECT_NEAR(von_mises(s.stress_pa), stress, 1e-8);
    }
}

TEST(Analytic, ABlockInPureShearNeedsNoReaction) {
    const TaskArena arena(1);
    const double e = 2e6, nu = 0.3, stress = 500, mu = e / (2 * (1 + nu));
    const auto [mesh, loads, supports] = sheared_block(stress);
    const auto solver = value_of(ElasticSolver::create({mesh, {{e, nu}}}, supports, {}, arena));
    const auto solution = value_of(solver.solve(loads));
    std::vector<Vec3d> exact;
    for (const Vec3d& x : mesh.nodes_mm) exact.push_back({stress / mu * x.y, 0, 0});
    EXPECT_LT(largest_difference(solution.displacement_mm, exact), 1e-12);
    EXPECT_LT(largest(solution.reaction_n), 1e-12);
}

/// A quarter of a tube about z, as physics.md's case 11 has it. @returns the inner wall's way [mm]
double inner_wall(int cells, bool plane_strain, HexElement element, const TaskArena& arena) {
    constexpr double kInner = 2, kOuter = 3;
    const double height = 0.5;
    HexMesh mesh = hex_mesh({{cells + 1, 3 * cells + 1, 2}});
    for (Vec3d& x : mesh.nodes_mm) {
        const double radius = kInner + (kOuter - kInner) * x.x / cells;
        const double angle = std::numbers::pi / 2 * x.y / (3 * cells);
        x = {radius * std::cos(angle), radius * std::sin(angle), height * x.z};
    }
    std::vector<Support> supports;
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
        const Vec3d x = mesh.nodes_mm[n];
        supports.push_back(
            {std::int32_t(n),
             {std::abs(x.x) < 1e-9, std::abs(x.y) < 1e-9, plane_strain || x.z == 0}});
    }
    ElasticLoads loads;
    const auto inside = [&](Vec3d x) { return std::hypot(x.x, x.y) < kInner + 1e-9; };
    for (const HexFace& f : faces_where(mesh, inside))
        loads.surfaces.push_back({.face = f, .pressure_pa = 13332});
    const auto solver = value_of(
        ElasticSolver::create({mesh, {{6e5, 0.45}}}, supports, {.element = element}, arena));
    const auto solution = value_of(solver.solve(loads));
    return solution.displacement_mm[0].x;
}

TEST(Analytic, LamesTubeUnderPressure) {
    const TaskArena arena(2);
    for (const HexElement element : {HexElement::Trilinear, HexElement::IncompatibleModes}) {
        EXPECT_NEAR(inner_wall(6, true, element, arena), 0.1211, 0.02 * 0.1211);
        EXPECT_NEAR(inner_wall(6, false, element, arena), 0.1355, 0.02 * 0.1355);
    }
    EXPECT_NEAR(inner_wall(12, true, HexElement::IncompatibleModes, arena), 0.1211, 0.0004);
}

TEST(Analytic, AColumnUnderItsOwnWeight) {
    // ν = 0: u_z = −ρ g (L z − z²/2) / E, which the elements have exactly at the nodes.
    const TaskArena arena(1);
    ElasticSolid solid{hex_mesh({{3, 3, 9}, {1, 1, 2.5}}), {{1e4, 0, 1100}}};
    const auto foot = nodes_where(solid.mesh, [](Vec3d x) { return x.z == 0; });
    const auto solver = value_of(ElasticSolver::create(solid, hold_all(foot), {}, arena));
    const auto solution = value_of(solver.solve({.gravity_m_per_s2 = {0, 0, -9.81}}));
    for (std::size_t n = 0; n < solid.mesh.nodes_mm.size(); ++n) {
        const double z = solid.mesh.nodes_mm[n].z * 1e-3, length = 20e-3;
        EXPECT_NEAR(solution.displacement_mm[n].z,
                    -1e3 * 1100 * 9.81 * (length * z - z * z / 2) / 1e4, 1e-12);
    }
    EXPECT_NEAR(sum_of(solution.reaction_n).z, 1100 * 9.81 * 2e-3 * 2e-3 * 20e-3, 1e-12);
}

TEST(Analytic, WorkOfTheLoadsIsTwiceTheStrainEnergy) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const HexMesh mesh = distorted_block({4, 4, 4}, random);
        ElasticLoads loads;
        for (std::int32_t n = 30; n < 60; n += 7) loads.forces.push_back({n, random.vector(1)});
        const auto solver = value_of(
            ElasticSolver::create({mesh, {{1e6, 0.4}}}, hold_all({0, 1, 5, 16}), {}, arena));
        const auto solution = value_of(solver.solve(loads));
        double work = 0;
        Vec3d pushed{0, 0, 0}, turned{0, 0, 0};
        for (const NodalForce& f : loads.forces) {
            const auto n = std::size_t(f.node);
            work += 1e-3 * dot(f.force_n, solution.displacement_mm[n]);
            pushed = pushed + f.force_n;
            turned = turned + cross(mesh.nodes_mm[n], f.force_n);
        }
        EXPECT_NEAR(work, 2 * solution.strain_energy_j, 1e-10 * work);
        // Forces and moments of loads and reactions are in balance.
        EXPECT_LT(norm(pushed + sum_of(solution.reaction_n)), 1e-9);
        for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
            turned = turned + cross(mesh.nodes_mm[n], solution.reaction_n[n]);
        EXPECT_LT(norm(turned), 1e-9);
    }
}

}  // namespace
}  // namespace pliant
