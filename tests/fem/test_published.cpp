// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Boussinesq's half space, and the finite-element reference of [Choi2004, 4.3] as re-computed.
// Covers: fem/elastic_solver.cpp, fem/loads.cpp.

#include "fem/solids.h"

#include <numbers>

namespace pliant {
namespace {

using namespace test;

/// Displacement [mm] of a half space z ≥ 0 under 1 N along z at the origin; moduli in Pa,
/// positions in mm.
Vec3d boussinesq(Vec3d x, double mu, double nu) {
    const double r = norm(x), rho = std::hypot(x.x, x.y),
                 factor = 1e6 / (4 * std::numbers::pi * mu);
    const double radial =
        rho > 0 ? factor * (rho * x.z / (r * r * r) - (1 - 2 * nu) * rho / (r * (r + x.z))) / rho
                : 0;
    return {radial * x.x, radial * x.y, factor * (x.z * x.z / (r * r * r) + 2 * (1 - nu) / r)};
}

TEST(Published, BoussinesqsHalfSpace) {
    // A block whose buried sides have the half space's displacement; the load is on one node.
    const TaskArena arena(2);
    const double e = 6e5, nu = 0.45, mu = e / (2 * (1 + nu));
    constexpr int kHalf = 16;
    const HexLattice lattice{
        {2 * kHalf + 1, 2 * kHalf + 1, kHalf + 1}, {1, 1, 1}, {-double(kHalf), -double(kHalf), 0}};
    std::vector<Support> supports;
    for (std::int32_t n = 0; n < node_count(lattice); ++n) {
        const Vec3d x = node_position_mm(lattice, n);
        if (std::abs(x.x) == kHalf || std::abs(x.y) == kHalf || x.z == kHalf)
            supports.push_back({n, {true, true, true}, boussinesq(x, mu, nu)});
    }
    const auto solver =
        value_of(ElasticSolver::create(ElasticLattice{lattice, {{e, nu}}}, supports,
                                       {.method = ElasticMethod::ConjugateGradients}, arena));
    const auto at = [&](int x, int y, int z) {
        return node_index(lattice, {x + kHalf, y + kHalf, z});
    };
    const auto solution = value_of(solver.solve({.forces = {{at(0, 0, 0), {0, 0, 1}}}}));
    const auto way = [&](int x, int y, int z) {
        return solution.displacement_mm[std::size_t(at(x, y, z))];
    };
    // The load on one node is one that is spread over about a cell: an error of (h/r)².
    double worst[2] = {0, 0};  // from 4 h and from 8 h on
    for (int z = 0; z <= 12; ++z)
        for (int y = 0; y <= 12; ++y)
            for (int x = 0; x <= 12; ++x) {
                const int square = x * x + y * y + z * z;
                if (square < 16) continue;
                const Vec3d exact = boussinesq({double(x), double(y), double(z)}, mu, nu);
                const double error = norm(way(x, y, z) - exact) / norm(exact);
                worst[0] = std::max(worst[0], error);
                if (square >= 64) worst[1] = std::max(worst[1], error);
            }
    RecordProperty("worst_from_4h", std::to_string(worst[0]));
    RecordProperty("worst_from_8h", std::to_string(worst[1]));
    EXPECT_LT(worst[0], 0.06);
    EXPECT_LT(worst[1], 0.02);
    // u ∝ 1/r along the surface: relative to h, a quarter remains at 4 h, a tenth at 10 h.
    const double u_at_h = boussinesq({1, 0, 0}, mu, nu).z;
    EXPECT_NEAR(way(4, 0, 0).z / u_at_h, 0.25, 0.01);
    EXPECT_NEAR(way(10, 0, 0).z / u_at_h, 0.10, 0.004);
}

struct Elastin {
    HexLattice lattice{{10, 10, 10}, {100.0 / 9, 100.0 / 9, 100.0 / 9}};
    ElasticMaterial material{6e5, 0.45, 1040};
    std::vector<Support> supports{};
    std::vector<std::int32_t> pushed{};

    Elastin() {
        for (int j = 0; j < 10; ++j)
            for (int i = 0; i < 10; ++i) supports.push_back({node_index(lattice, {i, j, 0})});
        for (int j = 4; j < 6; ++j)
            for (int i = 4; i < 6; ++i) pushed.push_back(node_index(lattice, {i, j, 9}));
    }
    ElasticLoads loads(Vec3d total_n) const {
        ElasticLoads result;
        for (const std::int32_t n : pushed) result.forces.push_back({n, 0.25 * total_n});
        return result;
    }
};

TEST(Published, TheElastinCubeMovesAsInTheRecomputationOfChoi) {
    // References/physics.md, 3.2 and case 21: mean and greatest displacement, in % of the spacing.
    const TaskArena arena(2);
    const Elastin cube;
    const auto direct = value_of(ElasticSolver::create(
        ElasticSolid{hex_mesh(cube.lattice), {cube.material}}, cube.supports, {}, arena));
    const auto iterative =
        value_of(ElasticSolver::create(ElasticLattice{cube.lattice, {cube.material}}, cube.supports,
                                       {.method = ElasticMethod::ConjugateGradients}, arena));
    struct Case {
        Vec3d total_n;
        double mean, most;
    };
    const Case cases[] = {{{0, 0, -10}, 0.712, 5.87},
                          {{0, 0, -40}, 2.85, 23.5},
                          {{10, 0, 0}, 4.43, 15.1},
                          {{40, 0, 0}, 17.7, 60.4}};
    for (const Case& c : cases) {
        const auto a = value_of(direct.solve(cube.loads(c.total_n)));
        const auto b = value_of(iterative.solve(cube.loads(c.total_n)));
        EXPECT_LT(largest_difference(a.displacement_mm, b.displacement_mm),
                  1e-7 * largest(a.displacement_mm));
        double sum = 0;
        for (const Vec3d& u : a.displacement_mm) sum += norm(u);
        const double percent = 100 / cube.lattice.spacing_mm.x;
        EXPECT_NEAR(percent * sum / 1000, c.mean, 0.006 * c.mean);
        EXPECT_NEAR(percent * largest(a.displacement_mm), c.most, 0.006 * c.most);
    }
}

}  // namespace
}  // namespace pliant
