// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Implicit Euler with an assembled matrix, against a dense factor and against the solver link by
// link.
// Covers: springs/assembled_euler.cpp, springs/block_*.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/models/springs.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>

#include "springs/random_networks.h"
#include "support/count_allocations.h"
#include "support/each_allocation.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

struct Shape {
    std::vector<Vec3d> x, velocity, load;
    std::vector<bool> held;
};

/// A random state: all nodes shifted, some held, some loaded.
Shape random_shape(Random& random, const SpringNetwork& network, double shift) {
    Shape shape;
    for (const SpringNode& node : network.nodes()) {
        shape.x.push_back(node.fixed ? node.rest : node.rest + random.vector(shift));
        shape.held.push_back(!node.fixed && random.whole(0, 9) == 0);
        const bool is_free = !node.fixed && !shape.held.back();
        shape.velocity.push_back(is_free ? random.vector(1) : Vec3d{0, 0, 0});
        shape.load.push_back(is_free && random.whole(0, 2) == 0 ? random.vector(3)
                                                                : Vec3d{0, 0, 0});
    }
    return shape;
}

void put(SpringTissue& tissue, const Shape& shape) {
    std::vector<std::int32_t> held, loaded;
    std::vector<Vec3d> forces;
    for (std::int32_t n = 0; n < tissue.network().node_count(); ++n) {
        const auto k = std::size_t(n);
        if (tissue.network().nodes()[k].fixed) continue;
        ASSERT_TRUE(tissue.set_state(n, shape.x[k], shape.velocity[k]).ok());
        if (shape.held[k]) held.push_back(n);
        if (norm(shape.load[k]) == 0) continue;
        loaded.push_back(n);
        forces.push_back(shape.load[k]);
    }
    ASSERT_TRUE(tissue.hold(held).ok());
    ASSERT_TRUE(tissue.load(loaded, forces).ok());
}

/// Velocities after a step: (M/h² + D/h + C/h + K) v = (F + f)/h + M v/h², by a dense factor.
std::vector<Vec3d> dense_step(const SpringNetwork& network, const Shape& shape, double h) {
    const auto place = [&](std::int32_t n) { return shape.x[std::size_t(n)]; };
    const auto vector = [](Vec3d v) { return Eigen::Vector3d(v.x, v.y, v.z); };
    const Eigen::Index size = 3 * network.node_count();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    const auto add = [&](std::int32_t a, std::int32_t b, const Eigen::Matrix3d& block) {
        matrix.block<3, 3>(3 * a, 3 * b) += block;
    };
    for (std::int32_t n = 0; n < network.node_count(); ++n) {
        const SpringNode& node = network.nodes()[std::size_t(n)];
        add(n, n, (node.mass / (h * h) + node.damping / h) * Eigen::Matrix3d::Identity());
        right.segment<3>(3 * n) = vector(shape.load[std::size_t(n)]) / h +
                                  node.mass / (h * h) * vector(shape.velocity[std::size_t(n)]);
    }
    for (std::size_t l = 0; l < network.links().size(); ++l) {
        const SpringLink& link = network.links()[l];
        const Eigen::Vector3d r = vector(place(link.a) - place(link.b));
        if (network.is_cut(l) || r.norm() == 0) continue;
        const Eigen::Vector3d n = r.normalized();
        const double across = std::max(0.0, link.stiffness * (1 - link.rest_length / r.norm()));
        const Eigen::Matrix3d k = (link.stiffness - across + link.damping / h) * n * n.transpose() +
                                  across * Eigen::Matrix3d::Identity();
        add(link.a, link.a, k);
        add(link.b, link.b, k);
        add(link.a, link.b, -k);
        add(link.b, link.a, -k);
        const Eigen::Vector3d pull = link.stiffness * (r.norm() - link.rest_length) * n;
        right.segment<3>(3 * link.a) -= pull / h;
        right.segment<3>(3 * link.b) += pull / h;
    }
    for (std::size_t c = 0; c < network.cells().size(); ++c) {
        const SpringCell& cell = network.cells()[c];
        if (cell.bulk == 0 || network.is_cell_cut(c)) continue;
        const double rest =
            cell_volume(cell, [&](std::int32_t n) { return network.nodes()[std::size_t(n)].rest; });
        for (int a = 0; a < cell.node_count; ++a) {
            const Eigen::Vector3d mine = vector(volume_gradient(cell, a, place));
            right.segment<3>(3 * cell.nodes[std::size_t(a)]) -=
                cell.bulk * (cell_volume(cell, place) / rest - 1) * mine / h;
            for (int b = 0; b < cell.node_count; ++b)
                add(cell.nodes[std::size_t(a)], cell.nodes[std::size_t(b)],
                    cell.bulk / rest * mine * vector(volume_gradient(cell, b, place)).transpose());
        }
    }
    for (std::int32_t n = 0; n < network.node_count(); ++n) {
        if (!network.nodes()[std::size_t(n)].fixed && !shape.held[std::size_t(n)]) continue;
        matrix.block(3 * n, 0, 3, size).setZero();
        matrix.block(0, 3 * n, size, 3).setZero();
        add(n, n, Eigen::Matrix3d::Identity());
        right.segment<3>(3 * n).setZero();
    }
    const Eigen::VectorXd v = matrix.llt().solve(right);
    std::vector<Vec3d> result;
    for (Eigen::Index k = 0; k < size; k += 3) result.push_back({v[k], v[k + 1], v[k + 2]});
    return result;
}

