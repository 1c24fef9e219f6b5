// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One equilibrium, found in three ways, by any number of threads.
// Covers: fem/block_*.cpp, fem/cholesky.cpp, fem/elastic_solver.cpp, fem/held_nodes.cpp,
// fem/lattice_*.cpp.

#include "fem/solids.h"

#include <cstring>

#include "base/hash.h"
#include "fem/lattice_stiffness.h"

namespace pliant {
namespace {

using namespace test;

struct Instance {
    ElasticLattice solid;
    std::vector<Support> supports;
    ElasticLoads loads;
    ElasticSolid as_mesh() const {
        return {hex_mesh(solid.lattice), solid.materials, solid.material_of};
    }
};

/// Mixed materials, supports along some axes with given displacements, all kinds of loads.
Instance random_instance(std::uint64_t seed) {
    Random random(seed);
    Instance instance;
    HexLattice& l = instance.solid.lattice;
    l = {{random.whole(2, 21), random.whole(2, 9), random.whole(2, 19)},
         {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)},
         random.vector(5)};
    const bool uniform = random.whole(0, 2) == 0;
    for (int m = 0; m < (uniform ? 1 : 4); ++m)
        instance.solid.materials.push_back(
            {random.ratio(1e5, 1e6), random.real(0, 0.45), random.real(0, 2000)});
    if (!uniform)
        for (std::int64_t c = 0; c < cell_count(l); ++c)
            instance.solid.material_of.push_back(random.whole(0, 3));
    std::vector<bool> held(std::size_t(node_count(l)), false);
    const auto hold = [&](std::int32_t n, std::array<bool, 3> axes) {
        instance.supports.push_back({n, axes, random.vector(0.1)});
        held[std::size_t(n)] = true;
    };
    for (int j = 0; j < l.size.y; ++j)
        for (int i = 0; i < l.size.x; ++i) hold(node_index(l, {i, j, 0}), {true, true, true});
    hold(std::int32_t(node_count(l) - 1), {false, true, false});
    for (int n = 0; n < 4; ++n) {
        const int node = random.whole(0, int(node_count(l)) - 1);
        if (!held[std::size_t(node)]) instance.loads.forces.push_back({node, random.vector(0.05)});
        instance.loads.surfaces.push_back(
            {{random.whole(0, int(cell_count(l)) - 1), random.whole(0, 5)},
             random.vector(1000),
             random.real(-1000, 1000)});
    }
    instance.loads.gravity_m_per_s2 = random.vector(10);
    return instance;
}

ElasticSettings with(ElasticMethod method, double tolerance = 1e-11) {
    return {.method = method, .tolerance = tolerance};
}

TEST(Solvers, TheLatticeMultipliesAsTheAssembledMatrixDoes) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Instance instance = random_instance(seed);
        const auto iterate = with(ElasticMethod::ConjugateGradients);
        const auto a =
            value_of(ElasticSolver::create(instance.as_mesh(), instance.supports, iterate, arena));
        const auto b =
            value_of(ElasticSolver::create(instance.solid, instance.supports, iterate, arena));
        Random random(seed);
        std::vector<Vec3d> u(std::size_t(node_count(instance.solid.lattice)));
        for (Vec3d& v : u) v = random.vector(1);
        const auto fa = a.forces_n(u), fb = b.forces_n(u);
        EXPECT_LT(largest_difference(fa, fb), 1e-12 * largest(fa));
    }
}

TEST(Solvers, DiagonalBlocksOfTheLatticeAreThoseOfUnitDisplacements) {
    const TaskArena arena(1);
    const Instance instance = random_instance(2);
    const LatticeStiffness stiffness(instance.solid);
    const auto nodes = std::int32_t(node_count(instance.solid.lattice));
    Random random(5);
    for (int turn = 0; turn < 20; ++turn) {
        const auto node = std::int32_t(random.whole(0, nodes - 1));
        const Block3 block = stiffness.diagonal_block(node);
        for (int j = 0; j < 3; ++j) {
            NodeVector u(nodes), f(nodes);
            u.component(j)[node] = 1;
            stiffness.multiply(u, f, arena);
            for (int i = 0; i < 3; ++i)
                EXPECT_NEAR(block[std::size_t(3 * i + j)], f.component(i)[node],
                            1e-12 * block[std::size_t(4 * j)]);
        }
    }
}

