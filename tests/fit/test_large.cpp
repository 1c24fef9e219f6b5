// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Large networks: factored by nested dissection, against the simple factor of small ones and
// against the matrices themselves; and their references, by conjugate gradients against Cholesky.
// Covers: fit/dissected_cholesky.cpp, fit/linear_network.cpp, fit/motion.cpp.

#include <gtest/gtest.h>
#include <pliant/models/fit.h>

#include <array>
#include <cmath>

#include "fit/problem_impl.h"
#include "springs/random_networks.h"
#include "support/made.h"

namespace pliant::test {
namespace {

const TaskArena& two_threads() {
    static const TaskArena two(2);
    return two;
}

std::vector<FitGroup> groups_of(Random& random, const SpringParts& parts, bool with_all) {
    std::vector<FitGroup> groups(3);
    for (std::size_t l = 0; l < parts.links.size(); ++l)
        if (const int g = random.whole(with_all ? 0 : -1, 1); g >= 0)
            groups[std::size_t(g)].links.push_back(std::int32_t(l));
    for (std::size_t c = 0; c < parts.cells.size(); ++c) groups[2].cells.push_back(std::int32_t(c));
    return groups;
}

double norm_of(const std::vector<Vec3d>& v) {
    double sum = 0;
    for (const Vec3d& x : v) sum += dot(x, x);
    return std::sqrt(sum);
}
std::vector<Vec3d> minus(std::vector<Vec3d> a, const std::vector<Vec3d>& b) {
    for (std::size_t n = 0; n < a.size(); ++n) a[n] = a[n] - b[n];
    return a;
}

TEST(LargeNetworks, BothFactorsGiveTheSameDisplacementsOfRandomNetworks) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Vec3i size{random.whole(3, 9), random.whole(3, 9), random.whole(3, 9)};
        const SpringParts parts = random_block(random, size, 20, false);
        const auto groups = groups_of(random, parts, random.whole(0, 1) == 1);
        std::vector<std::uint8_t> held;
        for (const SpringNode& node : parts.nodes)
            held.push_back(node.fixed || random.whole(0, 9) == 0);
        const LinearNetwork simple(parts, groups, held), dissected(parts, groups, held, 0);
        for (int turn = 0; turn < 4; ++turn) {
            std::array<double, 3> values{};
            for (double& v : values) v = random.ratio(0.1, 10);
            if (turn == 3)  // as stiff as before all over, but for a factor
                for (double& v : values) v *= 7.3;
            std::vector<Vec3d> force(parts.nodes.size());
            for (Vec3d& f : force) f = random.vector(1);
            const auto a = simple.factor(values), b = dissected.factor(values);
            ASSERT_TRUE(a && b);
            const auto u = simple.solve(*a, force), v = dissected.solve(*b, force);
            EXPECT_LT(norm_of(minus(u, v)), 1e-11 * norm_of(u));
            for (std::size_t n = 0; n < held.size(); ++n)
                ASSERT_TRUE(!held[n] || v[n] == (Vec3d{0, 0, 0}));
            for (std::size_t g = 0; g < 3; ++g)
                EXPECT_LT(norm_of(minus(simple.multiply(g, u), dissected.multiply(g, u))),
                          1e-12 * norm_of(force));
        }
    }
}

TEST(LargeNetworks, TheDisplacementsAreAFunctionOfTheValuesWhateverWasAskedBefore) {
    Random random(5);
    const SpringParts parts = random_block(random, {6, 6, 5}, 20, false);
    const auto groups = groups_of(random, parts, true);
    std::vector<std::uint8_t> held;
    for (const SpringNode& node : parts.nodes) held.push_back(node.fixed);
    std::vector<Vec3d> force(parts.nodes.size());
    for (Vec3d& f : force) f = random.vector(1);
    for (const std::size_t most_simple : {std::size_t(0), std::size_t(1000)}) {
        const LinearNetwork network(parts, groups, held, most_simple);
        const auto at = [&](const LinearNetwork& n, std::array<double, 3> values) {
            return n.solve(*n.factor(values), force);
        };
        const std::array one{0.7, 1.3, 2.1}, other{2.0, 0.3, 1.0};
        const auto first = at(network, one);
        (void)at(network, other);
        (void)at(network, {1.4, 2.6, 4.2});  // twice as stiff
        EXPECT_EQ(at(network, one), first);
        EXPECT_EQ(at(LinearNetwork(parts, groups, held, most_simple), one), first);
    }
}