/// Links by chance, hexahedra or tetrahedra.
SpringNetwork random_springs(Random& random, int kind) {
    SpringParts parts;
    if (kind == 0) {
        parts = random_parts(random, 90, true);
    } else if (kind == 1) {
        parts = random_block(random, {5, 5, 4}, 6, true);
    } else {
        TetMesh mesh = five_tet_block({4, 4, 4}, 1);
        for (Vec3d& node : mesh.nodes_mm) node = node + random.vector(0.1);
        parts = springs_of_elastic_tetrahedra(mesh.nodes_mm, mesh.cells,
                                              {.stiffness = 3, .density = 0.5, .bulk = 9})
                    .value();
        for (SpringNode& node : parts.nodes) node.fixed = node.rest.z < 0.5;
    }
    return SpringNetwork::create(std::move(parts)).value();
}

SpringSettings settings_of(double tolerance, double time_step = 0.3) {
    return {.solver = SpringSolver::ImplicitEuler,
            .time_step = time_step,
            .solve_tolerance = tolerance,
            .assembled = true};
}

TEST(Assembled, AStepOfARandomNetworkIsThatOfADenseFactor) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        SpringNetwork network = random_springs(random, int(seed % 3));
        std::vector<std::int32_t> cut;
        for (int n = 0; n < 5; ++n) cut.push_back(random.whole(0, int(network.links().size()) - 1));
        if (seed % 2) {
            ASSERT_TRUE(network.cut_links(cut).ok());
        }
        const double h = random.ratio(0.01, 1);
        const Shape shape = random_shape(random, network, 0.15);
        auto tissue = SpringTissue::create(network, settings_of(1e-9, h)).value();
        put(tissue, shape);
        const auto report = tissue.step(1, one_thread());
        ASSERT_TRUE(report.ok());
        EXPECT_LE(report->iterations, 1000);
        const std::vector<Vec3d> expected = dense_step(network, shape, h);
        double largest = 0, error = 0;
        for (std::size_t n = 0; n < expected.size(); ++n) {
            largest = std::max(largest, norm(expected[n]));
            if (!shape.held[n])
                error = std::max(error, norm(tissue.velocity(std::int32_t(n)) - expected[n]));
        }
        EXPECT_GT(largest, 0.1);
        // The matrix is single precision, with a condition of some hundreds.
        EXPECT_LT(error, 2e-5 * largest);
    }
}

