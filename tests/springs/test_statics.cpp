// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Equilibria against a sparse factorisation that is put together here, and against elasticity.
// Covers: springs/coarse_space.cpp, springs/tangent.cpp, springs/tissue_statics.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <string>
#include <vector>

#include "springs/random_networks.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Stiffness matrix of the links at the rest shape; a fixed node's rows are those of the identity.
SparseMatrix stiffness_of(const SpringNetwork& network) {
    const int size = 3 * network.node_count();
    std::vector<Eigen::Triplet<double>> entries;
    for (const SpringLink& link : network.links()) {
        const Vec3d n = normalized(network.nodes()[std::size_t(link.a)].rest -
                                   network.nodes()[std::size_t(link.b)].rest);
        for (const auto& [p, q, sign] :
             {std::tuple(link.a, link.a, 1.0), std::tuple(link.b, link.b, 1.0),
              std::tuple(link.a, link.b, -1.0), std::tuple(link.b, link.a, -1.0)})
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 3; ++c)
                    if (!network.nodes()[std::size_t(p)].fixed &&
                        !network.nodes()[std::size_t(q)].fixed)
                        entries.emplace_back(3 * p + r, 3 * q + c,
                                             sign * link.stiffness * n[r] * n[c]);
    }
    for (int n = 0; n < size; ++n)
        if (network.nodes()[std::size_t(n / 3)].fixed) entries.emplace_back(n, n, 1.0);
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// Displacements from K u = F.
std::vector<Vec3d> linear_solution(const SpringNetwork& network,
                                   std::span<const std::int32_t> nodes,
                                   std::span<const Vec3d> forces) {
    Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * network.node_count());
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (int c = 0; c < 3; ++c) right[3 * nodes[n] + c] = forces[n][c];
    const Eigen::VectorXd u =
        Eigen::SimplicialLDLT<SparseMatrix>(stiffness_of(network)).solve(right);
    std::vector<Vec3d> result;
    for (int n = 0; n < u.size(); n += 3) result.push_back({u[n], u[n + 1], u[n + 2]});
    return result;
}

TEST(Statics, SmallLoadsGiveTheSparseSolution) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto network = SpringNetwork::create(random_block(random, {6, 5, 5}, 0, false));
        auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit});
        const std::array nodes{140, 120};
        const std::array<Vec3d, 2> forces{random.vector(1e-6), random.vector(1e-6)};
        ASSERT_TRUE(tissue->load(nodes, forces).ok());
        const Status status = tissue->find_equilibrium();
        ASSERT_TRUE(status.ok()) << status.error().message;
        const std::vector<Vec3d> expected = linear_solution(*network, nodes, forces);
        double largest = 0;
        for (const Vec3d u : expected) largest = std::max(largest, norm(u));
        for (std::size_t n = 0; n < expected.size(); ++n)
            EXPECT_LT(norm(tissue->displacement(std::int32_t(n)) - expected[n]), 2e-5 * largest);
    }
}

TEST(Statics, NoForceIsLeftAtALargeEquilibrium) {
    const std::uint64_t seed = 9;
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto network = SpringNetwork::create(random_block(random, {6, 6, 5}, 4, false));
    auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit});
    const std::array node{3 + 6 * (3 + 6 * 4)};
    const std::array<Vec3d, 1> force{{{0.4, 0, -1.5}}};
    ASSERT_TRUE(tissue->load(node, force).ok());
    const Status status = tissue->find_equilibrium();
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_GT(norm(tissue->displacement(node[0])), 0.1);
    for (std::int32_t n = 0; n < network->node_count(); ++n) {
        if (network->nodes()[std::size_t(n)].fixed) continue;
        const auto reaction = tissue->reaction(std::array{n}, ReactionLaw::Held);
        const Vec3d load = n == node[0] ? force[0] : Vec3d{0, 0, 0};
        EXPECT_LT(norm(reaction->force + load), 1e-8);
    }
}

