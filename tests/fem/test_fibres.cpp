// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transversely isotropic solids [Choi2004, Eq. 3].
// Covers: fem/hex_element.cpp.

#include "fem/solids.h"

namespace pliant {
namespace {

using namespace test;

/// Five constants in the order of moduli along, across, shear.
ElasticMaterial fibres_along(Vec3d fibre) {
    return {.young_modulus_pa = 4e5,
            .poisson_ratio = 0.35,
            .fibre = fibre,
            .fibre_young_modulus_pa = 3e6,
            .fibre_poisson_ratio = 0.45,
            .fibre_shear_modulus_pa = 2.5e5};
}

Vec3d axis(int n) {
    Vec3d a{0, 0, 0};
    a[n] = 1;
    return a;
}

TEST(Fibres, ABlockInTensionAlongAndAcrossThem) {
    const TaskArena arena(2);
    const double stress = 1000;
    const HexMesh mesh = hex_mesh({{4, 4, 4}, {2, 2, 2}});
    std::vector<Support> supports;
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
        const Vec3d x = mesh.nodes_mm[n];
        supports.push_back({std::int32_t(n), {x.x == 0, x.y == 0, x.z == 0}});
    }
    for (const HexElement element : {HexElement::Trilinear, HexElement::IncompatibleModes})
        for (int fibre = 0; fibre < 3; ++fibre)
            for (int pulled = 0; pulled < 3; ++pulled) {
                const ElasticMaterial m = fibres_along(2.5 * axis(fibre));
                ElasticLoads loads;
                for (const HexFace& f : faces_where(mesh, [&](Vec3d x) { return x[pulled] == 6; }))
                    loads.surfaces.push_back({f, stress * axis(pulled)});
                const auto solver = value_of(
                    ElasticSolver::create({mesh, {m}}, supports, {.element = element}, arena));
                const auto solution = value_of(solver.solve(loads));
                // Strains along the axes, from the compliance.
                Vec3d strain;
                for (int a = 0; a < 3; ++a)
                    strain[a] =
                        stress * (pulled == fibre ? (a == fibre ? 1 : -m.fibre_poisson_ratio) /
                                                        m.fibre_young_modulus_pa
                                  : a == fibre  ? -m.fibre_poisson_ratio / m.fibre_young_modulus_pa
                                  : a == pulled ? 1 / m.young_modulus_pa
                                                : -m.poisson_ratio / m.young_modulus_pa);
                std::vector<Vec3d> exact;
                for (const Vec3d& x : mesh.nodes_mm)
                    exact.push_back({strain.x * x.x, strain.y * x.y, strain.z * x.z});
                EXPECT_LT(largest_difference(solution.displacement_mm, exact), 1e-12)
                    << fibre << pulled;
                for (const ElasticState& s : value_of(
                         elastic_states({mesh, {m}}, solution.displacement_mm, element, arena)))
                    EXPECT_NEAR(von_mises(s.stress_pa), stress, 1e-7);
            }
}

TEST(Fibres, ABlockInShearAlongAndAcrossThem) {
    const TaskArena arena(1);
    const double stress = 500;
    const auto [mesh, loads, supports] = sheared_block(stress);
    for (int fibre = 0; fibre < 3; ++fibre) {
        const ElasticMaterial m = fibres_along(axis(fibre));
        const double shear = fibre == 2 ? m.young_modulus_pa / (2 * (1 + m.poisson_ratio))
                                        : m.fibre_shear_modulus_pa;
        const auto solver = value_of(ElasticSolver::create({mesh, {m}}, supports, {}, arena));
        const auto solution = value_of(solver.solve(loads));
        std::vector<Vec3d> exact;
        for (const Vec3d& x : mesh.nodes_mm) exact.push_back({stress / shear * x.y, 0, 0});
        EXPECT_LT(largest_difference(solution.displacement_mm, exact), 1e-12) << fibre;
        EXPECT_LT(largest(solution.reaction_n), 1e-12);
    }
}

TEST(Fibres, TurnWithTheSolid) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
        for (const HexElement element : {HexElement::Trilinear, HexElement::IncompatibleModes}) {
            SCOPED_TRACE(seed);
            Random random(seed);
            const HexMesh mesh = distorted_block({3, 4, 3}, random);
            HexMesh turned = mesh;
            const Mat3d turn = random.rotation(false);
            const Vec3d fibre = random.vector(3);
            std::vector<Vec3d> moved, moved_turned;
            for (Vec3d& x : turned.nodes_mm) {
                x = turn * x;
                moved.push_back(random.vector(0.1));
                moved_turned.push_back(turn * moved.back());
            }
            const std::vector<Support> foot = hold_all({0, 1, 2, 3, 4, 5});
            const auto forces = [&](const HexMesh& m, Vec3d f, const std::vector<Vec3d>& u) {
                return value_of(ElasticSolver::create({m, {fibres_along(f)}}, foot,
                                                      {.element = element}, arena))
                    .forces_n(u);
            };
            std::vector<Vec3d> expected = forces(mesh, fibre, moved);
            for (Vec3d& f : expected) f = turn * f;
            EXPECT_LT(largest_difference(forces(turned, turn * fibre, moved_turned), expected),
                      1e-12 * largest(expected));
        }
}