TEST(Assembled, BitsAreTheSameWithAndWithoutVectorsAndForAnyNumberOfThreads) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const SpringNetwork network = random_springs(random, int(seed % 3));
        const Shape shape = random_shape(random, network, 0.1);
        std::vector<std::uint64_t> hashes;
        for (const bool vectors : {true, false})
            for (const int threads : {1, 2, 4}) {
                SpringSettings settings = settings_of(1e-4);
                settings.vectors = vectors;
                auto tissue = SpringTissue::create(network, settings).value();
                put(tissue, shape);
                ASSERT_TRUE(tissue.step(5, TaskArena(threads)).ok());
                hashes.push_back(tissue.hash());
            }
        for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
    }
}

double largest_difference(const SpringTissue& a, const SpringTissue& b) {
    double largest = 0;
    for (std::int32_t n = 0; n < a.network().node_count(); ++n)
        largest = std::max(largest, norm(a.position(n) - b.position(n)));
    return largest;
}

TEST(Assembled, TheEquilibriumIsThatOfTheOtherSolvers) {
    for (const double tolerance : {1e-8, 1e-3}) {
        const std::uint64_t seed = 12;
        SCOPED_TRACE(seed);
        Random random(seed);
        const SpringNetwork network =
            SpringNetwork::create(random_block(random, {6, 6, 5}, 4, true)).value();
        const std::array node{3 + 6 * (3 + 6 * 4)};
        const std::array<Vec3d, 1> force{{{0.4, 0, -1.5}}};
        SpringSettings settings = settings_of(tolerance, 5);
        auto assembled = SpringTissue::create(network, settings).value();
        auto minimum = SpringTissue::create(network, settings).value();
        settings.assembled = false;
        auto by_links = SpringTissue::create(network, settings).value();
        for (SpringTissue* tissue : {&assembled, &by_links, &minimum})
            ASSERT_TRUE(tissue->load(node, force).ok());
        ASSERT_TRUE(minimum.find_equilibrium().ok());
        ASSERT_GT(norm(minimum.displacement(node[0])), 0.2) << "far from linear";
        for (SpringTissue* tissue : {&assembled, &by_links})
            ASSERT_TRUE(tissue->step(150, one_thread()).ok());
        EXPECT_LT(largest_difference(assembled, minimum), 1e-7);
        EXPECT_LT(largest_difference(assembled, by_links), 1e-7);
        // It stays there.
        ASSERT_TRUE(minimum.step(1, one_thread()).ok());
        EXPECT_LT(largest_difference(assembled, minimum), 1e-7);
    }
}

TEST(Assembled, TheCoarseSpaceSavesIterations) {
    SpringParts parts = springs_of_lattice({.size = {24, 12, 12},
                                            .stiffness = {20, 20, 20},
                                            .node_mass = 1e-3,
                                            .bulk = 200,
                                            .shared_by_cells = true})
                            .value();
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.x == 0;
    const SpringNetwork network = SpringNetwork::create(std::move(parts)).value();
    std::array<std::int64_t, 2> iterations{};
    for (const bool assembled : {false, true}) {
        SpringSettings settings = settings_of(1e-3, 10);
        settings.assembled = assembled;
        auto tissue = SpringTissue::create(network, settings).value();
        const std::array node{network.node_count() - 1};
        ASSERT_TRUE(tissue.load(node, std::array{Vec3d{0, 0, -0.1}}).ok());
        const auto report = tissue.step(3, one_thread());
        ASSERT_TRUE(report.ok());
        iterations[assembled] = report->iterations;
    }
    EXPECT_LT(2 * iterations[1], iterations[0]) << iterations[1];
    EXPECT_GT(iterations[1], 10);
}

