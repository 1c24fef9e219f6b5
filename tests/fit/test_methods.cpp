// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Displacements and derivatives against alternative computations, and methods against problems with
// known solutions.
// Covers: fit/annealing.cpp, fit/gauss_newton.cpp, fit/problem.cpp, fit/search.cpp.

#include <gtest/gtest.h>
#include <pliant/models/fit.h>

#include <array>
#include <cmath>
#include <cstring>

#include "fit/problem_impl.h"
#include "springs/random_networks.h"

namespace pliant::test {
namespace {

const TaskArena& arena() {
    static const TaskArena two(2);
    return two;
}

template <class T>
T value_of(Result<T> result) {
    if (!result.ok()) throw std::runtime_error(result.error().message);
    return std::move(result).value();
}

/// A random block with links in two groups and cells in a third, under two loads on its top.
/// Targets are those of the network at known values, plus noise.
struct Planted {
    SpringParts parts;
    std::vector<FitGroup> groups;
    std::vector<FitCase> cases;
    std::vector<double> truth;

    Planted(Random& random, double noise, double force = 1e-3) {
        parts = random_block(random, {5, 5, 4}, 20, false);
        groups.resize(3);
        for (std::size_t l = 0; l < parts.links.size(); ++l)
            groups[std::size_t(random.whole(0, 1))].links.push_back(std::int32_t(l));
        for (std::size_t c = 0; c < parts.cells.size(); ++c)
            groups[2].cells.push_back(std::int32_t(c));
        for (std::size_t g = 0; g < 3; ++g) {
            truth.push_back(random.ratio(0.5, 2));
            groups[g].name = "group " + std::to_string(g);
            groups[g].start = random.ratio(0.5, 2);
            groups[g].low = 0.1;
            groups[g].high = 10;
        }
        for (int c = 0; c < 2; ++c) {
            FitCase one{.name = "case " + std::to_string(c), .nodes = {87, 92 + c}};
            for (int n = 0; n < 2; ++n) one.forces.push_back(random.vector(force));
            one.target.assign(parts.nodes.size(), Vec3d{0, 0, 0});
            cases.push_back(one);
        }
        const auto problem = value_of(FitProblem::create(parts, groups, cases, {}));
        for (std::size_t c = 0; c < 2; ++c) {
            cases[c].target = value_of(problem.displacements(truth, c));
            double most = 0;
            for (const Vec3d u : cases[c].target) most = std::max(most, norm(u));
            for (Vec3d& u : cases[c].target) u = u + random.vector(noise * most);
        }
    }
    FitProblem problem(const FitSettings& settings) const {
        return value_of(FitProblem::create(parts, groups, cases, settings));
    }
};

double largest_difference(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double most = 0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, norm(a[n] - b[n]));
    return most;
}
double largest(const std::vector<Vec3d>& a) {
    return largest_difference(a, std::vector<Vec3d>(a.size(), Vec3d{0, 0, 0}));
}

TEST(Motion, LinearAndEquilibriumAgreeForSmallLoadsAndNotForLargeOnes) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        for (const double force : {1e-5, 3.0}) {
            const Planted planted(random, 0, force);
            const auto linear = planted.problem({});
            const auto balanced = planted.problem({.motion = FitMotion::Equilibrium});
            const auto a = value_of(linear.displacements(planted.truth, 0));
            const auto b = value_of(balanced.displacements(planted.truth, 0));
            const double apart = largest_difference(a, b) / largest(a);
            if (force < 1) {
                EXPECT_LT(apart, 1e-4);
            } else {
                EXPECT_GT(apart, 1e-2);
            }
        }
    }
}

TEST(Motion, ARunEndsInTheEquilibrium) {
    Random random(7);
    const Planted planted(random, 0);
    SpringParts damped = planted.parts;
    for (SpringNode& node : damped.nodes) node.damping = 3;
    const auto run = value_of(
        FitProblem::create(damped, planted.groups, planted.cases,
                           {.motion = FitMotion::Run, .run = {.depth = 20}, .duration = 60}));
    const auto rest = planted.problem({.motion = FitMotion::Equilibrium});
    const auto a = value_of(run.displacements(planted.truth, 1));
    const auto b = value_of(rest.displacements(planted.truth, 1));
    EXPECT_LT(largest_difference(a, b), 1e-3 * largest(b));
}

