// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/chainmail_impl.h"
#include "relax/tool_contact.h"

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "chainmail/relaxing.h"
#include "support/random.h"

namespace pliant::test {
namespace {

TEST(ToolContact, TissueComesToLieAgainstATool) {
    const TaskArena arena(1);
    const Volume volume = block({24, 24, 24}, 0);
    ChainMail tissue = tissue_of(volume, one_material(0.3), arena);
    // A wall below z = 12.5 is pushed down, and a sphere placed into the dent.
    std::vector<Vec3i> pushed;
    for (int y = 9; y < 15; ++y)
        for (int x = 9; x < 15; ++x) pushed.push_back({x, y, 12});
    ASSERT_TRUE(tissue.push_elements(pushed, {0, 0, -3}).ok());
    const RelaxTool ball{{11.5, 11.5, 13}, {11.5, 11.5, 13}, 2.5};
    std::set<Vec3i, Before> inside;
    const auto distance = [&](Vec3i e) {
        return distance_to_tool(volume.grid, lattice_of(tissue), e, ball);
    };
    for (const auto& [e, u] : displacements(lattice_of(tissue)))
        if (distance(e) < ball.radius_mm) inside.insert(e);
    EXPECT_TRUE(relaxed(tissue, {.max_sweeps = 20000, .tools = {ball}}).settled);
    double nearest = 1e9;
    for (const auto& [e, u] : displacements(lattice_of(tissue)))
        if (!inside.contains(e)) nearest = std::min(nearest, distance(e));
    EXPECT_GE(nearest, ball.radius_mm);
    EXPECT_LT(nearest, ball.radius_mm + 1e-4);
    // Without the ball the tissue returns completely.
    EXPECT_TRUE(relaxed(tissue, {.max_sweeps = 20000}).settled);
    EXPECT_EQ(tissue.moved_box(), Box3i{});
}

TEST(ToolContact, SegmentsAreAsFarApartAsTheirNearestPoints) {
    Random random(9);
    for (int n = 0; n < 300; ++n) {
        Vec3d p[4];
        for (Vec3d& point : p) point = random.vector(5);
        if (n % 5 == 0) p[1] = p[0];
        if (n % 7 == 0) p[3] = p[2];
        if (n % 11 == 0) p[3] = p[2] + 2.0 * (p[1] - p[0]);
        double least = 1e9;
        constexpr int kSteps = 200;
        for (int s = 0; s <= kSteps; ++s)
            for (int t = 0; t <= kSteps; ++t) {
                const Vec3d d = p[0] + (double(s) / kSteps) * (p[1] - p[0]) - p[2] -
                                (double(t) / kSteps) * (p[3] - p[2]);
                least = std::min(least, dot(d, d));
            }
        const double found = squared_distance_of_segments(p[0], p[1], p[2], p[3]);
        EXPECT_LE(found, least + 1e-9) << n;
        EXPECT_LE(std::sqrt(least), std::sqrt(found) + 0.06) << n;
    }
}

}  // namespace
}  // namespace pliant::test