TEST(Statics, AnEquilibriumThatIsGivenUpLeavesAllNodesInPlace) {
    Random random(9);
    const auto network = SpringNetwork::create(random_block(random, {6, 6, 5}, 4, false));
    const TaskArena one_thread(1);
    const auto stepped = [&] {
        auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit});
        EXPECT_TRUE(tissue->load(std::array{129}, std::array<Vec3d, 1>{{{0.4, 0, -1.5}}}).ok());
        EXPECT_TRUE(tissue->step(5, one_thread).ok());
        return tissue;
    };
    auto tissue = stepped(), twin = stepped();
    const std::vector<Vec3d> before = tissue->displacements();
    int given_up = 0, asked = 0;
    for (int last = 1;; last += last < 20 ? 1 : last / 3) {
        asked = 0;
        const Status status = tissue->find_equilibrium(1e-9, [&] { return ++asked == last; });
        if (status.ok()) break;
        EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
        ASSERT_EQ(tissue->displacements(), before) << last;
        for (std::int32_t n = 0; n < network->node_count(); ++n)
            ASSERT_EQ(tissue->velocity(n), twin->velocity(n)) << last;
        ++given_up;
    }
    EXPECT_GT(given_up, 20);
    ASSERT_TRUE(twin->find_equilibrium().ok());
    EXPECT_EQ(tissue->displacements(), twin->displacements());
}

/// The cube of the paper's Table 2, pressed or drawn at four nodes of its top.
SpringTissue loaded_cube(double newton_each) {
    const double edge = 0.1 / 9;
    auto parts = springs_of_lattice(
        {.size = {10, 10, 10}, .spacing = {edge, edge, edge}, .stiffness = {2575, 2575, 2575}});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    auto tissue = SpringTissue::create(*SpringNetwork::create(std::move(*parts)),
                                       {.solver = SpringSolver::Explicit});
    const std::array nodes{944, 945, 954, 955};
    std::array<Vec3d, 4> forces;
    forces.fill({0, 0, newton_each});
    EXPECT_TRUE(tissue->load(nodes, forces).ok());
    return std::move(*tissue);
}

TEST(Statics, WhereALatticeSnapsThroughThereIsAnEquilibriumBehindItAndFoldedCellsTell) {
    for (const double newton : {-80.0, -40.0, -35.0, 80.0}) {
        SCOPED_TRACE(newton);
        SpringTissue tissue = loaded_cube(newton);
        const Status status = tissue.find_equilibrium(1e-7);
        ASSERT_TRUE(status.ok()) << status.error().message;
        EXPECT_EQ(tissue.folded_cells(), newton < -35 ? 9 : 0);
        std::vector<Vec3d> positions;
        for (std::int32_t n = 0; n < 1000; ++n) {
            positions.push_back(tissue.position(n));
            const bool loaded = n == 944 || n == 945 || n == 954 || n == 955;
            const auto reaction = tissue.reaction(std::array{n}, ReactionLaw::Held);
            if (n >= 100) {
                EXPECT_LT(norm(reaction->force + Vec3d{0, 0, loaded ? newton : 0}), 1e-5);
            }
        }
        // A stable equilibrium: every small motion increases the energy.
        const auto potential = [&] {
            double work = 0;
            for (const std::int32_t n : {944, 945, 954, 955})
                work += newton * tissue.displacement(n).z;
            return tissue.elastic_energy() - work;
        };
        const double least = potential();
        Random random(5);
        for (int turn = 0; turn < 20; ++turn) {
            for (std::int32_t n = 100; n < 1000; ++n) {
                const Vec3d off = positions[std::size_t(n)] + random.vector(1e-4);
                ASSERT_TRUE(tissue.set_state(n, off, {0, 0, 0}).ok());
            }
            EXPECT_GT(potential(), least) << turn;
        }
    }
}

/// Lateral over axial strain of a block that is drawn out by its ends, in the linear range.
/// @param parts  of 5 x 5 x 5 nodes. @param edge  of the block
double poisson_ratio(const SpringParts& parts, double edge) {
    const auto network = SpringNetwork::create(parts);
    auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit});
    // A third of the nodes' freedom: equal forces at both ends, which keep the middle in place.
    std::vector<std::int32_t> nodes;
    std::vector<Vec3d> forces;
    for (std::int32_t n = 0; n < network->node_count(); ++n) {
        const Vec3d x = network->nodes()[std::size_t(n)].rest;
        if (x.z != 0 && x.z != edge) continue;
        const double share =
            (x.x == 0 || x.x == edge ? 0.5 : 1) * (x.y == 0 || x.y == edge ? 0.5 : 1);
        nodes.push_back(n);
        forces.push_back({0, 0, (x.z == 0 ? -1e-6 : 1e-6) * share});
    }
    EXPECT_TRUE(tissue->load(nodes, forces).ok());
    const Status status = tissue->find_equilibrium(1e-7);
    EXPECT_TRUE(status.ok()) << status.error().message;
    const auto stretch = [&](std::int32_t a, std::int32_t b, int axis) {
        return tissue->displacement(b)[axis] - tissue->displacement(a)[axis];
    };
    const std::int32_t middle = 2 + 5 * (2 + 5 * 2);
    return -stretch(middle - 1, middle + 1, 0) / stretch(middle - 25, middle + 25, 2);
}

