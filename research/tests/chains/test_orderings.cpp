// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The published orderings against the exact solution: cases of agreement, and cases of deviation.
// Covers: research/*ordering.cpp, research/draeger.cpp, research/gibson_*.cpp,
// research/waiting_list.cpp.

#include <gtest/gtest.h>
#include <pliant/research/orderings.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/random.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kOrderingsSeed = 20260401;

constexpr Ordering kAll[] = {Ordering::GibsonConvex,  Ordering::GibsonLists, Ordering::SchillOnce,
                             Ordering::SchillRequeue, Ordering::LiOnce,      Ordering::LiRequeue,
                             Ordering::Draeger,       Ordering::DraegerMean};

ElementLimits equal_limits(double fraction) {
    const Vec3d all{fraction, fraction, fraction};
    return {all, all, all, 500, false};
}

ChainLattice homogeneous(Vec3i size, double fraction) {
    return {.size = size, .materials = {equal_limits(fraction)}};
}

std::int32_t number(const ChainLattice& lattice, Vec3i e) {
    return std::int32_t(voxel_index({.size = lattice.size}, e));
}

std::unique_ptr<OrderingSolver> make(const ChainLattice& lattice, Ordering ordering) {
    auto solver = make_ordering(lattice, ordering);
    EXPECT_TRUE(solver.ok()) << name_of(ordering);
    return std::move(solver).value();
}

/// The exact solution, and an ordering's result for the same pushes.
struct Comparison {
    std::int64_t violated_links = 0;
    double max_violation = 0;
    double max_distance = 0;  ///< from the exact position, in any component
    std::int64_t exact_violated_links = 0;
    bool stopped_early = false;
};

struct Step {
    std::vector<std::int32_t> elements;
    Vec3d push_mm;
};

constexpr double kTolerance = 1e-4;
constexpr double kFloats = 5e-5;  ///< accuracy of positions in GibsonConvex

Comparison compare(const ChainLattice& lattice, Ordering ordering, std::span<const Step> steps) {
    const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    EXPECT_TRUE(graph.ok());
    GraphChainMail exact(*graph);
    const TaskArena arena(1);
    const auto solver = make(lattice, ordering);
    Comparison result;
    for (const Step& step : steps) {
        EXPECT_EQ(exact.push(step.elements, step.push_mm, arena)->status, PushStatus::Applied);
        const OrderingReport report = solver->push(step.elements, step.push_mm);
        EXPECT_EQ(report.status, PushStatus::Applied);
        result.stopped_early |= report.stopped_early;
    }
    std::vector<Vec3d> u;
    for (std::int32_t e = 0; e < graph->element_count(); ++e) {
        u.push_back(solver->displacement_mm(e));
        const Vec3d away = u.back() - exact.displacement_mm(e);
        result.max_distance =
            std::max({result.max_distance, std::abs(away.x), std::abs(away.y), std::abs(away.z)});
    }
    const LinkState links = check_links(*graph, u, kTolerance);
    result.violated_links = links.violated_links;
    result.max_violation = links.max_violation_mm;
    result.exact_violated_links = check_links(*graph, exact.displacements_mm(), 0).violated_links;
    return result;
}

/// Blobs of four materials, slack from 0.02 to 0.4 of a link. @param sheared  shear / stretch
ChainLattice heterogeneous(Random& random, int side, double sheared) {
    ChainLattice lattice{.size = {side, side, side}};
    for (const double fraction : {0.02, 0.05, 0.15, 0.4}) {
        lattice.materials.push_back(equal_limits(fraction));
        lattice.materials.back().shear = sheared * lattice.materials.back().stretch;
    }
    std::vector<Vec3d> centres;
    for (int n = 0; n < 24; ++n)
        centres.push_back({random.real(0, side), random.real(0, side), random.real(0, side)});
    for (int n = 0; n < side * side * side; ++n) {
        const Vec3d p{double(n % side), double(n / side % side), double(n / side / side)};
        const auto nearer = [&](Vec3d a, Vec3d b) { return norm(a - p) < norm(b - p); };
        const auto nearest = std::min_element(centres.begin(), centres.end(), nearer);
        lattice.material.push_back(std::uint8_t((nearest - centres.begin()) % 4));
    }
    return lattice;
}

