// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs by direction against transversely isotropic finite elements.

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

}  // namespace
}  // namespace pliant::test
