// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ranks/slabs.h"

#include "fem/multigrid_transfer.h"
#include "fem/solids.h"
#include "thread_ranks.h"

namespace pliant {
namespace {

using namespace test;

struct Problem {
    ElasticLattice solid;
    std::vector<Support> supports;
    ElasticLoads loads;
};

/// A lattice of several materials that is held at one end, partly with prescribed displacements.
Problem random_problem(Random& random, Vec3i size) {
    Problem p;
    p.solid.lattice = {size, {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)}};
    const HexLattice& lattice = p.solid.lattice;
    const int materials = random.whole(1, 3);
    for (int m = 0; m < materials; ++m)
        p.solid.materials.push_back({.young_modulus_pa = random.real(1e3, 1e5),
                                     .poisson_ratio = random.real(0.2, 0.45),
                                     .density_kg_per_m3 = 1000});
    if (materials > 1)
        for (std::int64_t c = 0; c < cell_count(lattice); ++c)
            p.solid.material_of.push_back(random.whole(0, materials - 1));
    const int axis = random.whole(0, 2);
    for (std::int32_t n = 0; n < node_count(lattice); ++n) {
        const Vec3i at{n % size.x, n / size.x % size.y, n / size.x / size.y};
        if (at[axis] == 0)
            p.supports.push_back({.node = n});
        else if (at[axis] == size[axis] - 1 && random.whole(0, 3) == 0)
            p.supports.push_back(
                {.node = n, .held = {true, false, true}, .displacement_mm = {0.2, 0, -0.1}});
        else if (random.whole(0, 50) == 0)
            p.loads.forces.push_back({n, random.vector(1e-3)});
    }
    p.loads.gravity_m_per_s2 = {0, 0, -9.81};
    return p;
}

Result<ElasticSolution> solve(const Problem& p, const TaskArena& arena, Ranks* ranks) {
    const ElasticSettings settings{.method = ElasticMethod::ConjugateGradients};
    if (ranks) {
        auto solver = RankedSolver::create(p.solid, p.supports, settings, arena, *ranks);
        if (!solver) return solver.error();
        return solver->solve(p.loads);
    }
    auto solver = ElasticSolver::create(p.solid, p.supports, settings, arena);
    if (!solver) return solver.error();
    return solver->solve(p.loads);
}

void expect_bits(const ElasticSolution& a, const ElasticSolution& b) {
    EXPECT_EQ(a.displacement_mm, b.displacement_mm);
    EXPECT_EQ(a.reaction_n, b.reaction_n);
    EXPECT_EQ(a.strain_energy_j, b.strain_energy_j);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.relative_residual, b.relative_residual);
}

TEST(Slabs, SolveToTheBitsOfOneProcess) {
    const TaskArena arena(1);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        // From planes of fewer nodes than a piece of a sum to planes of several.
        const Vec3i size{random.whole(8, 50), random.whole(8, 50), random.whole(12, 50)};
        const Problem p = random_problem(random, size);
        const auto expected = solve(p, arena, nullptr);
        ASSERT_TRUE(expected.ok()) << expected.error().message;
        EXPECT_GT(expected->iterations, 2);
        for (const int count : {1, 2, 3, 5}) {
            SCOPED_TRACE(std::to_string(count) + " ranks, " + std::to_string(size.x) + "×" +
                         std::to_string(size.y) + "×" + std::to_string(size.z));
            std::vector<std::unique_ptr<Result<ElasticSolution>>> found{std::size_t(count)};
            ThreadRanks(count).run([&](Ranks& ranks) {
                found[std::size_t(ranks.rank())] =
                    std::make_unique<Result<ElasticSolution>>(solve(p, arena, &ranks));
            });
            for (const auto& one : found) {
                ASSERT_TRUE(one->ok()) << one->error().message;
                expect_bits(**one, *expected);
            }
        }
    }
}

TEST(Slabs, ShareTheLatticeAndTwoOfItsLevels) {
    // Otherwise the test above would compare whole lattices.
    const HexLattice lattice{{40, 40, 41}};
    ThreadRanks(3).run([&](Ranks& ranks) {
        const Slabs slabs(lattice, &ranks);
        EXPECT_FALSE(slabs.is_whole());
        EXPECT_EQ(slabs.first(), (std::array{0, 13, 27}[std::size_t(ranks.rank())]));
        EXPECT_EQ(slabs.local().size.z, (std::array{14, 16, 15}[std::size_t(ranks.rank())]));
        const LatticePair pair = coarsened(lattice, {2, 2, 2});
        const Slabs coarse = slabs.coarse(pair.coarse, pair.factor);
        EXPECT_TRUE(coarse.are_thick());
        EXPECT_EQ(coarse.first(), (std::array{0, 7, 14}[std::size_t(ranks.rank())]));
        EXPECT_EQ(coarse.whole().size.z, 21);
    });
    ThreadRanks(20).run([&](Ranks& ranks) {
        EXPECT_FALSE(Slabs(lattice, &ranks).is_whole());
        EXPECT_TRUE(Slabs({{40, 40, 39}}, &ranks).is_whole()) << "slabs of one plane";
    });
}

TEST(Slabs, ForcesAreThoseOfOneProcess) {
    const TaskArena arena(1);
    Random random(7);
    const Problem p = random_problem(random, {18, 17, 30});
    std::vector<Vec3d> u;
    for (std::int64_t n = 0; n < node_count(p.solid.lattice); ++n) u.push_back(random.vector(1));
    const ElasticSettings settings{.method = ElasticMethod::ConjugateGradients};
    const auto alone = ElasticSolver::create(p.solid, p.supports, settings, arena);
    ASSERT_TRUE(alone.ok());
    const auto expected = alone->forces_n(u);
    ThreadRanks(3).run([&](Ranks& ranks) {
        const auto solver = RankedSolver::create(p.solid, p.supports, settings, arena, ranks);
        ASSERT_TRUE(solver.ok());
        EXPECT_EQ(solver->forces_n(u), expected);
    });
}

TEST(Slabs, AnExceptionOfTheRanksEndsTheSolve) {
    struct Lost : Ranks {
        int rank() const override { return 0; }
        int count() const override { return 2; }
        void exchange(std::span<const double>, std::span<const double>, std::span<double>,
                      std::span<double>) override {
            throw std::runtime_error("lost");
        }
        void gather(std::span<const double>, std::span<const std::size_t>,
                    std::span<double>) override {}
    } lost;
    const TaskArena arena(1);
    Random random(8);
    const Problem p = random_problem(random, {18, 17, 30});
    EXPECT_THROW((void)solve(p, arena, &lost), std::runtime_error);
}

}  // namespace
}  // namespace pliant
