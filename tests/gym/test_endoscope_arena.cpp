// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Endoscopes in an arena: the same bits for any number of threads, eyes that are never in tissue,
// and calls that fail without an effect.
// Covers: gym/endoscope_s*.cpp.

#include <algorithm>
#include <limits>
#include <span>

#include "gym/lumen.h"

namespace pliant::test {
namespace {

EndoscopeArenaSettings all_pictures(int count) {
    EndoscopeArenaSettings s;
    s.count = count;
    s.width = 20;
    s.height = 18;
    s.has_normals = s.has_flow = true;
    return s;
}

std::unique_ptr<EndoscopeArena> made(const Volume& scan, const EndoscopeArenaSettings& settings,
                                     const TaskArena& threads) {
    auto arena = EndoscopeArena::create(scan, settings, threads);
    EXPECT_TRUE(arena.ok()) << arena.error().message;
    for (int n = 0; n < settings.count; ++n) {
        const Status placed = (*arena)->place(n, start_in(scan));
        EXPECT_TRUE(placed.ok()) << placed.error().message;
    }
    return std::move(*arena);
}

TEST(EndoscopeArena, GivesTheSameBitsForAnyNumberOfThreadsAndEndoscopes) {
    const Volume scan = bent_tube();
    for (const bool deforms : {true, false}) {
        SCOPED_TRACE(deforms ? "deforming, seed 11" : "rigid, seed 11");
        EndoscopeArenaSettings settings = all_pictures(3);
        settings.deforms = deforms;
        settings.relax_sweeps = 2;
        const TaskArena one(1), two(2), five(5);
        std::vector<std::vector<std::byte>> first;
        for (const TaskArena* threads : {&one, &two, &five}) {
            const auto arena = made(scan, settings, *threads);
            Random random(11);
            for (int step = 0; step < 25; ++step) {
                const Status s = arena->step(random_actions(random, 3));
                ASSERT_TRUE(s.ok()) << s.error().message;
                const auto result = result_of_endoscopes(*arena);
                if (threads == &one) {
                    first.push_back(result);
                } else {
                    ASSERT_EQ(result, first[std::size_t(step)]) << "step " << step;
                }
            }
        }
        // The second endoscope alone.
        settings.count = 1;
        const auto alone = made(scan, settings, two);
        const auto all = made(scan, all_pictures(3), two);
        settings = all_pictures(3);
        settings.deforms = deforms;
        settings.relax_sweeps = 2;
        const auto three = made(scan, settings, two);
        Random random(11);
        for (int step = 0; step < 10; ++step) {
            const auto actions = random_actions(random, 3);
            ASSERT_TRUE(three->step(actions).ok());
            ASSERT_TRUE(alone->step(std::span(actions).subspan(4, 4)).ok());
            EXPECT_EQ(three->hash(1), alone->hash(0));
        }
        EXPECT_NE(three->hash(0), three->hash(1));
    }
}

TEST(EndoscopeArena, TheEyeIsNeverInTissue) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    for (const bool deforms : {true, false})
        for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
            SCOPED_TRACE((deforms ? "deforming, seed " : "rigid, seed ") + std::to_string(seed));
            EndoscopeArenaSettings settings;
            settings.deforms = deforms;
            settings.width = settings.height = 4;
            settings.relax_sweeps = int(seed);
            const auto arena = made(scan, settings, threads);
            Random random(seed);
            int touched = 0, stopped = 0;
            double largest = 0;
            for (int step = 0; step < 150; ++step) {
                const Status s = arena->step(random_actions(random, 1));
                ASSERT_TRUE(s.ok()) << s.error().message;
                const EndoscopeState& state = arena->state(0);
                const Vec3d ijk = voxel_from_world(scan.grid, state.pose.eye_mm);
                EXPECT_LT(sample_linear(arena->volume(0), ijk), -500) << "step " << step;
                for (int a = 0; a < 3; ++a) {
                    EXPECT_GE(ijk[a], 0);
                    EXPECT_LE(ijk[a], scan.grid.size[a] - 1);
                }
                EXPECT_NEAR(norm(state.pose.look), 1, 1e-12);
                EXPECT_NEAR(dot(state.pose.look, state.pose.up), 0, 1e-12);
                EXPECT_EQ(state.is_touching, norm(state.force_n) > 0);
                touched += state.is_touching;
                stopped += state.is_stopped;
                largest = std::max(largest, state.max_displacement_mm);
            }
            EXPECT_GT(touched, 0);
            EXPECT_GT(stopped, 0);
            EXPECT_EQ(largest > 0.5, deforms);
        }
}