TEST(Orderings, GibsonsListsMoveAsManyElementsAsThePublishedProgram) {
    // The table of measured programs: limits 0.8 / 1.2 / 0.2, the middle of a face pulled outwards.
    const ChainLattice lattice = homogeneous({50, 50, 50}, 0.2);
    const auto solver = make(lattice, Ordering::GibsonConvex);
    for (const int axis : {0, 1, 2}) {
        Vec3i face{25, 25, 25};
        face[axis] = 49;
        for (const auto& [pull, moved] :
             {std::pair{1.0, 85}, {2.0, 670}, {5.0, 10'425}, {20.0, 125'000}}) {
            solver->reset();
            Vec3d push{0, 0, 0};
            push[axis] = pull;
            const OrderingReport report = solver->push(std::array{number(lattice, face)}, push);
            EXPECT_EQ(report.moved_elements, moved) << "pull " << pull << " along axis " << axis;
        }
    }
}

void compare_homogeneous(std::uint64_t seed, std::span<const Ordering> orderings) {
    Random random(seed);
    ChainLattice lattice{.size = {random.whole(1, 9), random.whole(1, 9), random.whole(1, 7)}};
    if (seed % 3 == 0) lattice.size.z = 1;
    const auto fractions = [&] {
        return Vec3d{random.real(0.02, 0.5), random.real(0.02, 0.5), random.real(0.02, 0.5)};
    };
    for (int a = 0; a < 3; ++a) lattice.spacing_mm[a] = random.real(0.5, 2);
    lattice.materials.push_back({fractions(), fractions(), fractions(), 500, false});
    const Step step{
        {number(lattice, {random.whole(0, lattice.size.x - 1), random.whole(0, lattice.size.y - 1),
                          random.whole(0, lattice.size.z - 1)})},
        random.vector(4)};
    for (const Ordering ordering : orderings) {
        SCOPED_TRACE(name_of(ordering));
        const Comparison found = compare(lattice, ordering, {{step}});
        EXPECT_EQ(found.violated_links, 0);
        EXPECT_LT(found.max_distance, kFloats);
    }
}

TEST(Orderings, FromRestInOneMaterialGibsonsListsAreExactForAnyLimitsOfABox) {
    const Ordering orderings[] = {Ordering::GibsonConvex, Ordering::GibsonLists};
    for (std::uint64_t n = 0; n < 300 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kOrderingsSeed + n));
        compare_homogeneous(kOrderingsSeed + n, orderings);
    }
}

TEST(Orderings, FromRestWithEqualLimitsInAllDirectionsEveryOrderingIsExact) {
    Random random(kOrderingsSeed);
    for (int n = 0; n < 60; ++n) {
        const ChainLattice lattice =
            homogeneous({random.whole(2, 12), random.whole(2, 12), random.whole(1, 12)}, 0.2);
        const Step step{{random.whole(0, lattice.size.x * lattice.size.y * lattice.size.z - 1)},
                        random.vector(2)};
        for (const Ordering ordering : kAll) {
            SCOPED_TRACE(std::string(name_of(ordering)) + ", seed " +
                         std::to_string(kOrderingsSeed) + ", instance " + std::to_string(n));
            EXPECT_LT(compare(lattice, ordering, {{step}}).max_distance, kFloats);
        }
    }
}

TEST(Orderings, ASecondPushAfterAnotherDirectionIsExactForGibsonsListsToo) {
    for (std::uint64_t n = 0; n < 100 && !::testing::Test::HasFailure(); ++n) {
        Random random(kOrderingsSeed + n);
        SCOPED_TRACE("seed " + std::to_string(kOrderingsSeed + n));
        const ChainLattice lattice = homogeneous({8, 8, 6}, 0.2);
        const std::int32_t element = random.whole(0, 8 * 8 * 6 - 1);
        const Step steps[] = {{{element}, random.vector(2)},
                              {{element}, random.vector(2)},
                              {{element}, random.vector(2)}};
        EXPECT_LT(compare(lattice, Ordering::GibsonLists, steps).max_distance, kFloats);
    }
}