TEST(Solvers, CholeskyAndConjugateGradientsFindTheSame) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Instance instance = random_instance(seed);
        const auto direct = value_of(ElasticSolver::create(instance.as_mesh(), instance.supports,
                                                           with(ElasticMethod::Cholesky), arena));
        const auto iterate = with(ElasticMethod::ConjugateGradients);
        const auto blocks =
            value_of(ElasticSolver::create(instance.as_mesh(), instance.supports, iterate, arena));
        const auto lattice =
            value_of(ElasticSolver::create(instance.solid, instance.supports, iterate, arena));
        const auto a = value_of(direct.solve(instance.loads));
        EXPECT_LT(a.relative_residual, 1e-11);
        EXPECT_EQ(a.iterations, 0);
        for (const Support& s : instance.supports)
            for (int axis = 0; axis < 3; ++axis)
                if (s.held[std::size_t(axis)]) {
                    EXPECT_EQ(a.displacement_mm[std::size_t(s.node)][axis],
                              s.displacement_mm[axis]);
                }
        for (const ElasticSolver* other : {&blocks, &lattice}) {
            const auto b = value_of(other->solve(instance.loads));
            EXPECT_GT(b.iterations, 0);
            EXPECT_LT(b.relative_residual, 1e-10);
            EXPECT_LT(largest_difference(a.displacement_mm, b.displacement_mm),
                      1e-8 * largest(a.displacement_mm));
            EXPECT_LT(largest_difference(a.reaction_n, b.reaction_n), 1e-8 * largest(a.reaction_n));
            EXPECT_NEAR(a.strain_energy_j, b.strain_energy_j, 1e-8 * a.strain_energy_j);
        }
    }
}

std::uint64_t hash_of(const ElasticSolution& solution) {
    Hash64 hash;
    hash.add(std::span<const Vec3d>(solution.displacement_mm));
    hash.add(std::span<const Vec3d>(solution.reaction_n));
    hash.add_word(std::uint64_t(solution.iterations));
    return hash.value();
}

TEST(Solvers, ThreadsDoNotChangeABit) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Instance instance = random_instance(seed);
        for (int kind = 0; kind < 3; ++kind) {
            const auto settings =
                with(kind == 0 ? ElasticMethod::Cholesky : ElasticMethod::ConjugateGradients);
            const auto hash_with = [&](int threads) {
                const TaskArena arena(threads);
                const auto solver =
                    kind == 2 ? value_of(ElasticSolver::create(instance.solid, instance.supports,
                                                               settings, arena))
                              : value_of(ElasticSolver::create(instance.as_mesh(),
                                                               instance.supports, settings, arena));
                return hash_of(value_of(solver.solve(instance.loads)));
            };
            const std::uint64_t expected = hash_with(1);
            EXPECT_EQ(hash_with(2), expected) << kind;
            EXPECT_EQ(hash_with(4), expected) << kind;
        }
    }
}

TEST(Solvers, VectorInstructionsDoNotChangeABit) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const int cells = random.whole(1, 40);
        const auto room = std::size_t(cells) + 1 + NodeVector::kRoom;
        const LatticeFactors factors =
            lattice_factors({random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)});
        std::vector<double> values(14 * room);
        for (double& v : values) v = random.real(-1, 1);
        std::vector<double> forces[2], workspace(lattice_row_workspace(cells));
        for (int kind = 0; kind < 2; ++kind) {
            forces[kind].assign(12 * room, 0.25);
            LatticeRow row{};
            for (int n = 0; n < 12; ++n) {
                row.displacement[n / 4][n % 4] = values.data() + std::size_t(n) * room;
                row.force[n / 4][n % 4] =
                    n % 4 == 3 ? nullptr : forces[kind].data() + std::size_t(n) * room;
            }
            row.lambda = values.data() + 12 * room;
            row.mu = values.data() + 13 * room;
            row.cells = cells;
            row.workspace = workspace.data();
            (kind == 0 ? add_lattice_row : add_lattice_row_plain)(factors, row);
        }
        EXPECT_EQ(std::memcmp(forces[0].data(), forces[1].data(), 12 * room * sizeof(double)), 0);
        for (std::size_t n = 0; n < 12; ++n)  // the padding of a row is unchanged
            EXPECT_EQ(forces[0][n * room + std::size_t(cells) + 1], 0.25);
    }
}

TEST(Solvers, WithoutLoadsNothingMoves) {
    const TaskArena arena(1);
    const auto solver = value_of(
        ElasticSolver::create(ElasticLattice{{{3, 3, 3}}, {{1e5, 0.3}}}, hold_all({0, 1, 4}),
                              with(ElasticMethod::ConjugateGradients), arena));
    const auto solution = value_of(solver.solve({}));
    EXPECT_EQ(largest(solution.displacement_mm), 0);
    EXPECT_EQ(largest(solution.reaction_n), 0);
    EXPECT_EQ(solution.iterations, 0);
}

TEST(Solvers, AllNodesHeldIsNoMoreThanAMultiplication) {
    const TaskArena arena(1);
    std::vector<Support> supports;
    for (std::int32_t n = 0; n < 8; ++n)
        supports.push_back({n, {true, true, true}, {0, 0, n / 8.}});
    for (const auto method : {ElasticMethod::Cholesky, ElasticMethod::ConjugateGradients}) {
        const auto solver = value_of(ElasticSolver::create(ElasticSolid{hex_mesh({}), {{1e5, 0.3}}},
                                                           supports, with(method), arena));
        const auto solution = value_of(solver.solve({.gravity_m_per_s2 = {0, 0, 1}}));
        const auto forces = solver.forces_n(solution.displacement_mm);
        EXPECT_EQ(largest_difference(solution.reaction_n, forces), 0);
        EXPECT_GT(largest(forces), 0);
    }
}

}  // namespace
}  // namespace pliant
