// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An arena whose n-th allocation fails: LimitExceeded, never half a state, and pictures that are
// right as soon as there is memory again.
// Covers: gym/catheter_arena.cpp, gym/endoscope_arena.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "gym/lumen.h"
#include "support/each_allocation_of.h"

namespace pliant::test {
namespace {

EndoscopeArenaSettings settings_of(bool deforms) {
    EndoscopeArenaSettings settings;
    settings.width = 16;
    settings.height = 12;
    settings.deforms = deforms;
    settings.has_normals = settings.has_flow = true;
    return settings;
}

using Arena = std::unique_ptr<EndoscopeArena>;

/// Pictures of the present state, without flow.
std::vector<std::byte> look_of(const EndoscopeArena& arena) {
    const EndoscopePictures p = arena.pictures();
    std::vector<std::byte> all = bytes_of(p.colour);
    for (const auto& part : {bytes_of(p.depth_mm), bytes_of(p.normals)})
        all.insert(all.end(), part.begin(), part.end());
    return all;
}

class ArenaOutOfMemory : public ::testing::TestWithParam<int> {
  protected:
    Arena made(bool deforms) const {
        auto arena = EndoscopeArena::create(m_scan, settings_of(deforms), m_threads);
        EXPECT_TRUE(arena.ok()) << arena.error().message;
        EXPECT_TRUE((*arena)->place(0, start_in(m_scan)).ok());
        return std::move(*arena);
    }
    /// An arena after some steps, which have moved tissue.
    Arena moved(bool deforms) const {
        Arena arena = made(deforms);
        for (int n = 0; n < 6; ++n) EXPECT_TRUE(arena->step(ahead()).ok());
        return arena;
    }
    static std::span<const double> ahead() {
        static constexpr double kAction[] = {40, 0.2, 1.2, 0.4};
        return kAction;
    }
    Push push() const {
        return {.point_mm = world_from_voxel(m_scan.grid, {26, 17, 16}),
                .push_mm = {1.5, 0.3, 0},
                .sphere_radius_mm = 2};
    }

    /// Expects that an arena is equal to one that has just loaded its state, now and later.
    void expect_whole(EndoscopeArena& arena, bool deforms) const {
        ASSERT_TRUE(arena.look().ok());
        const auto state = arena.save_state(0);
        ASSERT_TRUE(state.ok());
        const Arena twin = made(deforms);
        ASSERT_TRUE(twin->load_state(0, *state).ok());
        ASSERT_TRUE(twin->look().ok());
        EXPECT_EQ(hash_volume(arena.volume(0)), hash_volume(twin->volume(0)));
        EXPECT_EQ(look_of(arena), look_of(*twin));
        for (int n = 0; n < 2; ++n) {
            ASSERT_TRUE(arena.step(ahead()).ok());
            ASSERT_TRUE(twin->step(ahead()).ok());
        }
        EXPECT_EQ(result_of_endoscopes(arena), result_of_endoscopes(*twin));
    }

    /// Lets an operation fail at each of its allocations. Afterwards the hash is that of before or
    /// that of success, or anything if `is_partial`.
    template <class Operation>
    void fail_each(bool deforms, const Operation& operation, bool is_partial = false) const {
        const Arena twin = moved(deforms);
        const std::uint64_t before = twin->hash(0);
        const std::int64_t first = allocation_count();
        ASSERT_TRUE(operation(*twin).ok());
        const std::int64_t count = allocation_count() - first;
        const std::uint64_t after = twin->hash(0);
        EachAllocation options{.all_up_to = 15, .of_the_rest = 15};
        options.seed = std::random_device{}();
        int failures = 0;
        for (const std::int64_t n : chosen(count, options)) {
            SCOPED_TRACE("allocation " + std::to_string(n) + " of " + std::to_string(count) +
                         ", seed " + std::to_string(options.seed));
            const Arena arena = moved(deforms);
            auto code = std::optional<ErrorCode>();
            {
                const FailingAllocation failing(n);
                const auto result = operation(*arena);
                if (!result.ok()) code = result.error().code;
            }
            if (!code) {  // it could do without that allocation
                EXPECT_EQ(arena->hash(0), after);
                continue;
            }
            ++failures;
            EXPECT_EQ(code, ErrorCode::LimitExceeded);
            if (!is_partial) {
                EXPECT_TRUE(arena->hash(0) == before || arena->hash(0) == after);
            }
            expect_whole(*arena, deforms);
            if (HasFailure()) return;
        }
        EXPECT_EQ(failures > 0, count > 0);
    }