TEST(Orderings, WithSeveralMaterialsEveryOrderingLeavesViolatedLinksAndTheExactOneNone) {
    Random random(kOrderingsSeed);
    const ChainLattice lattice = heterogeneous(random, 20, 0.5);
    const Step step{{number(lattice, {10, 10, 10})}, {1.5, -1, 0.75}};
    for (const Ordering ordering : kAll) {
        if (ordering == Ordering::GibsonConvex) continue;
        SCOPED_TRACE(std::string(name_of(ordering)) + ", seed " + std::to_string(kOrderingsSeed));
        const Comparison found = compare(lattice, ordering, {{step}});
        EXPECT_GT(found.violated_links, 0);
        EXPECT_GT(found.max_violation, 0.1);
        EXPECT_GT(found.max_distance, 0.1);
        EXPECT_EQ(found.exact_violated_links, 0);
        EXPECT_FALSE(found.stopped_early);
    }
}

TEST(Orderings, SchillsListIsExactWhereALinkAllowsTheSameInAllComponentsAndDirections) {
    // A path's slack is then its length minus the distance of its ends, for every component: one
    // order is valid for all three, in any state.
    Random random(kOrderingsSeed);
    const ChainLattice lattice = heterogeneous(random, 20, 1);
    std::vector<Step> drag;
    for (int n = 0; n < 6; ++n)
        drag.push_back({{number(lattice, {10, 10, 10 - n % 2})}, random.vector(1)});
    for (const Ordering ordering : {Ordering::SchillOnce, Ordering::SchillRequeue}) {
        SCOPED_TRACE(std::string(name_of(ordering)) + ", seed " + std::to_string(kOrderingsSeed));
        EXPECT_EQ(compare(lattice, ordering, drag).max_distance, 0);
    }
}

/// A box of 9 × 9 × 5 with a wall between two chambers that leaves one passage around it.
ChainLattice chambers() {
    ChainLattice lattice = homogeneous({9, 9, 5}, 0.1);
    for (int k = 0; k < 5; ++k)
        for (int j = 0; j < 9; ++j)
            for (int i = 0; i < 9; ++i)
                lattice.present.push_back(!(i == 4 && j != 8) && !(j == 4 && i > 5 && k < 3));
    return lattice;
}

TEST(Orderings, GibsonsRuleForObjectsThatAreNotConvexReachesRoundAWall) {
    const ChainLattice lattice = chambers();
    const Step step{{number(lattice, {1, 2, 2})}, {-3, 2.5, 1}};
    const Comparison found = compare(lattice, Ordering::GibsonLists, {{step}});
    EXPECT_EQ(found.violated_links, 0);
    EXPECT_LT(found.max_distance, kFloats);
    const auto solver = make(lattice, Ordering::GibsonLists);
    solver->push(step.elements, step.push_mm);
    EXPECT_GT(std::abs(solver->displacement_mm(number(lattice, {7, 1, 2})).x), 0.1);
    EXPECT_EQ(solver->displacement_mm(number(lattice, {4, 1, 2})), (Vec3d{0, 0, 0}));
}

std::vector<std::int32_t> cell(const ChainLattice& lattice, Vec3i low) {
    std::vector<std::int32_t> corners;
    for (int c = 0; c < 8; ++c)
        corners.push_back(number(lattice, low + Vec3i{c & 1, c >> 1 & 1, c >> 2}));
    return corners;
}

TEST(Orderings, DraegersMultiMoveOfACellIsExactInOneMaterialAndBreaksAlongItsCutsInSeveral) {
    const ChainLattice one = homogeneous({16, 16, 16}, 0.2);
    const Step step{cell(one, {7, 7, 7}), {2, -1, 1.2}};
    for (const Ordering ordering : {Ordering::Draeger, Ordering::DraegerMean})
        EXPECT_LT(compare(one, ordering, {{step}}).max_distance, kFloats);
    // The thesis's own example (3.5.3): softer above the cut between the initial elements.
    ChainLattice two = one;
    two.materials.push_back(equal_limits(0.05));
    for (int n = 0; n < 16 * 16 * 16; ++n) two.material.push_back(n / 16 % 16 < 8);
    const Comparison found =
        compare(two, Ordering::DraegerMean, {{Step{step.elements, {2, 0, 0}}}});
    EXPECT_GT(found.violated_links, 0);
    EXPECT_EQ(found.exact_violated_links, 0);
}