TEST(LargeNetworks, ALooseOneHasNoFactor) {
    auto parts = made(springs_of_lattice({.size = {9, 8, 7}, .links = LatticeLinks::Edges}));
    std::vector<FitGroup> groups(1);
    for (std::size_t l = 0; l < parts.links.size(); ++l) groups[0].links.push_back(std::int32_t(l));
    std::vector<std::uint8_t> held;
    for (const SpringNode& node : parts.nodes) held.push_back(node.rest.z == 0);
    EXPECT_EQ(LinearNetwork(parts, groups, held, 0).factor(std::array{1.0}), nullptr);
    // One node that hangs on nothing.
    parts = made(springs_of_lattice({.size = {9, 8, 7}}));
    std::erase_if(parts.links, [](const SpringLink& l) { return l.a == 300 || l.b == 300; });
    groups[0].links.resize(parts.links.size());
    for (std::size_t l = 0; l < parts.links.size(); ++l) groups[0].links[l] = std::int32_t(l);
    EXPECT_EQ(LinearNetwork(parts, groups, held, 0).factor(std::array{1.0}), nullptr);
}

/// 8000 nodes: forces balance, by the matrices and not by their factor; and the fit is at a
/// minimum.
TEST(LargeNetworks, TwentyNodesAlongEachEdgeAreFittedAndInEquilibrium) {
    const auto box = made(fit_box({.size = {20, 20, 20},
                                   .spacing_mm = {5, 5, 5},
                                   .loads = {{.name = "press", .force_n = {3, 1, -40}}},
                                   .groups = FitBoxGroups::Kinds,
                                   .volume_energy = true,
                                   .shared_by_cells = true},
                                  two_threads()));
    const auto found = made(fit(box.problem, GaussNewton{}, two_threads()));
    const auto& impl = box.problem.impl();
    const auto u = made(box.problem.displacements(found.values, 0));
    std::vector<Vec3d> left = impl.force_of(impl.cases[0]);
    const double size = norm_of(left);
    for (std::size_t g = 0; g < found.values.size(); ++g) {
        const auto inner = impl.linear[0].multiply(g, u);
        for (std::size_t n = 0; n < left.size(); ++n)
            left[n] = left[n] - found.values[g] * inner[n];
    }
    EXPECT_LT(norm_of(left), 1e-10 * size);
    for (std::size_t g = 0; g < found.values.size(); ++g)
        for (const double factor : {0.97, 1.03}) {
            auto beside = found.values;
            beside[g] *= factor;
            EXPECT_GT(made(box.problem.evaluate(beside)).cost, found.at.cost) << g << ' ' << factor;
        }
}

TEST(LargeNetworks, TheirReferenceIsThatOfCholesky) {
    for (const HexElement element : {HexElement::Trilinear, HexElement::IncompatibleModes}) {
        const FitBox box{.size = {6, 7, 50},
                         .spacing_mm = {2, 3, 2.5},
                         .element = element,
                         .loads = {{.name = "draw", .force_n = {0.2, 0.1, 1}}}};
        const auto large = made(fit_box(box, two_threads()));
        const HexLattice lattice{box.size, box.spacing_mm};
        std::vector<Support> supports;
        for (int n = 0; n < 6 * 7; ++n) supports.push_back({.node = n});
        const auto solver = made(ElasticSolver::create(
            ElasticSolid{hex_mesh(lattice), {{box.young_modulus_pa, box.poisson_ratio}}}, supports,
            {.element = element}, two_threads()));
        const FitCase& fit_case = large.problem.cases()[0];
        ElasticLoads loads;
        for (std::size_t n = 0; n < fit_case.nodes.size(); ++n)
            loads.forces.push_back({fit_case.nodes[n], fit_case.forces[n]});
        auto expected = made(solver.solve(loads)).displacement_mm;
        for (Vec3d& u : expected) u = 1e-3 * u;
        EXPECT_LT(norm_of(minus(expected, fit_case.target)), 1e-8 * norm_of(expected));
    }
}

}  // namespace
}  // namespace pliant::test