double poisson_ratio(double bulk, double shared) {
    return poisson_ratio(*springs_of_lattice({.size = {5, 5, 5},
                                              .stiffness = {1, 1, 1},
                                              .bulk = bulk,
                                              .shared_by_cells = shared > 0}),
                         4);
}

// Test case 22 of the references.
TEST(Statics, LinksAloneHaveAPoissonRatioOfAQuarterAndVolumeEnergyAny) {
    EXPECT_NEAR(poisson_ratio(0, 1), 0.25, 0.0025);
    // µ = k/a = 1: for ν = 0.45, λ = 2µν/(1 − 2ν) = 9.
    const SpringMaterial material = closed_form(2.9, 0.45, 1);
    EXPECT_NEAR(material.stiffness, 1, 1e-12);
    EXPECT_NEAR(material.bulk, 8, 1e-12);
    EXPECT_NEAR(poisson_ratio(material.bulk, 1), 0.45, 0.0045);
}

TEST(Statics, AStretchedPartOfAScanHasTheAskedPoissonRatio) {
    Volume volume;
    volume.grid = {.size = {21, 21, 21}};
    volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
    for (const double nu : {0.25, 0.3, 0.4, 0.45, 0.49}) {
        const auto parts = springs_of_scan(volume, {.size = {5, 5, 5},
                                                    .fixed_border = false,
                                                    .young_modulus_pa = [](double) { return 3e-3; },
                                                    .poisson_ratio = [nu](double) { return nu; },
                                                    .shared_by_cells = true});
        ASSERT_TRUE(parts.ok()) << parts.error().message;
        EXPECT_EQ(SpringNetwork::create(*parts)->has_volume_energy(), nu > 0.25);
        EXPECT_NEAR(poisson_ratio(*parts, 20), nu, 0.01 * nu);
    }
    for (const double nu : {0.24, 0.5}) {
        const auto refused = springs_of_scan(
            volume, {.size = {5, 5, 5}, .poisson_ratio = [nu](double) { return nu; }});
        ASSERT_FALSE(refused.ok());
        EXPECT_NE(refused.error().message.find("poisson_ratio: expected numbers from 0.25"),
                  std::string::npos)
            << refused.error().message;
    }
}

// So an equilibrium identifies one number only: k by a single stored solution.
TEST(Statics, DisplacementsScaleWithOneOverStiffnessInTheLinearRange) {
    Vec3d first{};
    for (const double k : {1.0, 3.0}) {
        auto parts = springs_of_lattice({.size = {6, 6, 6}, .stiffness = {k, k, k}});
        for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
        auto tissue = SpringTissue::create(*SpringNetwork::create(*parts),
                                           {.solver = SpringSolver::Explicit});
        const std::array node{2 + 6 * (2 + 6 * 5)};
        ASSERT_TRUE(tissue->load(node, std::array{Vec3d{0, 0, -1e-6}}).ok());
        ASSERT_TRUE(tissue->find_equilibrium().ok());
        const Vec3d scaled = k * tissue->displacement(node[0]);
        if (k == 1) first = scaled;
        EXPECT_LT(norm(scaled - first), 1e-5 * norm(first));
    }
}