TEST(EndoscopeArena, RigidWallsKeepTheTipAtItsRadius) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    EndoscopeArenaSettings settings;
    settings.deforms = false;
    settings.width = settings.height = 1;
    const auto arena = made(scan, settings, threads);
    const RayCaster rays(scan, threads);
    Random random(5);
    for (int step = 0; step < 100; ++step) {
        ASSERT_TRUE(arena->step(random_actions(random, 1)).ok());
        const auto wall =
            rays.nearest_surface(arena->state(0).pose.eye_mm, settings.radius_mm - 0.05, -500);
        EXPECT_FALSE(wall.has_value()) << "seed 5, step " << step;
    }
}

TEST(EndoscopeArena, ActionsTurnAndAdvanceAsDescribed) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    EndoscopeArenaSettings settings;
    settings.width = settings.height = 1;
    settings.control_hz = 10;
    const auto arena = made(scan, settings, threads);
    const EndoscopePose at{world_from_voxel(scan.grid, {17.5, 17.5, 20}), {0, 0, 1}, {0, -1, 0}};
    const Vec3d right = cross(at.look, at.up);
    const auto after = [&](std::vector<double> action) {
        EXPECT_TRUE(arena->place(0, at).ok());
        EXPECT_TRUE(arena->step(action).ok());
        return arena->state(0).pose;
    };
    const double c = std::cos(0.1), s = std::sin(0.1);
    EXPECT_LT(norm(after({5, 0, 0, 0}).eye_mm - at.eye_mm - 0.5 * at.look), 1e-12);
    EXPECT_LT(norm(after({0, 0, 0, 1}).look - (c * at.look + s * right)), 1e-12);
    EXPECT_LT(norm(after({0, 0, 1, 0}).look - (c * at.look + s * at.up)), 1e-12);
    EXPECT_LT(norm(after({0, 1, 0, 0}).up - (c * at.up + s * right)), 1e-12);
    EXPECT_LT(norm(after({0, 1, 0, 0}).look - at.look), 1e-12);
}

TEST(EndoscopeArena, ALoadedStateContinuesLikeTheSavedOne) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    for (const bool deforms : {true, false}) {
        EndoscopeArenaSettings settings = all_pictures(1);
        settings.deforms = deforms;
        settings.has_flow = false;  // that of the first step is 0
        const auto arena = made(scan, settings, threads), other = made(scan, settings, threads);
        Random random(21);
        for (int step = 0; step < 40; ++step)
            ASSERT_TRUE(arena->step(random_actions(random, 1)).ok());
        const auto state = arena->save_state(0);
        ASSERT_TRUE(state.ok()) << state.error().message;
        const Status loaded = other->load_state(0, *state);
        ASSERT_TRUE(loaded.ok()) << loaded.error().message;
        EXPECT_EQ(other->hash(0), arena->hash(0));
        ASSERT_TRUE(other->look().ok());
        EXPECT_EQ(result_of_endoscopes(*other), result_of_endoscopes(*arena));
        for (int step = 0; step < 20; ++step) {
            std::vector<double> actions = random_actions(random, 1);
            if (step % 3 == 0) actions[0] = 0;  // relaxation alone
            ASSERT_TRUE(arena->step(actions).ok());
            ASSERT_TRUE(other->step(actions).ok());
            ASSERT_EQ(result_of_endoscopes(*other), result_of_endoscopes(*arena))
                << "seed 21, step " << step;
        }
        auto damaged = *state;
        damaged[4] ^= std::byte{1};
        const std::uint64_t before = other->hash(0);
        EXPECT_EQ(other->load_state(0, damaged).error().code, ErrorCode::Unreadable);
        damaged = *state;
        damaged.pop_back();
        EXPECT_EQ(other->load_state(0, damaged).error().code, ErrorCode::Unreadable);
        EXPECT_EQ(other->hash(0), before);
    }
}

TEST(EndoscopeArena, EndoscopesThatDontMoveKeepAllTheyHave) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    const auto arena = made(scan, all_pictures(2), threads);
    Random random(31);
    for (int step = 0; step < 12; ++step) ASSERT_TRUE(arena->step(random_actions(random, 2)).ok());
    const std::uint64_t hashes[] = {arena->hash(0), arena->hash(1)};
    const auto depth = arena->pictures().depth_mm;
    const std::vector<float> before(depth.begin(), depth.end());
    const std::uint8_t moves[] = {0, 1};
    ASSERT_TRUE(arena->step(random_actions(random, 2), moves).ok());
    EXPECT_EQ(arena->hash(0), hashes[0]);
    EXPECT_NE(arena->hash(1), hashes[1]);
    const auto half = std::ptrdiff_t(before.size() / 2);
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + half, depth.begin()));
    EXPECT_FALSE(std::equal(before.begin() + half, before.end(), depth.begin() + half));
}