TEST(Motion, DerivativesAreThoseOfDifferences) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Planted planted(random, 0.1);
        for (const FitMotion motion : {FitMotion::Linear, FitMotion::Equilibrium}) {
            const auto problem = planted.problem({.motion = motion});
            const auto d = value_of(problem.impl().derivatives(planted.truth, arena()));
            for (std::size_t g = 0; g < 3; ++g)
                for (std::size_t c = 0; c < 2; ++c) {
                    auto more = planted.truth, less = planted.truth;
                    more[g] *= std::exp(1e-3);
                    less[g] *= std::exp(-1e-3);
                    const auto a = value_of(problem.displacements(more, c));
                    const auto b = value_of(problem.displacements(less, c));
                    double most = 0;
                    for (std::size_t n = 0; n < a.size(); ++n)
                        most = std::max(most, norm((a[n] - b[n]) * 500.0 - d.by[g][c][n]));
                    EXPECT_LT(most, 1e-5 * largest(d.by[g][c])) << g << ' ' << c;
                    EXPECT_GT(largest(d.by[g][c]), 1e-3 * largest(d.at[c]));
                }
        }
    }
}

void expect_truth(const FitResult& found, const Planted& planted, double tolerance) {
    for (std::size_t g = 0; g < planted.truth.size(); ++g)
        EXPECT_NEAR(std::log(found.values[g] / planted.truth[g]), 0, tolerance) << g;
}

TEST(Methods, EachFindsThePlantedValues) {
    for (std::uint64_t seed = 11; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Planted planted(random, 0);
        for (const FitCost cost : {FitCost::Distances, FitCost::Squares}) {
            const auto problem = planted.problem({.cost = cost});
            const auto newton = value_of(fit(problem, GaussNewton{}, arena()));
            expect_truth(newton, planted, 1e-4);
            EXPECT_LT(newton.evaluations, 60);
        }
        const auto annealed =
            value_of(fit(planted.problem({}), Annealing{.evaluations = 1000}, arena()));
        for (std::size_t g = 0; g < 2; ++g)  // the links; volume has less of a say
            EXPECT_NEAR(std::log(annealed.values[g] / planted.truth[g]), 0, 0.2);
        EXPECT_LT(annealed.at.cost, 0.2 * annealed.trace.front().cost);
    }
}

TEST(Methods, AValueThatEndsOnItsBoundIsReported) {
    Random random(3);
    const Planted planted(random, 0);
    for (const FitBound bound : {FitBound::None, FitBound::Low, FitBound::High}) {
        Planted bounded = planted;
        FitGroup& group = bounded.groups[0];
        if (bound == FitBound::Low) group.start = group.low = 1.2 * planted.truth[0];
        if (bound == FitBound::High) group.start = group.high = 0.8 * planted.truth[0];
        const auto found = value_of(fit(bounded.problem({}), GaussNewton{}, arena()));
        EXPECT_EQ(found.at_bound, (std::vector{bound, FitBound::None, FitBound::None}));
        if (bound == FitBound::None) continue;
        const double at = bound == FitBound::Low ? group.low : group.high;
        EXPECT_NEAR(found.values[0], at, 1e-4 * at);
    }
}

TEST(Methods, GaussNewtonFindsTheValuesOfAnEquilibriumFarFromRest) {
    Random random(21);
    Planted planted(random, 0, 1.0);
    const auto far = planted.problem({.motion = FitMotion::Equilibrium});
    for (std::size_t c = 0; c < 2; ++c)
        planted.cases[c].target = value_of(far.displacements(planted.truth, c));
    const auto problem = planted.problem({.motion = FitMotion::Equilibrium});
    expect_truth(value_of(fit(problem, GaussNewton{}, arena())), planted, 1e-3);
}

/// A brute search, for one value.
double golden_section(const FitProblem& problem, double low, double high) {
    const double part = 0.5 * (std::sqrt(5.0) - 1);
    const auto cost = [&](double v) { return value_of(problem.evaluate(std::array{v})).cost; };
    while (high / low > 1 + 1e-7) {
        const double a = high * std::pow(low / high, part), b = low * std::pow(high / low, part);
        (cost(a) < cost(b) ? high : low) = cost(a) < cost(b) ? b : a;
    }
    return low;
}

TEST(Methods, GaussNewtonEndsAtTheLeastSumOfDistancesOrSquares) {
    for (std::uint64_t seed = 31; seed <= 33; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Planted planted(random, 0.2);
        auto& all = planted.groups[0].links;
        all.insert(all.end(), planted.groups[1].links.begin(), planted.groups[1].links.end());
        planted.groups.resize(1);
        double found[2];
        for (const FitCost cost : {FitCost::Distances, FitCost::Squares}) {
            const auto problem = planted.problem({.cost = cost});
            const auto newton = value_of(fit(problem, GaussNewton{.tolerance = 1e-7}, arena()));
            EXPECT_NEAR(newton.values[0] / golden_section(problem, 0.1, 10), 1, 1e-5);
            found[int(cost)] = newton.values[0];
        }
        EXPECT_GT(std::abs(found[0] / found[1] - 1), 1e-4);  // so that it matters which
    }
}