TEST(Statics, AReactionIsWhatTheHeldNodesBearAndItsLawPredictsTheNext) {
    const std::uint64_t seed = 4;
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto network = SpringNetwork::create(random_block(random, {7, 7, 5}, 3, false));
    auto tissue = SpringTissue::create(*network, {.solver = SpringSolver::Explicit});
    const std::array nodes{3 + 7 * (3 + 7 * 4), 4 + 7 * (3 + 7 * 4), 3 + 7 * (4 + 7 * 4)};
    ASSERT_TRUE(tissue->hold(nodes).ok());
    ASSERT_TRUE(tissue->shift_held({0.02, 0.01, -0.1}).ok());
    ASSERT_TRUE(tissue->find_equilibrium().ok());
    for (const ReactionLaw law : {ReactionLaw::Held, ReactionLaw::Relaxed}) {
        const auto now = tissue->reaction(nodes, law);
        ASSERT_TRUE(now.ok());
        EXPECT_GT(now->force.z, 0);  // pressed down, the tissue presses back
        const Vec3d shift{1e-6, -2e-6, 1.5e-6};
        const auto next_force = [&] {
            if (law == ReactionLaw::Relaxed) {
                EXPECT_TRUE(tissue->find_equilibrium(1e-11).ok());
            }
            return tissue->reaction(nodes, law)->force;
        };
        ASSERT_TRUE(tissue->shift_held(shift).ok());
        const Vec3d more = next_force();
        ASSERT_TRUE(tissue->shift_held(-2.0 * shift).ok());
        const Vec3d less = next_force();
        ASSERT_TRUE(tissue->shift_held(shift).ok());
        ASSERT_TRUE(tissue->find_equilibrium().ok());
        const Vec3d predicted = now->stiffness * shift;
        EXPECT_LT(norm(0.5 * (more - less) - predicted), 1e-5 * norm(predicted));
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                EXPECT_NEAR(now->stiffness.columns[a][b], now->stiffness.columns[b][a], 1e-5);
        EXPECT_LT(dot(shift, now->stiffness * shift), 0);
    }
}

// The cube of [Choi2004, 4.3] with its k and d [m, N, kg]: its slowest motion takes 70.4 s, so runs
// of seconds are far from an equilibrium.
TEST(Statics, TheElastinCubeCreepsAsSlowlyAsItsSoftestMode) {
    constexpr double kDamping = 2149, kStep = 2e-3;
    const double spacing = 0.1 / 9;
    auto parts = springs_of_lattice({.size = {10, 10, 10},
                                     .spacing = {spacing, spacing, spacing},
                                     .stiffness = {2575, 2575, 2575},
                                     .node_damping = kDamping,
                                     .node_mass = 1.04e-3});
    for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0;
    const auto network = SpringNetwork::create(std::move(*parts));
    ASSERT_TRUE(network.ok());
    // Inverse iteration: softer modes win.
    const SparseMatrix stiffness = stiffness_of(*network);
    const Eigen::SimplicialLDLT<SparseMatrix> factors(stiffness);
    Eigen::VectorXd mode = Eigen::VectorXd::Zero(stiffness.rows());
    for (int n = 0; n < network->node_count(); ++n)
        if (const SpringNode& node = network->nodes()[std::size_t(n)]; !node.fixed)
            mode[3 * n] = node.rest.z + 0.1 * node.rest.x, mode[3 * n + 1] = 0.3 * node.rest.z;
    for (int turn = 0; turn < 60; ++turn) mode = factors.solve(mode).normalized();
    const double tau = kDamping / mode.dot(stiffness * mode);
    EXPECT_NEAR(tau, 70.4, 0.7);

    auto tissue =
        SpringTissue::create(*network, {.solver = SpringSolver::ImplicitEuler, .time_step = kStep});
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    const double size = 1e-4;  // [m]
    for (int n = 0; n < network->node_count(); ++n) {
        const Vec3d u = size * Vec3d{mode[3 * n], mode[3 * n + 1], mode[3 * n + 2]};
        const SpringNode& node = network->nodes()[std::size_t(n)];
        if (!node.fixed) {
            ASSERT_TRUE(tissue->set_state(n, node.rest + u, (-1 / tau) * u).ok());
        }
    }
    constexpr int kSteps = 500;
    ASSERT_TRUE(tissue->step(kSteps, one_thread()).ok());
    double left = 0;
    for (int n = 0; n < network->node_count(); ++n) {
        const Vec3d u = tissue->displacement(n);
        for (int c = 0; c < 3; ++c) left += u[c] * mode[3 * n + c] / size;
    }
    const double expected = 1 - std::exp(-kSteps * kStep / tau);
    EXPECT_NEAR(1 - left, expected, 0.01 * expected);
}