TEST(Fibres, OfEqualConstantsAreAnIsotropicSolid) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
        for (const HexElement element : {HexElement::Trilinear, HexElement::IncompatibleModes}) {
            SCOPED_TRACE(seed);
            Random random(seed);
            const HexMesh mesh = distorted_block({3, 4, 3}, random);
            const double e = random.ratio(1e3, 1e6), nu = random.real(-0.4, 0.45);
            std::vector<Vec3d> moved;
            for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
                moved.push_back(random.vector(0.1));
            const std::vector<Support> foot = hold_all({0, 1, 2, 3, 4, 5});
            const auto forces = [&](const ElasticMaterial& m) {
                return value_of(
                           ElasticSolver::create({mesh, {m}}, foot, {.element = element}, arena))
                    .forces_n(moved);
            };
            const auto expected = forces({e, nu});
            const auto found = forces({.young_modulus_pa = e,
                                       .poisson_ratio = nu,
                                       .fibre = random.vector(1),
                                       .fibre_young_modulus_pa = e,
                                       .fibre_poisson_ratio = nu,
                                       .fibre_shear_modulus_pa = e / (2 * (1 + nu))});
            EXPECT_LT(largest_difference(found, expected), 1e-11 * largest(expected));
        }
}

TEST(Fibres, ConstantsWithoutAPositiveEnergyAreRefused) {
    const TaskArena arena(1);
    const HexMesh mesh = hex_mesh({{2, 2, 2}});
    const std::vector<Support> foot = hold_all({0, 1, 2, 3});
    const auto complaint = [&](const ElasticMaterial& m) {
        const auto solver = ElasticSolver::create({mesh, {m}}, foot, {}, arena);
        return solver.ok() ? std::string() : solver.error().message;
    };
    ElasticMaterial m = fibres_along({1, 2, 3});
    EXPECT_EQ(complaint(m), "");
    m.poisson_ratio = 1;
    EXPECT_EQ(complaint(m),
              "materials[0]: poisson_ratio is 1, expected a number above -1 and below 1");
    m = fibres_along({1, 2, 3});
    m.fibre_young_modulus_pa = 0;
    EXPECT_EQ(complaint(m),
              "materials[0]: fibre_young_modulus_pa is 0, expected a modulus above 0");
    m = fibres_along({1, 2, 3});
    m.fibre_shear_modulus_pa = -1;
    EXPECT_EQ(complaint(m),
              "materials[0]: fibre_shear_modulus_pa is -1, expected a modulus above 0");
    // 2 ν_a² E/E_a < 1 − ν: at the limit the stiffness is singular.
    m = fibres_along({1, 2, 3});
    const double limit =
        std::sqrt((1 - m.poisson_ratio) * m.fibre_young_modulus_pa / (2 * m.young_modulus_pa));
    m.fibre_poisson_ratio = 1.0001 * limit;
    EXPECT_NE(complaint(m).find("above which the energy is not positive"), std::string::npos);
    for (const double ratio : {0.9999 * limit, -0.9999 * limit}) {
        m.fibre_poisson_ratio = ratio;
        EXPECT_EQ(complaint(m), "");
        const auto solver = value_of(ElasticSolver::create({mesh, {m}}, foot, {}, arena));
        Random random(7);
        for (int n = 0; n < 200; ++n) {
            Mat3d gradient{};
            for (Vec3d& column : gradient.columns) column = random.vector(1);
            std::vector<Vec3d> moved;
            for (const Vec3d& x : mesh.nodes_mm) moved.push_back(gradient * x);
            const auto forces = solver.forces_n(moved);
            double work = 0;
            for (std::size_t k = 0; k < moved.size(); ++k) work += dot(forces[k], moved[k]);
            EXPECT_GT(work, 0);
        }
    }
    m.fibre = {std::nan(""), 0, 0};
    EXPECT_EQ(complaint(m), "materials[0]: fibre: expected three numbers");
    const auto lattice =
        ElasticSolver::create(ElasticLattice{{{2, 2, 2}}, {fibres_along({1, 0, 0})}}, foot,
                              {.method = ElasticMethod::ConjugateGradients}, arena);
    ASSERT_FALSE(lattice.ok());
    EXPECT_EQ(lattice.error().message,
              "materials[0]: has fibres, expected an isotropic material in a lattice");
}

}  // namespace
}  // namespace pliant
