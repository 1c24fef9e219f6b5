// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs by direction against transversely isotropic finite elements.
// Covers: fit/box.cpp.

#include <gtest/gtest.h>

#include "fibre_block.h"

namespace pliant::test {
namespace {

TEST(Fibres, SpringsByDirectionFollowAnAnisotropicSolid) {
    const TaskArena arena(2);
    const results::FibreBlock block{.side = 6};
    const auto by_direction = results::fibre_problem(block, true, arena);
    ASSERT_TRUE(by_direction.ok()) << by_direction.error().message;
    const auto found = fit(*by_direction, GaussNewton{}, arena);
    ASSERT_TRUE(found.ok()) << found.error().message;
    const auto one_group = results::fibre_problem(block, false, arena);
    const auto uniform = fit(*one_group, GaussNewton{}, arena);
    ASSERT_TRUE(uniform.ok());
    const FitCaseErrors& other = found->at.cases.back();
    ASSERT_TRUE(other.held_out);
    EXPECT_LT(other.average_percent, 0.05 * other.still_average_percent);
    EXPECT_LT(other.average_percent, 0.3 * uniform->at.cases.back().average_percent);
    // The closed form is that of an infinite lattice.
    const auto expected = block.closed_form();
    for (std::size_t g = 0; g < 4; ++g) {
        EXPECT_EQ(found->at_bound[g], FitBound::None);
        EXPECT_NEAR(found->values[g], expected[g], 0.25 * expected[g]) << g;
    }
    for (const FitDirection& direction : found->directions)
        EXPECT_GT(direction.influence, kMinInfluence);
}

/// A column of 2 x 2 nodes along z, so that equal forces on its end are an even traction. Without
/// contraction across, the held foot leaves the uniaxial state as it is.
FitBox column(Vec3d fibre) {
    return {.size = {2, 2, 6},
            .spacing_mm = {10, 10, 10},
            .young_modulus_pa = 20e3,
            .poisson_ratio = 0,
            .fibre = fibre,
            .fibre_young_modulus_pa = 90e3,
            .fibre_poisson_ratio = 0,
            .fibre_shear_modulus_pa = 7e3,
            .loads = {{.name = "pull", .force_n = {0, 0, 0.2}, .nodes_across = 2}}};
}

/// Displacement of the column's end along z [mm].
double pulled_mm(Vec3d fibre) {
    const TaskArena arena(1);
    const auto box = fit_box(column(fibre), arena);
    EXPECT_TRUE(box.ok()) << box.error().message;
    return 1e3 * box->problem.cases()[0].target.back().z;
}

TEST(Fibres, ABoxIsPulledAlongAndAcrossAsInClosedForm) {
    const double stress = 0.2 / (10e-3 * 10e-3), length = 50;
    EXPECT_NEAR(pulled_mm({0, 0, 3}), length * stress / 90e3, 1e-9);
    EXPECT_NEAR(pulled_mm({0, -1, 0}), length * stress / 20e3, 1e-9);
    EXPECT_NEAR(pulled_mm({1, 1, 0}), length * stress / 20e3, 1e-9);
    EXPECT_NEAR(pulled_mm({0, 0, 0}), length * stress / 20e3, 1e-9);
}

TEST(Fibres, ABoxStartsAtTheModulusAlongEachLink) {
    const TaskArena arena(1);
    FitBox box = column({0, 0, 1});
    box.groups = FitBoxGroups::Directions;
    const auto made = fit_box(box, arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto groups = made->problem.groups();
    const auto start = [&](const std::string& name) {
        for (const FitGroup& group : groups)
            if (group.name == name) return group.start;
        ADD_FAILURE() << name;
        return 0.0;
    };
    EXPECT_NEAR(start("edges x"), 0.4 * 20e3 * 10e-3, 1e-9);
    EXPECT_NEAR(start("edges z"), 0.4 * 90e3 * 10e-3, 1e-9);
    // Half way, c² = 1/2: 4/E = 1/E_a + 1/E + 1/G_a.
    EXPECT_NEAR(start("diagonals yz"), 0.4 * 10e-3 * 4 / (1 / 90e3 + 1 / 20e3 + 1 / 7e3), 1e-9);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        EXPECT_DOUBLE_EQ(groups[g].start, made->closed_form[g]);
        EXPECT_NEAR(groups[g].high / groups[g].low, 100, 1e-9);
    }
}

TEST(Fibres, LargeBoxesHaveThemToo) {
    // Beyond 2000 nodes another solver is used.
    const TaskArena arena(2);
    FitBox box = column({0, 0, 1});
    box.size = {2, 2, 520};
    const auto made = fit_box(box, arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const double stress = 0.2 / (10e-3 * 10e-3);
    EXPECT_NEAR(1e3 * made->problem.cases()[0].target.back().z, 5190 * stress / 90e3, 1e-4);
}

TEST(Fibres, ABoxWithoutAPositiveEnergyIsRefused) {
    const TaskArena arena(1);
    FitBox box = column({1, 0, 0});
    box.fibre_poisson_ratio = 2;
    const auto made = fit_box(box, arena);
    ASSERT_FALSE(made.ok());
    EXPECT_NE(made.error().message.find("fibre_poisson_ratio"), std::string::npos)
        << made.error().message;
}

}  // namespace
}  // namespace pliant::test
