// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: fem/conjugate_gradients.cpp.

#include "fem/multigrid.h"

#include "fem/conjugate_gradients.h"
#include "fem/multigrid_transfer.h"
#include "fem/solids.h"

namespace pliant {
namespace {

using namespace test;

NodeVector random_vector(std::int64_t nodes, Random& random) {
    NodeVector v(nodes);
    for (std::size_t n = 0; n < std::size_t(nodes); ++n) v.set(n, random.vector(1));
    return v;
}

HexLattice random_lattice(Random& random) {
    return {{random.whole(2, 15), random.whole(2, 15), random.whole(2, 15)},
            {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)}};
}

TEST(Multigrid, GatheringIsTheTransposeOfInterpolation) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const HexLattice lattice = random_lattice(random);
        const LatticePair pair = coarsened(lattice, coarsening_factor(lattice));
        const NodeVector f = random_vector(node_count(pair.fine), random);
        const NodeVector c = random_vector(node_count(pair.coarse), random);
        NodeVector gathered(node_count(pair.coarse)), interpolated(node_count(pair.fine));
        gather_forces(pair, f, gathered, arena);
        add_interpolated(pair, c, interpolated, arena);
        const double expected = ordered_dot(f, interpolated, arena);
        EXPECT_NEAR(ordered_dot(gathered, c, arena), expected,
                    1e-12 * double(node_count(pair.fine)));
    }
}

TEST(Multigrid, InterpolationKeepsALinearField) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const HexLattice lattice = random_lattice(random);
        const LatticePair pair = coarsened(lattice, coarsening_factor(lattice));
        Mat3d gradient;
        for (Vec3d& column : gradient.columns) column = random.vector(1);
        NodeVector coarse(node_count(pair.coarse)), fine(node_count(pair.fine));
        for (std::int32_t n = 0; n < node_count(pair.coarse); ++n)
            coarse.set(std::size_t(n), gradient * node_position_mm(pair.coarse, n));
        add_interpolated(pair, coarse, fine, arena);
        for (std::int32_t n = 0; n < node_count(pair.fine); ++n)
            EXPECT_LT(norm(fine.at(std::size_t(n)) - gradient * node_position_mm(pair.fine, n)),
                      1e-12 * 100);
    }
}

TEST(Multigrid, OnlyAxesWithTheShortestSpacingAreHalved) {
    EXPECT_EQ(coarsening_factor({{9, 9, 9}, {1, 1.4, 1.6}}), (Vec3i{2, 2, 1}));
    EXPECT_EQ(coarsening_factor({{2, 9, 9}, {0.1, 1, 1}}), (Vec3i{1, 2, 2}));
    EXPECT_EQ(coarsening_factor({{2, 2, 2}}), (Vec3i{1, 1, 1}));
    const LatticePair pair = coarsened({{10, 9, 3}}, {2, 2, 2});
    EXPECT_EQ(pair.coarse.size, (Vec3i{6, 5, 2}));
    // The last coarse cell of nine has one fine one, and is half as stiff.
    const std::vector<double> ones(std::size_t(cell_count(pair.fine)), 1);
    const auto means = coarse_means(pair, ones);
    EXPECT_EQ(means[3], 1);
    EXPECT_EQ(means[4], 0.5);
}

TEST(Multigrid, TheCycleIsSymmetricAndPositive) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        ElasticLattice solid{random_lattice(random), {{1e5, 0.3}, {1e6, 0.45}}};
        for (std::int64_t c = 0; c < cell_count(solid.lattice); ++c)
            solid.material_of.push_back(random.whole(0, 1));
        const auto nodes = node_count(solid.lattice);
        const auto held = value_of(hold(
            SolidShape(solid.lattice),
            std::vector<Support>{{0}, {1}, {std::int32_t(nodes - 1)}, {std::int32_t(nodes / 2)}}));
        const LatticeStiffness stiffness(solid);
        const Multigrid multigrid(stiffness, held, solid.materials, arena);
        Multigrid::Work work(multigrid);
        NodeVector a = random_vector(nodes, random), b = random_vector(nodes, random);
        held.clear(a);
        held.clear(b);
        NodeVector ma(nodes), mb(nodes);
        multigrid.apply(a, ma, work, arena);
        multigrid.apply(b, mb, work, arena);
        const double ama = ordered_dot(a, ma, arena), bmb = ordered_dot(b, mb, arena);
        EXPECT_GT(ama, 0);
        EXPECT_NEAR(ordered_dot(a, mb, arena), ordered_dot(b, ma, arena),
                    1e-10 * std::sqrt(ama * bmb));
        EXPECT_EQ(norm(ma.at(0)), 0);
    }
}

TEST(Multigrid, IterationsHardlyGrowWithTheLattice) {
    const TaskArena arena(2);
    const auto iterations = [&](int side) {
        const HexLattice lattice{{side, side, side}};
        std::vector<Support> foot;
        for (int n = 0; n < side * side; ++n) foot.push_back({n});
        const auto solver = value_of(ElasticSolver::create(
            ElasticLattice{lattice, {{6e5, 0.45}}}, foot,
            {.method = ElasticMethod::ConjugateGradients, .tolerance = 1e-8}, arena));
        const int top = node_index(lattice, {side / 2, side / 2, side - 1});
        return value_of(solver.solve({.forces = {{top, {1, 0, -1}}}})).iterations;
    };
    const int small = iterations(12), large = iterations(34);
    RecordProperty("iterations_12", small);
    RecordProperty("iterations_34", large);
    EXPECT_LE(large, 2 * small);
    EXPECT_LE(large, 60);
}

}  // namespace
}  // namespace pliant
