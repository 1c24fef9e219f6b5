// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter of tetrahedra in a bend: its depth by all triangles, one by one, and a rod beside it.

#include <gtest/gtest.h>
#include <pliant/research/tet_catheter.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "support/inside.h"
#include "support/made.h"

namespace pliant::test {
namespace {

VesselWall bent_tube() {
    const auto way = bent_way({.inner_mm = 4,
                               .from_mm = 0,
                               .to_mm = 30,
                               .radius_mm = 25,
                               .angle_rad = 2 * std::numbers::pi / 3,
                               .last_mm = 24});
    return made(swept_tube(way, {.thickness_mm = 1.2, .layers = 2, .sectors = 12}));
}

CatheterSettings settings(double stiff) {
    CatheterSettings s;
    s.local = false;
    s.catheter.length_mm = 130;
    s.catheter.segment_mm = 2.5;
    s.catheter.radius_mm = 0.8;
    s.catheter.bend_n_mm2 = stiff;
    s.catheter.twist_n_mm2 = 0.7 * stiff;
    s.catheter.tip_bend_n_mm2 = 0.2 * stiff;
    s.entry = {{0, 0, 4}, {0, 0, 1}, 5};
    return s;
}

/// Largest depth of the nodes outside of the guide, and of the midpoints of their edges.
double deepest(const TetCatheter& catheter, const VesselWall& wall) {
    TetMesh now{std::vector<Vec3d>(wall.mesh.nodes_mm.size()), wall.mesh.cells};
    catheter.body().get_positions(now.nodes_mm);
    std::vector<Vec3d> ghost;
    for (const Embedded& e : wall.ghost_positions) ghost.push_back(position_of(e, now));
    const TetMesh body = catheter.mesh();
    const auto at = [&](std::int32_t n) { return body.nodes_mm[std::size_t(n)]; };
    double most = -1e9;
    for (const auto& cell : body.cells) {
        if (cell[0] / 4 <= catheter.first_inserted()) continue;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = 0; b <= a; ++b)
                most = std::max(most,
                                -inside_by(0.5 * (at(cell[a]) + at(cell[b])), ghost, wall.ghost));
    }
    return most;
}

TEST(TetCatheter, StaysInsideOnItsWayThereAndBack) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    TetCatheter catheter = made(TetCatheter::create(wall, settings(100)));
    double depth = -1e9, reported = -1e9;
    for (int n = 0; n < 570; ++n) {
        const Status status = catheter.step({.insert_mm_s = n < 285 ? 300.0 : -300.0}, arena);
        ASSERT_TRUE(status.ok()) << status.error().message;
        reported = std::max(reported, catheter.depth_mm());
        if (n % 28 != 0) continue;
        depth = std::max(depth, deepest(catheter, wall));
        ASSERT_EQ(catheter.measures().inverted, 0);
    }
    std::printf("depth %.4f (reported %.4f) mm\n", depth, reported);
    EXPECT_LE(depth, 0.1);
    EXPECT_LE(reported, 0.1);
    EXPECT_GT(reported, -0.1);  // it touches
}

double turned_about(Rotation from, Rotation to) {
    const Vec3d before = rotated(from, {1, 0, 0}), after = rotated(to, {1, 0, 0}),
                ahead = rotated(to, {0, 0, 1});
    return std::atan2(dot(cross(before, after), ahead), dot(before, after));
}

// Both models in a bend, pushed and turned alike: the wall feels the same.
TEST(TetCatheter, LiesAsTheRodDoes) {
    const VesselWall wall = bent_tube();
    const TaskArena arena(1);
    const CatheterSettings s = settings(40);
    CatheterScene rod = made(CatheterScene::create(wall, s));
    TetCatheter body = made(TetCatheter::create(wall, s));
    const auto step = [&](const CatheterCommand& command) {
        ASSERT_TRUE(rod.command(command).ok());
        ASSERT_TRUE(rod.step(1, arena).ok());
        ASSERT_TRUE(body.step(command, arena).ok());
    };
    for (int n = 0; n < 550; ++n) step({.insert_mm_s = n < 350 ? 200.0 : 0.0});
    double apart = 0;
    for (std::size_t n = 0; n < rod.wire_positions().size(); ++n)
        apart = std::max(apart, norm(rod.wire_positions()[n] - body.wire_positions()[n]));
    const double contact = rod.quick_measures().contact_n, of_body = body.measures().contact_n;
    const Rotation tips[] = {rod.tip_frame(), body.tip_frame()};
    for (int n = 0; n < 400; ++n) step({.rotate_deg_s = 300});
    const double turned = turned_about(tips[0], rod.tip_frame()),
                 body_turned = turned_about(tips[1], body.tip_frame());
    std::printf("apart %.3f mm, contact %.3f and %.3f N, tip turned by %.2f and %.2f\n", apart,
                contact, of_body, turned, body_turned);
    EXPECT_LT(apart, 0.5);
    EXPECT_NEAR(of_body, contact, 0.2 * contact);
    EXPECT_GT(body_turned, 1);  // of 120°
    EXPECT_NEAR(body_turned, turned, 0.3);
}

TEST(TetCatheter, RefusesATwistOutOfReach) {
    CatheterSettings s = settings(20);
    s.catheter.twist_n_mm2 = 200;
    const auto made = TetCatheter::create(bent_tube(), s);
    ASSERT_FALSE(made.ok());
    const std::string& said = made.error().message;
    EXPECT_TRUE(said.starts_with("[catheter] twist_n_mm2: expected ") &&
                said.ends_with("found 200"))
        << said;
}

}  // namespace
}  // namespace pliant::test