TEST(Methods, NothingDependsOnThreadsAndAnnealingOnItsSeed) {
    Random random(41);
    const Planted planted(random, 0.1);
    const auto problem = planted.problem({});
    const FitMethod methods[] = {GaussNewton{}, Annealing{.evaluations = 60}};
    for (const FitMethod& method : methods) {
        const auto one = value_of(fit(problem, method, TaskArena(1)));
        for (const int threads : {2, 4}) {
            const auto more = value_of(fit(problem, method, TaskArena(threads)));
            EXPECT_EQ(one.values, more.values);
            EXPECT_EQ(one.evaluations, more.evaluations);
            ASSERT_EQ(one.trace.size(), more.trace.size());
            for (std::size_t n = 0; n < one.trace.size(); ++n)
                EXPECT_EQ(one.trace[n].cost, more.trace[n].cost);
        }
    }
    const auto a = value_of(fit(problem, Annealing{.seed = 1, .evaluations = 30}, arena()));
    const auto b = value_of(fit(problem, Annealing{.seed = 2, .evaluations = 30}, arena()));
    EXPECT_NE(a.values, b.values);
}

TEST(Annealing, CoolsAsLundyAndMeesAndEndsWhereItStands) {
    Random random(51);
    const Planted planted(random, 0.1);
    const auto problem = planted.problem({});
    // The figures of Table 1, in the unit of this cost.
    const auto letter = value_of(fit(
        problem, Annealing{.start_temperature = 0.5, .cooling = 0.45, .evaluations = 50}, arena()));
    EXPECT_EQ(letter.evaluations, 51);
    EXPECT_NEAR(1 / letter.end_temperature, 1 / 0.5 + 50 * 0.45, 1e-9);
    // So hot that each move is taken: it ends anywhere, and says so.
    EXPECT_GT(letter.at.cost, 1.01 * letter.trace.back().cost);
    const auto best = value_of(fit(
        problem,
        Annealing{.start_temperature = 0.5, .cooling = 0.45, .evaluations = 50, .best_seen = true},
        arena()));
    EXPECT_NEAR(best.at.cost, letter.trace.back().cost, 1e-12);
    // So cold that none uphill is: it ends at the best values.
    const auto cold = value_of(fit(
        problem, Annealing{.start_temperature = 1e-12, .cooling = 1, .evaluations = 50}, arena()));
    EXPECT_EQ(cold.at.cost, cold.trace.back().cost);
    // By itself it covers its range in exactly this number of steps.
    const auto own = value_of(fit(problem, Annealing{.evaluations = 50}, arena()));
    EXPECT_NEAR(own.start_temperature / own.end_temperature, 1000, 1e-6 * 1000);
    EXPECT_EQ(own.evaluations, 51 + 32);
}

TEST(Identifiability, DampingIsNotSeenAtAnEquilibriumAndAllStiffnessesTogetherAre) {
    Random random(61);
    Planted planted(random, 0);
    for (SpringNode& node : planted.parts.nodes) node.damping = 1;
    FitGroup damping{.name = "damping", .start = 1, .low = 0.1, .high = 10};
    for (std::size_t n = 0; n < planted.parts.nodes.size(); ++n)
        damping.nodes.push_back(std::int32_t(n));
    planted.groups.push_back(damping);
    planted.truth.push_back(1);
    for (const FitMotion motion : {FitMotion::Linear, FitMotion::Equilibrium}) {
        const auto directions =
            value_of(fit_directions(planted.problem({.motion = motion}), planted.truth, arena()));
        EXPECT_LT(directions[0].influence, 1e-6);
        EXPECT_NEAR(std::abs(directions[0].direction[3]), 1, 1e-6);
        EXPECT_GT(directions[1].influence, kMinInfluence);
        // All stiffer by a factor: Σ over directions of influence² · (direction · (1,1,1,0))² = 1.
        double sum = 0;
        for (const FitDirection& d : directions) {
            const double along = d.direction[0] + d.direction[1] + d.direction[2];
            sum += d.influence * d.influence * along * along;
        }
        EXPECT_NEAR(sum, 1, 1e-3);
    }
    const auto early =
        planted.problem({.motion = FitMotion::Run, .run = {.depth = 20}, .duration = 1});
    for (const FitDirection& d : value_of(fit_directions(early, planted.truth, arena())))
        EXPECT_GT(d.influence, kMinInfluence);
    // It keeps its start where nothing shows it.
    const auto found = value_of(fit(planted.problem({}), GaussNewton{}, arena()));
    EXPECT_NEAR(found.values[3], 1, 1e-9);
    EXPECT_NEAR(std::log(found.values[0] / planted.truth[0]), 0, 1e-4);
}