// [Choi2004, Fig. 12]: the softer way gives more.
TEST(Statics, AnAnisotropicBlockGivesMoreAlongItsSofterAxis) {
    const auto moved = [](Vec3d stiffness, Vec3d force) {
        auto parts = springs_of_lattice({.size = {7, 7, 7}, .stiffness = stiffness});
        for (SpringNode& node : parts->nodes) node.fixed = node.rest.z == 0 || node.rest.x == 6;
        auto tissue = SpringTissue::create(*SpringNetwork::create(*parts),
                                           {.solver = SpringSolver::Explicit});
        const std::int32_t node = force.x != 0 ? 7 * (3 + 7 * 3) : 3 + 7 * (3 + 7 * 6);
        EXPECT_TRUE(tissue->load(std::array{node}, std::array{force}).ok());
        EXPECT_TRUE(tissue->find_equilibrium().ok());
        return norm(tissue->displacement(node));
    };
    const Vec3d down{0, 0, -0.01}, across{0.01, 0, 0};
    EXPECT_NEAR(moved({10, 10, 10}, down), moved({10, 10, 10}, across), 1e-9);
    EXPECT_GT(moved({1, 1, 10}, across), 2 * moved({1, 1, 10}, down));
    EXPECT_LT(1.5 * moved({10, 10, 1}, across), moved({10, 10, 1}, down));
}

// Test case 27: on a half space the surface goes down as 1/r [Boussinesq1885].
TEST(Statics, TheSurfaceOfABlockGoesDownAsBoussinesqSays) {
    constexpr int kSide = 25, kDeep = 13;
    auto parts = springs_of_lattice({.size = {kSide, kSide, kDeep}});
    for (SpringNode& node : parts->nodes)
        node.fixed = node.rest.z == 0 || node.rest.x == 0 || node.rest.x == kSide - 1 ||
                     node.rest.y == 0 || node.rest.y == kSide - 1;
    auto tissue =
        SpringTissue::create(*SpringNetwork::create(*parts), {.solver = SpringSolver::Explicit});
    const std::int32_t top = kSide * kSide * (kDeep - 1), node = 12 + kSide * 12 + top;
    ASSERT_TRUE(tissue->load(std::array{node}, std::array{Vec3d{0, 0, -1e-4}}).ok());
    ASSERT_TRUE(tissue->find_equilibrium(1e-6).ok());
    // Held borders take away nearly the same near the middle, so differences are compared: with
    // k = a = 1, E = 2.5 and ν = 1/4, u = F (1 − ν²)/(π E r).
    const double theory = 1e-4 * (1 - 1.0 / 16) / (3.14159265 * 2.5);
    const auto sunk = [&](int r) { return -tissue->displacement(node + r).z; };
    for (const auto& [near, far] : {std::pair(2, 4), std::pair(3, 6), std::pair(2, 6)})
        EXPECT_NEAR((sunk(near) - sunk(far)) / (theory * (1.0 / near - 1.0 / far)), 1, 0.2)
            << near << ' ' << far;
}

TEST(Statics, TheDepthIsWhereOneMoreLayerChangesLessThanTheThreshold) {
    auto parts = springs_of_lattice({.size = {17, 17, 9}, .node_damping = 2});
    const auto network = SpringNetwork::create(*parts);
    const std::array node{8 + 17 * (8 + 17 * 8)};
    const std::array<Vec3d, 1> force{{{0, 0, -0.05}}};
    double last = 1e9;
    std::int32_t last_depth = 0;
    for (const double threshold : {1e-3, 4e-4}) {
        const auto found =
            find_depth(*network, {}, node, force, {.threshold = threshold}, one_thread());
        ASSERT_TRUE(found.ok()) << found.error().message;
        EXPECT_GT(found->depth, last_depth);
        last_depth = found->depth;
        ASSERT_EQ(found->changes.size(), std::size_t(found->depth));
        EXPECT_LT(found->changes.back(), threshold);
        for (std::size_t n = 0; n + 1 < found->changes.size(); ++n)
            EXPECT_GE(found->changes[n], threshold);
        for (const double change : found->changes) {
            EXPECT_LT(change, last * 1.0001);
            last = change;
        }
        last = 1e9;
    }
    const auto none =
        find_depth(*network, {}, node, force, {.threshold = 1e-12, .max_depth = 3}, one_thread());
    EXPECT_EQ(none->depth, 0);
    EXPECT_FALSE(find_depth(*network, {}, node, force, {.threshold = 0}, one_thread()).ok());
}

}  // namespace
}  // namespace pliant::test