TEST(EndoscopeArena, PlacesAnEndoscopeInTissueAtRest) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = made(scan, all_pictures(1), threads);
    ASSERT_TRUE(arena->look().ok());
    const auto fresh = result_of_endoscopes(*arena);
    for (int step = 0; step < 30; ++step)
        ASSERT_TRUE(arena->step(std::vector<double>{10, 0, 0, step < 10 ? 2.0 : 0}).ok());
    EXPECT_GT(arena->state(0).max_displacement_mm, 0);
    ASSERT_TRUE(arena->place(0, start_in(scan)).ok());
    ASSERT_TRUE(arena->look().ok());
    EXPECT_EQ(result_of_endoscopes(*arena), fresh);
    EXPECT_EQ(hash_volume(arena->volume(0)), hash_volume(scan));
}

TEST(EndoscopeArena, RefusesBadInputWithoutAnEffect) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = made(scan, all_pictures(1), threads);
    ASSERT_TRUE(arena->step(std::vector<double>{10, 0, 0, 0}).ok());
    const std::uint64_t hash = arena->hash(0);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refused = [&](const Status& status, const char* field) {
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(status.error().field, field);
        EXPECT_EQ(arena->hash(0), hash);
    };
    refused(arena->step(std::vector<double>{1, 2, 3}), "actions");
    refused(arena->step(std::vector<double>{1, 2, 3, nan}), "actions");
    refused(arena->step(std::vector<double>{1e9, 0, 0, 0}), "actions");
    refused(arena->step(std::vector<double>{0, 0, 0, 0}, std::vector<std::uint8_t>{1, 1}), "moves");
    refused(arena->place(0, {.eye_mm = world_from_voxel(scan.grid, {0, 0, 0})}), "eye_mm");
    refused(arena->place(0, {.eye_mm = {1e6, 0, 0}}), "eye_mm");
    refused(arena->place(0, {.eye_mm = {nan, 0, 0}}), "pose");
    refused(arena->place(0, {.eye_mm = start_in(scan).eye_mm, .look = {0, 0, 0}}), "pose");
    const auto error_of = [&](auto change) {
        EndoscopeArenaSettings s;
        change(s);
        const auto refusal = EndoscopeArena::create(scan, s, threads);
        return refusal.ok() ? "" : refusal.error().field;
    };
    EXPECT_EQ(error_of([](auto& s) { s.count = 0; }), "count");
    EXPECT_EQ(error_of([](auto& s) { s.width = 0; }), "width");
    EXPECT_EQ(error_of([](auto& s) { s.control_hz = 0; }), "control_hz");
    EXPECT_EQ(error_of([](auto& s) { s.radius_mm = -1; }), "radius_mm");
    EXPECT_EQ(error_of([](auto& s) { s.relax_sweeps = -1; }), "relax_sweeps");
    EXPECT_EQ(error_of([](auto& s) { s.field_of_view_deg = 180; }), "field_of_view_deg");
    EXPECT_EQ(error_of([](auto& s) { s.materials = ChainMailSettings{.scale = 2}; }), "scale");
}

TEST(EndoscopeArena, PushesOfOtherToolsMoveTissueButNeverOntoTheEye) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    const auto arena = made(scan, all_pictures(1), threads);
    const Vec3d eye = arena->state(0).pose.eye_mm;
    const Vec3d wall = eye + Vec3d{0, 6.5, 6};
    const auto pushed = arena->push(0, {wall, {0, 2, 0}, 2});
    ASSERT_TRUE(pushed.ok()) << pushed.error().message;
    EXPECT_GT(pushed->moved_elements, 0);
    EXPECT_GT(arena->state(0).max_displacement_mm, 1.5);
    const Vec3d near = eye + Vec3d{5, 0, 0};
    ASSERT_TRUE(arena->place(0, {.eye_mm = near, .look = {0, 0, 1}}).ok());
    const std::uint64_t hash = arena->hash(0);
    const auto onto = arena->push(0, {near + Vec3d{3, 0, 0}, {-4, 0, 0}, 2});
    ASSERT_FALSE(onto.ok()) << onto->step_fraction << " " << onto->moved_elements << onto->message;
    EXPECT_EQ(onto.error().field, "push");
    EXPECT_EQ(arena->hash(0), hash);
    ASSERT_TRUE(arena->step(std::vector<double>{0, 0, 0, 0}).ok());
    EXPECT_LT(sample_linear(arena->volume(0), voxel_from_world(scan.grid, near)), -500);
}

}  // namespace
}  // namespace pliant::test
