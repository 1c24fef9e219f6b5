// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: fem/hex_element.cpp, fem/lattice_stiffness.cpp.

#include "fem/solids.h"

#include <set>

namespace pliant {
namespace {

using namespace test;

constexpr HexElement kElements[] = {HexElement::Trilinear, HexElement::IncompatibleModes};

std::set<std::int32_t> boundary_nodes(const HexMesh& mesh) {
    std::set<std::int32_t> nodes;
    for (const HexFace& f : boundary_faces(mesh))
        for (const int c : kHexFaceCorners[f.face])
            nodes.insert(mesh.cells[std::size_t(f.cell)][std::size_t(c)]);
    return nodes;
}

ElasticMaterial random_material(Random& random) {
    return {random.ratio(1e3, 1e9), random.real(-0.5, 0.49), 1000};
}

TEST(Elements, PatchTest) {
    // A linear displacement of the boundary extends linearly inside, for all shapes of elements.
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
        for (const HexElement element : kElements) {
            SCOPED_TRACE("seed " + std::to_string(seed));
            Random random(seed);
            ElasticSolid solid{distorted_block({4, 5, 4}, random), {random_material(random)}};
            Mat3d gradient{};
            for (Vec3d& column : gradient.columns) column = random.vector(0.1);
            std::vector<Vec3d> exact;
            for (const Vec3d& x : solid.mesh.nodes_mm)
                exact.push_back(gradient * x + Vec3d{1, -2, 3});
            std::vector<Support> supports;
            for (const std::int32_t n : boundary_nodes(solid.mesh))
                supports.push_back({.node = n, .displacement_mm = exact[std::size_t(n)]});
            const auto solver =
                value_of(ElasticSolver::create(solid, supports, {.element = element}, arena));
            const auto solution = value_of(solver.solve({}));
            EXPECT_LT(largest_difference(solution.displacement_mm, exact), 1e-10);
            const auto states =
                value_of(elastic_states(solid, solution.displacement_mm, element, arena));
            const double e = solid.materials[0].young_modulus_pa,
                         nu = solid.materials[0].poisson_ratio;
            const auto& c = gradient.columns;
            const double trace = c[0].x + c[1].y + c[2].z;
            const double xx = e / (1 + nu) * (c[0].x + nu / (1 - 2 * nu) * trace);
            for (const ElasticState& s : states) {
                EXPECT_NEAR(s.strain.yy, c[1].y, 1e-11);
                EXPECT_NEAR(s.strain.zx, (c[0].z + c[2].x) / 2, 1e-11);
                EXPECT_NEAR(s.stress_pa.xx, xx, 1e-9 * e / (1 - 2 * nu));
                EXPECT_NEAR(s.stress_pa.xy, e / (1 + nu) * (c[0].y + c[1].x) / 2, 1e-9 * e);
            }
        }
}

TEST(Elements, RigidMotionsNeedNoForce) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
        for (const HexElement element : kElements) {
            SCOPED_TRACE("seed " + std::to_string(seed));
            Random random(seed);
            const ElasticSolid solid{distorted_block({3, 4, 3}, random), {{1e6, 0.4}}};
            const auto solver = value_of(
                ElasticSolver::create(solid, hold_all({0, 1, 5, 20}), {.element = element}, arena));
            const Vec3d shift = random.vector(1), axis = random.vector(1);
            std::vector<Vec3d> moved, strained;
            for (const Vec3d& x : solid.mesh.nodes_mm) {
                moved.push_back(shift + cross(axis, x));
                strained.push_back(moved.back() + Vec3d{0.1 * x.y, 0, 0});
            }
            const double scale = largest(solver.forces_n(strained));
            EXPECT_GT(scale, 1e-3);
            EXPECT_LT(largest(solver.forces_n(moved)), 1e-12 * scale);
        }
}

TEST(Elements, TheStiffnessIsSymmetricAndPositive) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
        for (const HexElement element : kElements) {
            SCOPED_TRACE("seed " + std::to_string(seed));
            Random random(seed);
            const ElasticSolid solid{distorted_block({3, 3, 4}, random), {random_material(random)}};
            const auto solver = value_of(
                ElasticSolver::create(solid, hold_all({0, 1, 4, 20}), {.element = element}, arena));
            std::vector<Vec3d> a, b;
            for (std::size_t n = 0; n < solid.mesh.nodes_mm.size(); ++n) {
                a.push_back(random.vector(1));
                b.push_back(random.vector(1));
            }
            const auto ka = solver.forces_n(a), kb = solver.forces_n(b);
            double akb = 0, bka = 0, aka = 0;
            for (std::size_t n = 0; n < a.size(); ++n) {
                akb += dot(a[n], kb[n]);
                bka += dot(b[n], ka[n]);
                aka += dot(a[n], ka[n]);
            }
            EXPECT_NEAR(akb, bka, 1e-12 * aka);
            EXPECT_GT(aka, 0);
        }
}

TEST(Elements, InnerModesOnlyEverSoftenTheElement) {
    const TaskArena arena(1);
    Random random(3);
    const ElasticSolid solid{distorted_block({4, 4, 4}, random), {{1e6, 0.45}}};
    const auto held = hold_all({0, 1, 4, 20});
    const auto stiff =
        value_of(ElasticSolver::create(solid, held, {.element = kElements[0]}, arena));
    const auto soft =
        value_of(ElasticSolver::create(solid, held, {.element = kElements[1]}, arena));
    for (int turn = 0; turn < 20; ++turn) {
        std::vector<Vec3d> u;
        for (std::size_t n = 0; n < solid.mesh.nodes_mm.size(); ++n) u.push_back(random.vector(1));
        double energies[2] = {0, 0};
        const auto a = stiff.forces_n(u), b = soft.forces_n(u);
        for (std::size_t n = 0; n < u.size(); ++n) {
            energies[0] += dot(u[n], a[n]);
            energies[1] += dot(u[n], b[n]);
        }
        EXPECT_LT(energies[1], energies[0]);
        EXPECT_GT(energies[1], 0);
    }
}

TEST(Elements, VonMisesOfOneStressIsThatStress) {
    EXPECT_DOUBLE_EQ(von_mises({.xx = -7}), 7);
    EXPECT_NEAR(von_mises({.xx = 5, .yy = 5, .zz = 5}), 0, 1e-14);
    EXPECT_DOUBLE_EQ(von_mises({.yz = 2}), 2 * std::sqrt(3));
}

}  // namespace
}  // namespace pliant