TEST(Orderings, DraegerTakesTheSponsorsLimitsAndWidensOnlyTheShearAlongK) {
    // The sponsor is soft, its neighbour stiff; the slice distance is 2.
    const auto moved_with = [](Ordering ordering, Vec3i size, Vec3d push) {
        ChainLattice lattice{.size = size, .spacing_mm = {1, 1, 2}};
        lattice.materials = {equal_limits(0.3), equal_limits(0.1)};
        lattice.material = {0, 1};
        const auto solver = make(lattice, ordering);
        solver->push(std::array{0}, push);
        return solver->displacement_mm(1);
    };
    EXPECT_NEAR(moved_with(Ordering::Draeger, {2, 1, 1}, {1, 0, 0}).x, 1 - 0.3, 1e-5);
    EXPECT_NEAR(moved_with(Ordering::DraegerMean, {2, 1, 1}, {1, 0, 0}).x, 1 - 0.2, 1e-5);
    EXPECT_NEAR(moved_with(Ordering::Draeger, {1, 1, 2}, {1, 0, 0}).x, 1 - 0.6, 1e-5);
    EXPECT_NEAR(moved_with(Ordering::DraegerMean, {1, 1, 2}, {1, 0, 0}).x, 1 - 0.4, 1e-5);
    // The thesis measures z in slices, so that 0.3 of shear along i is 0.6 mm of it.
    EXPECT_NEAR(moved_with(Ordering::Draeger, {2, 1, 1}, {0, 0, 1}).z, 1 - 0.6, 1e-5);
    EXPECT_NEAR(moved_with(Ordering::DraegerMean, {2, 1, 1}, {0, 0, 1}).z, 1 - 0.2, 1e-5);
}

TEST(Orderings, AStepThatWouldMoveAFixedElementIsHalvedUntilItDoesNot) {
    ChainLattice lattice = homogeneous({5, 1, 1}, 0.2);
    lattice.materials.push_back(equal_limits(0.2));
    lattice.materials[1].fixed = true;
    lattice.material = {0, 0, 0, 0, 1};
    for (const Ordering ordering : kAll) {
        if (ordering == Ordering::GibsonConvex) continue;
        SCOPED_TRACE(name_of(ordering));
        const auto solver = make(lattice, ordering);
        // Four links take up 0.8 mm; a quarter of 3 mm fits.
        const OrderingReport report = solver->push(std::array{0}, {3, 0, 0});
        EXPECT_EQ(report.status, PushStatus::Limited);
        EXPECT_EQ(report.step_fraction, 0.25);
        EXPECT_EQ(report.moved_elements, 4);
        EXPECT_EQ(solver->displacement_mm(0).x, 0.75);
        EXPECT_EQ(solver->displacement_mm(4).x, 0);
        const OrderingReport on_bone = solver->push(std::array{4}, {1, 0, 0});
        EXPECT_EQ(on_bone.status, PushStatus::Rejected);
        EXPECT_EQ(on_bone.moved_elements, 0);
        EXPECT_EQ(solver->displacement_mm(0).x, 0.75);
    }
}

TEST(Orderings, AMovementLimitHalvesTheStepToo) {
    ChainLattice lattice = homogeneous({4, 4, 1}, 0.2);
    lattice.materials[0].max_movement_mm = 1.3;
    for (const Ordering ordering : kAll) {
        if (ordering == Ordering::GibsonConvex) continue;
        const auto solver = make(lattice, ordering);
        EXPECT_EQ(solver->push(std::array{0}, {1.5, 1.5, 0}).step_fraction, 0.5);
        EXPECT_EQ(solver->displacement_mm(0), (Vec3d{0.75, 0.75, 0}));
    }
}

TEST(Orderings, ListsOnAGraphAreTheSameAsOnItsLattice) {
    Random random(kOrderingsSeed);
    const ChainLattice lattice = heterogeneous(random, 10, 0.5);
    const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    for (const Ordering ordering :
         {Ordering::SchillOnce, Ordering::SchillRequeue, Ordering::LiOnce, Ordering::LiRequeue}) {
        const auto on_lattice = make(lattice, ordering);
        const auto on_graph = std::move(make_ordering(*graph, ordering)).value();
        on_lattice->push(std::array{555}, {1, 0.5, -0.25});
        on_graph->push(std::array{555}, {1, 0.5, -0.25});
        for (int e = 0; e < 1000; ++e)
            ASSERT_EQ(on_lattice->displacement_mm(e), on_graph->displacement_mm(e));
        on_graph->reset();
        EXPECT_EQ(on_graph->displacement_mm(555), (Vec3d{0, 0, 0}));
    }
    EXPECT_EQ(make_ordering(*graph, Ordering::Draeger).error().code, ErrorCode::Unsupported);
}

