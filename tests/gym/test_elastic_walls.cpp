// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Endoscopes whose walls are the elastic scan: the force is that of the same slide by
// make_elastic(), the eye is never in tissue, and any number of threads gives the same bits.
// Covers: gym/endoscope_scope.cpp.

#include <pliant/tissues.h>

#include <cmath>
#include <random>

#include "gym/lumen.h"

namespace pliant::test {
namespace {

EndoscopeArenaSettings elastic_walls(int count = 1) {
    EndoscopeArenaSettings s;
    s.count = count;
    s.width = s.height = 8;
    s.radius_mm = 2.5;
    s.materials = ElasticScanSettings{};
    return s;
}

std::unique_ptr<EndoscopeArena> elastic_arena(const Volume& scan,
                                              const EndoscopeArenaSettings& settings,
                                              const TaskArena& threads) {
    auto arena = EndoscopeArena::create(scan, settings, threads);
    EXPECT_TRUE(arena.ok()) << arena.error().message;
    for (int n = 0; n < settings.count; ++n) EXPECT_TRUE((*arena)->place(n, start_in(scan)).ok());
    return std::move(*arena);
}

TEST(ElasticWalls, TheForceAndTheTissueAreThoseOfTheSameSlides) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    EndoscopeArenaSettings settings = elastic_walls();
    settings.control_hz = 10;
    settings.relax_sweeps = 3;
    const EndoscopePose at{world_from_voxel(scan.grid, {17.5, 17.5, 20}), {0, 1, 0}, {0, 0, 1}};
    const auto arena = elastic_arena(scan, settings, threads);
    ASSERT_TRUE(arena->place(0, at).ok());
    const auto tissue = make_elastic(scan, {}, threads);
    ASSERT_TRUE(tissue.ok());
    Vec3d eye = at.eye_mm;
    for (const double way_mm : {3.0, 1.5, 0.5}) {  // the third one is deep in the wall
        ASSERT_TRUE(arena->step(std::vector<double>{10 * way_mm, 0, 0, 0}).ok());
        const auto slid = (*tissue)->slide(1, {eye, {0, way_mm, 0}, 2.5}, {.threshold_hu = -500});
        ASSERT_TRUE(slid.ok());
        eye = slid->end_mm;
        ASSERT_TRUE((*tissue)->advance({.max_steps = 3}).ok());
    }
    const EndoscopeState& state = arena->state(0);
    EXPECT_LT(norm(state.pose.eye_mm - eye), 1e-12);
    const Vec3d force_n = (*tissue)->force_n(1).value();
    EXPECT_TRUE(state.is_touching);
    EXPECT_EQ(state.force_n, force_n);
    EXPECT_LT(force_n.y, -1e-3);  // the wall pushes back
    EXPECT_LT(std::hypot(force_n.x, force_n.z), -0.5 * force_n.y);
    ASSERT_TRUE((*tissue)->update_deformation().ok());
    EXPECT_EQ(arena->deformation(0)->hash(), (*tissue)->deformation().hash());
    EXPECT_GT(state.max_displacement_mm, 0.5);
}

TEST(ElasticWalls, TheEyeIsNeverInTissueAndTouchedTissuePressesOnIt) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    const std::uint64_t seed = std::random_device{}() % 1'000'000;
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto arena = elastic_arena(scan, elastic_walls(), threads);
    Random random(seed);
    const EndoscopePose at{world_from_voxel(scan.grid, {17.5, 17.5, 20}), {0, 1, 0}, {0, 0, 1}};
    ASSERT_TRUE(arena->place(0, at).ok());
    int touched = 0;
    for (int step = 0; step < 25; ++step) {
        // First into the wall.
        const auto actions =
            step < 3 ? std::vector<double>{30, 0, 0, 0} : random_actions(random, 1);
        ASSERT_TRUE(arena->step(actions).ok());
        const EndoscopeState& state = arena->state(0);
        const Vec3d ijk = voxel_from_world(scan.grid, state.pose.eye_mm);
        EXPECT_LT(sample_linear(arena->volume(0), ijk), -500) << "step " << step;
        if (!state.is_touching) {
            EXPECT_EQ(state.force_n, (Vec3d{0, 0, 0}));
        }
        EXPECT_LT(norm(state.force_n), 10);
        touched += state.is_touching;
    }
    EXPECT_GT(touched, 0);
}