TEST(Assembled, CutTissueMovesAsANetworkWithoutTheLinks) {
    const std::uint64_t seed = 5;
    SCOPED_TRACE(seed);
    Random random(seed);
    SpringNetwork network = random_springs(random, 2);
    std::vector<std::int32_t> cut;
    for (int n = 0; n < 30; ++n) cut.push_back(random.whole(0, int(network.links().size()) - 1));
    const Shape shape = random_shape(random, network, 0.1);
    auto one = SpringTissue::create(network, settings_of(1e-3)).value();
    put(one, shape);
    ASSERT_TRUE(one.step(1, one_thread()).ok());
    ASSERT_TRUE(one.cut_links(cut).ok());
    put(one, shape);
    auto whole = SpringTissue::create(network, settings_of(1e-3)).value();
    ASSERT_TRUE(network.cut_links(cut).ok());
    auto other = SpringTissue::create(network, settings_of(1e-3)).value();
    for (SpringTissue* tissue : {&other, &whole}) put(*tissue, shape);
    for (SpringTissue* tissue : {&one, &other, &whole})
        ASSERT_TRUE(tissue->step(10, one_thread()).ok());
    EXPECT_EQ(one.hash(), other.hash());
    EXPECT_NE(one.hash(), whole.hash());
}

TEST(Assembled, DoubledLinksCoincidentNodesAndFixedNetworksAreFine) {
    SpringParts parts;
    for (const double x : {0.0, 1.0, 2.0, 2.0})
        parts.nodes.push_back({.rest = {x, 0, 0}, .damping = 1});
    parts.nodes[0].fixed = true;
    parts.links = {{0, 1}, {0, 1}, {1, 2}, {2, 3, 1, 0, 0}};  // no length between the last two
    auto tissue =
        SpringTissue::create(SpringNetwork::create(parts).value(), settings_of(1e-6)).value();
    ASSERT_TRUE(tissue.load(std::array{2}, std::array{Vec3d{0.1, 0, 0}}).ok());
    ASSERT_TRUE(tissue.step(400, one_thread()).ok());
    EXPECT_NEAR(tissue.displacement(1).x, 0.05, 1e-6) << "two links of stiffness 1";
    EXPECT_NEAR(tissue.displacement(3).x, 0.15, 1e-6);
    for (SpringNode& node : parts.nodes) node.fixed = true;
    auto still =
        SpringTissue::create(SpringNetwork::create(parts).value(), settings_of(1e-6)).value();
    const auto report = still.step(2, one_thread());
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->iterations, 0);
}

TEST(Assembled, AStepAllocatesNothingAndAFirstOneThatCantIsNotMade) {
    const std::uint64_t seed = 8;
    SCOPED_TRACE(seed);
    Random random(seed);
    const SpringNetwork network = random_springs(random, 2);
    const Shape shape = random_shape(random, network, 0.1);
    const auto make = [&] {
        auto tissue = std::make_unique<SpringTissue>(
            SpringTissue::create(network, settings_of(1e-3)).value());
        put(*tissue, shape);
        return tissue;
    };
    const auto calm = make();
    ASSERT_TRUE(calm->step(1, one_thread()).ok());
    ASSERT_TRUE(calm->hold(std::array{40, 41}).ok());
    {
        const FailingAllocation failing(0);
        EXPECT_TRUE(calm->step(1, one_thread()).ok());
        EXPECT_FALSE(failing.has_failed());
    }
    const auto state = [](const SpringTissue& tissue) { return tissue.hash(); };
    const auto step = [](SpringTissue& tissue) { return tissue.step(1, one_thread()); };
    const Failures failures = fail_each_allocation(make, step, state, {.fresh = true});
    EXPECT_GT(failures.failed, 10);
    const auto twin = make();
    ASSERT_TRUE(step(*twin).ok());
    for (const std::int64_t n : chosen(failures.allocations, {.all_up_to = 30, .of_the_rest = 5})) {
        const auto tissue = make();
        {
            const FailingAllocation failing(n);
            if (step(*tissue).ok()) continue;
        }
        ASSERT_TRUE(step(*tissue).ok());
        ASSERT_EQ(tissue->hash(), twin->hash()) << "allocation " << n;
    }
}

}  // namespace
}  // namespace pliant::test
