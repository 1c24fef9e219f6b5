// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The published orderings beside the exact solution: where they find it, and where they do not.

#include <gtest/gtest.h>
#include <pliant/chainmail_orderings.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/random.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kSeed = 20260401;

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

/// The exact solution and what an ordering makes of the same pushes.
struct Comparison {
    std::int64_t violated_links = 0;
    double max_violation = 0;
    double max_distance = 0;  ///< from the exact place, in any component
    std::int64_t exact_violated_links = 0;
};

struct Step {
    std::vector<std::int32_t> elements;
    Vec3d push_mm;
};

constexpr double kTolerance = 1e-4;

Comparison compare(const ChainLattice& lattice, Ordering ordering, std::span<const Step> steps) {
    const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    EXPECT_TRUE(graph.ok());
    GraphChainMail exact(*graph);
    const TaskArena arena(1);
    const auto solver = make(lattice, ordering);
    for (const Step& step : steps) {
        EXPECT_EQ(exact.push(step.elements, step.push_mm, arena)->status, PushStatus::Applied);
        const OrderingReport report = solver->push(step.elements, step.push_mm);
        EXPECT_EQ(report.status, PushStatus::Applied);
        EXPECT_FALSE(report.stopped_early);
    }
    Comparison result;
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

/// Blobs of four materials, slack from 0.02 to 0.4 of a link.
ChainLattice heterogeneous(Random& random, int side) {
    ChainLattice lattice{.size = {side, side, side}};
    for (const double fraction : {0.02, 0.05, 0.15, 0.4})
        lattice.materials.push_back(equal_limits(fraction));
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
        EXPECT_LT(found.max_distance, 1e-5);
    }
}

TEST(Orderings, FromRestInOneMaterialGibsonsListsAreExactForAnyLimitsOfABox) {
    const Ordering orderings[] = {Ordering::GibsonConvex, Ordering::GibsonLists};
    for (std::uint64_t n = 0; n < 300 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kSeed + n));
        compare_homogeneous(kSeed + n, orderings);
    }
}

TEST(Orderings, FromRestWithEqualLimitsInAllDirectionsEveryOrderingIsExact) {
    Random random(kSeed);
    for (int n = 0; n < 60; ++n) {
        const ChainLattice lattice =
            homogeneous({random.whole(2, 12), random.whole(2, 12), random.whole(1, 12)}, 0.2);
        const Step step{{random.whole(0, lattice.size.x * lattice.size.y * lattice.size.z - 1)},
                        random.vector(2)};
        for (const Ordering ordering : kAll) {
            SCOPED_TRACE(std::string(name_of(ordering)) + ", seed " + std::to_string(kSeed) +
                         ", instance " + std::to_string(n));
            EXPECT_LT(compare(lattice, ordering, {{step}}).max_distance, 1e-5);
        }
    }
}

}  // namespace
}  // namespace pliant::test