    TaskArena m_threads{GetParam()};
    Volume m_scan = bent_tube();
};

TEST_P(ArenaOutOfMemory, MakesAnArenaOrNone) {
    for (const bool deforms : {true, false}) {
        const Failures failures = fail_each_allocation_of(
            [&] { return EndoscopeArena::create(m_scan, settings_of(deforms), m_threads); },
            {.all_up_to = 40, .of_the_rest = 15});
        EXPECT_GT(failures.failed, 20);
    }
}

TEST_P(ArenaOutOfMemory, AFailedStepLeavesTipTissueAndPicturesThatFit) {
    for (const bool deforms : {true, false})
        fail_each(
            deforms, [](EndoscopeArena& arena) { return arena.step(ahead()); }, true);
}

TEST_P(ArenaOutOfMemory, PlacesAnEndoscopeOrNot) {
    fail_each(true, [&](EndoscopeArena& arena) {
        EndoscopePose pose = start_in(m_scan);
        pose.look = {-0.2, 0.1, 1};
        return arena.place(0, pose);
    });
}

TEST_P(ArenaOutOfMemory, PushesTissueOrNot) {
    fail_each(
        true, [&](EndoscopeArena& arena) { return arena.push(0, push()); }, true);
}

TEST_P(ArenaOutOfMemory, SavesAndLoadsAStateOrNot) {
    const Arena other = moved(true);
    ASSERT_TRUE(other->step(std::vector<double>{30, 0, -1, 1}).ok());
    const auto state = other->save_state(0);
    ASSERT_TRUE(state.ok());
    fail_each(true, [&](EndoscopeArena& arena) { return arena.load_state(0, *state); });
    fail_each(true, [&](EndoscopeArena& arena) { return arena.save_state(0); });
}

TEST_P(ArenaOutOfMemory, FlowAfterAFailedPictureIsThatOfTheStepOrNone) {
    const Arena twin = moved(true);
    const std::int64_t first = allocation_count();
    ASSERT_TRUE(twin->step(ahead()).ok());
    const std::int64_t count = allocation_count() - first;
    int steps = 0;
    // The last allocations are those of the picture.
    for (std::int64_t n = std::max<std::int64_t>(0, count - 30); n < count; ++n) {
        SCOPED_TRACE("allocation " + std::to_string(n) + " of " + std::to_string(count));
        const Arena arena = moved(true);
        bool is_done = false;
        {
            const FailingAllocation failing(n);
            is_done = arena->step(ahead()).ok();
        }
        ASSERT_TRUE(arena->look().ok());
        if (is_done || arena->hash(0) != twin->hash(0)) continue;
        ++steps;
        const EndoscopePictures p = arena->pictures(), expected = twin->pictures();
        for (std::size_t at = 0; at < p.visibility.size(); ++at) {
            if (p.scene_flow_mm[at] != Vec3f{0, 0, 0}) {
                EXPECT_EQ(p.scene_flow_mm[at], expected.scene_flow_mm[at]);
            }
            if (p.flow[2 * at] != 0) {
                EXPECT_EQ(p.flow[2 * at], expected.flow[2 * at]);
            }
        }
    }
    EXPECT_GT(steps, 0);
}

INSTANTIATE_TEST_SUITE_P(Threads, ArenaOutOfMemory, ::testing::Values(1, 2));

}  // namespace
}  // namespace pliant::test
