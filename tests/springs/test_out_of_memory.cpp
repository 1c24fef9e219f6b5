// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each allocation fails once, and nothing is lost by it.
// Covers: springs/tissue_statics.cpp, springs/network*.cpp, springs/tissue.cpp.

#include <gtest/gtest.h>
#include <pliant/models/springs.h>

#include <array>
#include <string>

#include "support/each_allocation.h"

namespace pliant::test {
namespace {

const std::array<std::int32_t, 2> kFirst{3 + 7 * (3 + 7 * 4), 4 + 7 * (3 + 7 * 4)};
const std::array<std::int32_t, 3> kSecond{1 + 7 * (5 + 7 * 4), 2 + 7 * (5 + 7 * 4),
                                          5 + 7 * (1 + 7 * 2)};

SpringNetwork block_network() {
    const SpringLattice lattice{.size = {7, 7, 5}, .node_damping = 1, .bulk = 0.3};
    return SpringNetwork::create(springs_of_lattice(lattice).value()).value();
}

/// A tissue in motion, with a tool that then takes hold of other nodes.
std::unique_ptr<SpringTissue> moving(SpringSolver solver, const TaskArena& arena) {
    auto tissue = std::make_unique<SpringTissue>(
        SpringTissue::create(block_network(), {.solver = solver, .depth = 3}).value());
    EXPECT_TRUE(tissue->load(kFirst, std::array{Vec3d{0, 0, -0.2}, Vec3d{0.1, 0, 0}}).ok());
    if (solver == SpringSolver::ForceTransmittal || solver == SpringSolver::Explicit) {
        EXPECT_TRUE(tissue->step(7, arena).ok());
    } else {  // the first step gets all of the memory
        for (std::int32_t n = 150; n < 170; ++n)
            EXPECT_TRUE(tissue->set_state(n, tissue->position(n), {0.01 * n, 0, 0.3}).ok());
    }
    EXPECT_TRUE(tissue->hold(kSecond).ok());
    EXPECT_TRUE(tissue->shift_held({0.02, 0, 0}).ok());
    return tissue;
}

/// State of all positions and velocities.
std::string state_of(const SpringTissue& tissue) {
    std::string state;
    const auto add = [&](Vec3d v) { state.append(reinterpret_cast<const char*>(&v), sizeof(v)); };
    for (std::int32_t n = 0; n < tissue.network().node_count(); ++n) {
        add(tissue.position(n));
        add(tissue.velocity(n));
    }
    return state;
}

class Solvers : public testing::TestWithParam<SpringSolver> {};

TEST_P(Solvers, AStepThatRanOutOfMemoryWasNotMade) {
    const TaskArena arena(1);
    const auto make = [&] { return moving(GetParam(), arena); };
    // Later steps show differences that the state of a tissue hides.
    const auto goes_on = [&](SpringTissue& tissue) {
        EXPECT_TRUE(tissue.hold({}).ok());
        EXPECT_TRUE(tissue.step(4, arena).ok());
        return state_of(tissue);
    };
    auto twin = make();
    ASSERT_TRUE(twin->step(3, arena).ok());
    const std::string later = goes_on(*twin);
    std::unique_ptr<SpringTissue> last;
    const Failures failures = fail_each_allocation(
        make, [&](SpringTissue& tissue) { return tissue.step(3, arena); }, state_of);
    for (const std::int64_t n : chosen(failures.allocations, {})) {
        auto tissue = make();
        bool ok = false;
        {
            const FailingAllocation failing(n);
            ok = tissue->step(3, arena).ok();
        }
        if (!ok) {
            ASSERT_TRUE(tissue->step(3, arena).ok());
        }
        ASSERT_EQ(goes_on(*tissue), later) << "allocation " << n;
    }
}

TEST_P(Solvers, AnEquilibriumThatRanOutOfMemoryWasNotSought) {
    const TaskArena arena(1);
    const Failures failures = fail_each_allocation(
        [&] { return moving(GetParam(), arena); },
        [](SpringTissue& tissue) { return tissue.find_equilibrium(1e-6); }, state_of);
    EXPECT_GT(failures.failed, 4);
}

TEST_P(Solvers, LoadsToolsAndReactionsAreChangedOrNot) {
    const TaskArena arena(1);
    const auto make = [&] { return moving(GetParam(), arena); };
    for (const ReactionLaw law : {ReactionLaw::Held, ReactionLaw::Relaxed})
        fail_each_allocation(
            make, [&](SpringTissue& tissue) { return tissue.reaction(kSecond, law); }, state_of);
    // These get no memory at all.
    auto tissue = make();
    const FailingAllocation failing(0);
    EXPECT_TRUE(tissue->load(kSecond, std::array{Vec3d{}, Vec3d{}, Vec3d{}}).ok());
    EXPECT_TRUE(tissue->hold(kFirst).ok());
    EXPECT_TRUE(tissue->shift_held({0, 0.1, 0}).ok());
    EXPECT_TRUE(tissue->set_state(3, {1, 2, 3}, {0, 0, 0}).ok());
    tissue->reset();
    EXPECT_FALSE(failing.has_failed());
}

TEST_P(Solvers, ACutThatRanOutOfMemoryWasNotMade) {
    const TaskArena arena(1);
    const auto make = [&] { return moving(GetParam(), arena); };
    const auto state = [](const SpringTissue& tissue) {
        std::string all = state_of(tissue);
        const SpringNetwork& network = tissue.network();
        for (std::size_t l = 0; l < network.links().size(); ++l) all += char(network.is_cut(l));
        for (std::size_t c = 0; c < network.cells().size(); ++c)
            all += char(network.is_cell_cut(c));
        return all;
    };
    const std::array<std::int32_t, 3> cut{10, 11, 40};
    fail_each_allocation(
        make, [&](SpringTissue& tissue) { return tissue.cut_links(cut); }, state);
    fail_each_allocation(
        make, [&](SpringTissue& tissue) { return tissue.cut_cells(cut); }, state);
}

INSTANTIATE_TEST_SUITE_P(OutOfMemory, Solvers,
                         testing::Values(SpringSolver::ForceTransmittal, SpringSolver::Explicit,
                                         SpringSolver::ImplicitEuler));

TEST(OutOfMemory, ThePlanOfAToolThatGoesOnSurvivesAFailedOne) {
    // More contacts than plans are kept: the next plan takes the place of another.
    const TaskArena arena(1);
    const auto hold = [&](SpringTissue& tissue, std::int32_t node) {
        EXPECT_TRUE(tissue.hold({&node, 1}).ok());
        EXPECT_TRUE(tissue.shift_held({0, 0.01, 0}).ok());
    };
    constexpr std::int32_t kLast = 50 + 63, kOther = 130;
    const auto make = [&] {
        auto tissue = moving(SpringSolver::ForceTransmittal, arena);
        for (std::int32_t n = 50; n <= kLast; ++n) {
            hold(*tissue, n);
            EXPECT_TRUE(tissue->step(1, arena).ok());
        }
        return tissue;
    };
    int failed = 0;
    for (std::int64_t n = 0; n < 20; ++n) {
        auto tissue = make(), twin = make();
        hold(*tissue, kOther);
        hold(*twin, kOther);
        {
            const FailingAllocation failing(n);
            if (tissue->step(1, arena).ok()) break;
            ++failed;
        }
        for (SpringTissue* each : {tissue.get(), twin.get()})
            for (std::int32_t k = kLast; k > kLast - 40; --k) {
                hold(*each, k);
                ASSERT_TRUE(each->step(1, arena).ok());
            }
        ASSERT_EQ(state_of(*tissue), state_of(*twin)) << "allocation " << n;
    }
    EXPECT_GT(failed, 0);
}

TEST(OutOfMemory, NetworksAndDepthsAreMadeOrRefused) {
    const TaskArena arena(1);
    const SpringNetwork network = block_network();
    const auto each = [&](const auto& operation) {
        fail_each_allocation([&] { return &network; }, operation,
                             [](const SpringNetwork&) { return 0; },
                             {.all_up_to = 150, .of_the_rest = 30});
    };
    const SpringLattice lattice{.size = {5, 5, 4}, .bulk = 0.3};
    each([&](const SpringNetwork&) { return springs_of_lattice(lattice); });
    each([&](const SpringNetwork&) { return springs_of_sheet({.columns = 5, .rows = 4}); });
    each([&](const SpringNetwork& n) { return transmittal_order(n, kFirst, 3); });
    each([&](const SpringNetwork& n) {
        return find_depth(n, {}, kFirst, std::array{Vec3d{0, 0, -0.2}, Vec3d{0.1, 0, 0}},
                          {.threshold = 0.05, .max_depth = 5}, arena);
    });
}

}  // namespace
}  // namespace pliant::test