double elastic_energy(const ChainLattice& lattice, std::span<const Vec3f> u) {
    const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    double sum = 0;
    for (std::int32_t i = 0; i < graph->element_count(); ++i)
        for (const ChainNeighbour& link : graph->neighbours(i)) {
            const Vec3f d = u[std::size_t(link.element)] - u[std::size_t(i)];
            sum += double(dot(d, d)) / 4;
        }
    return sum;
}

TEST(Orderings, GibsonsRelaxationLowersTheEnergyAndLeavesWhatIsHeld) {
    const ChainLattice lattice = homogeneous({12, 12, 12}, 0.2);
    const std::int32_t held = number(lattice, {6, 6, 11});
    const auto solver = make(lattice, Ordering::GibsonConvex);
    solver->push(std::array{held}, {0.5, 0, 3});
    std::vector<Vec3f> u;
    for (std::int32_t e = 0; e < 12 * 12 * 12; ++e) {
        const Vec3d mm = solver->displacement_mm(e);
        u.push_back({float(mm.x), float(mm.y), float(mm.z)});
    }
    const std::vector<Vec3f> start = u;
    ElasticLimits limits;
    limits.threshold_mm = 1e-3;
    double energy = elastic_energy(lattice, u);
    for (int sweep = 0; sweep < 20; ++sweep) {
        EXPECT_GT(relax_elastically(lattice, limits, std::array{held}, u), 0);
        const double next = elastic_energy(lattice, u);
        EXPECT_LT(next, energy);
        energy = next;
        EXPECT_EQ(u[std::size_t(held)], start[std::size_t(held)]);
    }
    // Sufficient slack leaves all elements in place: a plastic material.
    std::vector<Vec3f> plastic = start;
    limits = {.compress = 0.21, .stretch = 0.21, .shear = 0.21};
    EXPECT_EQ(relax_elastically(lattice, limits, std::array{held}, plastic), 0);
    EXPECT_EQ(plastic, start);
    // Without held elements, all come to rest at one position.
    limits = {.threshold_mm = 0};
    for (int sweep = 0; sweep < 600; ++sweep) relax_elastically(lattice, limits, {}, u);
    EXPECT_LT(elastic_energy(lattice, u), 1e-3 * energy);
}

TEST(Orderings, WhatAnOrderingCannotDoIsRefused) {
    const auto refuse = [](const ChainLattice& lattice, ErrorCode code) {
        const auto solver = make_ordering(lattice, Ordering::GibsonConvex);
        ASSERT_FALSE(solver.ok());
        EXPECT_EQ(solver.error().code, code) << solver.error().message;
    };
    ChainLattice lattice = homogeneous({3, 3, 3}, 0.2);
    lattice.present.assign(27, 1);
    EXPECT_TRUE(make_ordering(lattice, Ordering::GibsonConvex).ok());
    lattice.present[5] = 0;
    refuse(lattice, ErrorCode::Unsupported);
    lattice = homogeneous({3, 3, 3}, 0.2);
    lattice.materials.push_back(equal_limits(0.1));
    lattice.material.assign(27, 0);
    EXPECT_TRUE(make_ordering(lattice, Ordering::GibsonConvex).ok());
    lattice.material[26] = 1;
    refuse(lattice, ErrorCode::Unsupported);
    refuse({.size = {3, 3, 3}}, ErrorCode::InvalidArgument);
    for (const Ordering ordering : kAll) {
        const auto solver = make(homogeneous({3, 3, 3}, 0.2), ordering);
        EXPECT_EQ(solver->push(std::array{27}, {1, 0, 0}).status, PushStatus::Rejected);
        EXPECT_EQ(solver->push(std::array{-1}, {1, 0, 0}).status, PushStatus::Rejected);
        EXPECT_EQ(solver->push(std::array{0}, {NAN, 0, 0}).status, PushStatus::Rejected);
    }
}

}  // namespace
}  // namespace pliant::test