TEST(ElasticWalls, GiveTheSameBitsForAnyNumberOfThreadsAndEndoscopes) {
    const Volume scan = bent_tube();
    const TaskArena one(1), two(2);
    const auto first = elastic_arena(scan, elastic_walls(2), one);
    const auto second = elastic_arena(scan, elastic_walls(2), two);
    const auto alone = elastic_arena(scan, elastic_walls(1), two);
    Random random(11);
    for (int step = 0; step < 8; ++step) {
        const auto actions = random_actions(random, 2);
        ASSERT_TRUE(first->step(actions).ok() && second->step(actions).ok());
        ASSERT_TRUE(alone->step(std::span(actions).subspan(4, 4)).ok());
        ASSERT_EQ(result_of_endoscopes(*first), result_of_endoscopes(*second)) << step;
        EXPECT_EQ(first->hash(1), alone->hash(0));
    }
    EXPECT_NE(first->hash(0), first->hash(1));
}

TEST(ElasticWalls, ReturnWhenTheTipHasLeftAndWhenItIsPlaced) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = elastic_arena(scan, elastic_walls(), threads);
    const EndoscopePose at{world_from_voxel(scan.grid, {17.5, 17.5, 20}), {0, 1, 0}, {0, 0, 1}};
    const auto move = [&](double mm) {
        ASSERT_TRUE(arena->step(std::vector<double>{20 * mm, 0, 0, 0}).ok());
    };
    ASSERT_TRUE(arena->place(0, at).ok());
    move(5);
    const double deep_mm = arena->state(0).max_displacement_mm;
    EXPECT_GT(deep_mm, 0.5);
    move(-5);
    for (int step = 0; step < 40; ++step) move(0);
    EXPECT_LT(arena->state(0).max_displacement_mm, 0.1 * deep_mm);
    EXPECT_FALSE(arena->state(0).is_touching);
    move(5);
    ASSERT_TRUE(arena->place(0, at).ok());
    EXPECT_EQ(hash_volume(arena->volume(0)), hash_volume(scan));
}

TEST(ElasticWalls, AStateIsLoadedAndGoesOnNearTheSavedOne) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = elastic_arena(scan, elastic_walls(), threads);
    const auto other = elastic_arena(scan, elastic_walls(), threads);
    const EndoscopePose at{world_from_voxel(scan.grid, {17.5, 17.5, 20}), {0, 1, 0}, {0, 0, 1}};
    ASSERT_TRUE(arena->place(0, at).ok());
    const std::vector<double> ahead{60, 0, 0, 0};
    ASSERT_TRUE(arena->step(ahead).ok() && arena->step({ahead}).ok());
    const auto state = arena->save_state(0);
    ASSERT_TRUE(state.ok());
    ASSERT_TRUE(other->load_state(0, *state).ok());
    EXPECT_EQ(other->hash(0), arena->hash(0));
    const std::vector<double> more{4, 0, 0, 0};
    ASSERT_TRUE(arena->step(more).ok() && other->step(more).ok());
    EXPECT_NEAR(other->state(0).max_displacement_mm, arena->state(0).max_displacement_mm, 0.05);
    // A state of ChainMail is refused.
    EndoscopeArenaSettings of_chainmail = elastic_walls();
    of_chainmail.materials = ChainMailSettings{};
    const auto chainmail = elastic_arena(scan, of_chainmail, threads);
    EXPECT_FALSE(chainmail->load_state(0, *state).ok());
}

TEST(ElasticWalls, PushesOfOtherToolsMoveTissueButNeverOntoTheEye) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = elastic_arena(scan, elastic_walls(), threads);
    const Vec3d eye = arena->state(0).pose.eye_mm;
    const auto pushed = arena->push(0, {eye + Vec3d{0, 6.5, 6}, {0, 2, 0}, 2});
    ASSERT_TRUE(pushed.ok()) << pushed.error().message;
    EXPECT_GT(arena->state(0).max_displacement_mm, 1.5);
    const Vec3d near = eye + Vec3d{3, 0, 2};
    ASSERT_TRUE(arena->place(0, {.eye_mm = near, .look = {0, 0, 1}}).ok());
    const std::uint64_t hash = arena->hash(0);
    const auto onto = arena->push(0, {near + Vec3d{5, 0, 0}, {-5, 0, 0}, 3});
    ASSERT_FALSE(onto.ok()) << onto->step_fraction << " " << onto->message;
    EXPECT_EQ(onto.error().field, "push");
    EXPECT_EQ(arena->hash(0), hash);
}

TEST(ElasticWalls, BadSettingsAreNamed) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    EndoscopeArenaSettings settings = elastic_walls();
    settings.materials = ElasticScanSettings{.poisson_ratio = 0.5};
    const auto arena = EndoscopeArena::create(scan, settings, threads);
    ASSERT_FALSE(arena.ok());
    EXPECT_NE(arena.error().message.find("poisson_ratio"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
