// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random tips in random bent tubes: soft walls and stiff tips, long steps and short ones. Sub-steps
// are the scene's own choice, and no tip gets beyond the wall. PLIANT_SEED and PLIANT_INSTANCES run
// others.
// Covers: catheter/near_wall.cpp, catheter/wall_contact.cpp.

#include <gtest/gtest.h>
#include <pliant/models/catheter.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "support/catheter_depth.h"
#include "support/inside.h"
#include "support/random.h"
#include "support/search.h"

namespace pliant::test {
namespace {

struct Instance {
    VesselWall wall;
    CatheterSettings settings;
    CatheterCommand command;
};

Instance random_instance(std::uint64_t seed) {
    Random random(seed);
    const double inner = random.real(2.5, 6), thickness = random.real(0.8, 2);
    Instance made_one;
    made_one.wall =
        made(swept_tube(bent_way({.inner_mm = inner,
                                  .from_mm = 0,
                                  .to_mm = 20,
                                  .radius_mm = inner + thickness + random.real(8, 20),
                                  .angle_rad = random.real(0.5, 2),
                                  .last_mm = 20}),
                        {.thickness_mm = thickness, .layers = 2, .sectors = random.whole(10, 20)}));
    CatheterSettings& s = made_one.settings;
    s.catheter.length_mm = 80;
    s.catheter.segment_mm = random.real(2, 4);
    s.catheter.radius_mm = random.real(0.4, 1.2);
    s.catheter.bend_n_mm2 = random.ratio(5, 400);
    s.catheter.tip_bend_n_mm2 = s.catheter.bend_n_mm2 * random.ratio(0.05, 1);
    s.catheter.tip_mm = random.real(10, 30);
    s.catheter.friction = random.real(0, 0.3);
    s.wall.young_modulus_pa = random.ratio(1e5, 2e6);
    s.wall.support_pa_per_mm = random.ratio(500, 20000);
    s.wall.density_g_mm3 = random.ratio(0.01, 0.05);
    s.time_step_s = random.ratio(0.0005, 0.005);
    s.local = random.whole(0, 3) > 0;
    s.entry = {{0, 0, 4}, {0, 0, 1}, 5};
    const double angle = random.real(0, 2 * std::numbers::pi), bend = random.real(0, 90);
    made_one.command = {.insert_mm_s = random.ratio(20, 120),
                        .rotate_deg_s = random.real(-90, 90),
                        .bend_first_deg = bend * std::cos(angle),
                        .bend_second_deg = bend * std::sin(angle)};
    return made_one;
}

TEST(CatheterScene, NoTipGetsBeyondTheWall) {
    const test::Search search(1, 12);
    const TaskArena arena(1);
    for (int n = 0; n < search.instances; ++n) {
        const std::uint64_t seed = search.seed(n);
        const Instance instance = random_instance(seed);
        CatheterScene scene = made(CatheterScene::create(instance.wall, instance.settings));
        ASSERT_TRUE(scene.command(instance.command).ok());
        double depth = -1e9, reported = -1e9;
        std::int64_t inverted = 0;
        for (int step = 0; scene.quick_measures().inserted_mm < 65; ++step) {
            const Status status = scene.step(1, arena);
            ASSERT_TRUE(status.ok()) << "seed " << seed << ": " << status.error().message;
            const CatheterMeasures m = scene.quick_measures();
            reported = std::max(reported, m.depth_mm);
            if (m.left_end > 0) break;
            if (step % 20 != 19) continue;
            depth = std::max(depth, depth_beyond_wall(scene));
            inverted = std::max(inverted, scene.measures().inverted);
        }
        const CatheterMeasures end = scene.measures();
        const std::string text = "seed " + std::to_string(seed) + ": " + std::to_string(depth) +
                                 " mm beyond the wall, reported " + std::to_string(reported) +
                                 ", wall moved " + std::to_string(end.wall_moved_mm) +
                                 " mm, volume " + std::to_string(100 * end.volume.largest) +
                                 " % off, inverted " + std::to_string(inverted) + ", " +
                                 std::to_string(scene.settings().sub_steps) + " sub-steps";
        if (search.is_by_hand) std::printf("%s\n", text.c_str());
        EXPECT_LE(std::max(depth, reported), 0.1) << text;
        EXPECT_EQ(inverted, 0) << text;
    }
}

}  // namespace
}  // namespace pliant::test