TEST(Problem, BadInputGetsItsLine) {
    Random random(71);
    const Planted good(random, 0);
    const auto said = [&](auto change, FitSettings settings = {}) {
        Planted bad = good;
        change(bad);
        const auto problem = FitProblem::create(bad.parts, bad.groups, bad.cases, settings);
        return problem.ok() ? "" : problem.error().message;
    };
    EXPECT_EQ(said([](Planted&) {}), "");
    const auto expect = [&](const std::string& text, auto change) {
        const std::string found = said(change);
        EXPECT_NE(found.find(text), std::string::npos) << found;
        EXPECT_EQ(found.find('\n'), std::string::npos);
    };
    expect("groups, found none", [](Planted& p) { p.groups.clear(); });
    expect("group 1: expected links", [](Planted& p) { p.groups[1].links = {}; });
    expect("links below", [](Planted& p) { p.groups[0].links.push_back(100000); });
    expect("found link", [](Planted& p) { p.groups[1].links.push_back(p.groups[0].links[0]); });
    expect("0 < low <= start <= high", [](Planted& p) { p.groups[0].low = 0; });
    expect("0 < low <= start <= high", [](Planted& p) { p.groups[0].start = 11; });
    expect("case 1: expected a target", [](Planted& p) { p.cases[1].target.pop_back(); });
    expect("case 0: expected a force", [](Planted& p) { p.cases[0].forces.pop_back(); });
    expect("found node 0, which is held", [](Planted& p) { p.cases[0].nodes[0] = 0; });
    expect("found node 87, which is held", [](Planted& p) { p.cases[0].held = {87}; });
    expect("node 92 again", [](Planted& p) { p.cases[0].nodes = {92, 92}; });
    expect("a weight above 0", [](Planted& p) { p.cases[0].weight = 0; });
    expect("aren't held out", [](Planted& p) {
        for (FitCase& c : p.cases) c.held_out = true;
    });
    expect("rest length", [](Planted& p) { p.parts.links[3].rest_length = 0.5; });
    expect("stiffness", [](Planted& p) { p.parts.links[3].stiffness = -1; });
    EXPECT_NE(said([](Planted&) {}, {.motion = FitMotion::Run, .duration = 0}), "");
    const auto problem = good.problem({});
    EXPECT_FALSE(problem.evaluate(std::array{1.0, 1.0}).ok());
    EXPECT_FALSE(problem.evaluate(std::array{1.0, 0.0, 1.0}).ok());
    EXPECT_FALSE(fit(problem, GaussNewton{.max_steps = 0}, arena()).ok());
    EXPECT_FALSE(fit(problem, Annealing{.neighbourhood = 2}, arena()).ok());
    EXPECT_FALSE(
        fit(problem, Annealing{.start_temperature = 1, .end_temperature = 2}, arena()).ok());
    EXPECT_FALSE(fit(problem, Annealing{.evaluations = 0}, arena()).ok());
}

TEST(Problem, ANetworkWithoutShearStiffnessIsRefusedNotSolved) {
    auto parts = springs_of_lattice({.size = {4, 4, 4}, .links = LatticeLinks::Edges});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    FitGroup all{.name = "all", .start = 1, .low = 0.1, .high = 10};
    for (std::size_t l = 0; l < parts->links.size(); ++l) all.links.push_back(std::int32_t(l));
    FitCase push{.name = "push",
                 .nodes = {53},
                 .forces = {{1, 0, 0}},
                 .target = std::vector<Vec3d>(64, Vec3d{0, 0, 0})};
    const auto problem = value_of(FitProblem::create(*parts, {all}, {push}, {}));
    const auto found = problem.evaluate(std::array{1.0});
    ASSERT_FALSE(found.ok());
    EXPECT_NE(found.error().message.find("move without a force"), std::string::npos);
    for (const FitMethod& method : {FitMethod(GaussNewton{}), FitMethod(Annealing{})})
        EXPECT_FALSE(fit(problem, method, arena()).ok());
}

}  // namespace
}  // namespace pliant::test
