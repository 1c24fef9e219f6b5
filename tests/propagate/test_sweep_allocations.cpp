// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A push or a frame of a drag doesn't allocate after warm-up.
// Covers: propagate/propagate_sweep.cpp, propagate/propagate_rounded.cpp, propagate/drag.cpp.

#include <pliant/chainmail.h>

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "support/count_allocations.h"

namespace pliant::test {
namespace {

/// A history keeps each step, which needs memory.
const ChainMailSettings kNoHistory = [] {
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    return settings;
}();

class SweepAllocations : public ::testing::TestWithParam<int> {
  protected:
    void SetUp() override {
        volume.grid.size = {64, 64, 64};
        std::vector<std::int16_t> values(voxel_count(volume.grid));
        for (std::size_t n = 0; n < values.size(); ++n)
            values[n] = std::int16_t(n % 97 < 60 ? 40 : -80 + int(n % 13));
        volume.voxels = values;
    }
    /// Allocations of the last of a few equal repetitions.
    template <class Turn>
    std::int64_t allocations_of(const Turn& turn) {
        std::int64_t before = 0;
        for (int n = 0; n < 4; ++n) {
            before = allocation_count();
            turn();
        }
        return allocation_count() - before;
    }
    Volume volume;
    // Near the border, so that bricks beyond it come and go too.
    const std::array<Vec3i, 2> elements = {{{60, 30, 30}, {61, 30, 30}}};
};

TEST_P(SweepAllocations, NoneInPushesFromRestAfterTheFirst) {
    const TaskArena arena(GetParam());
    ChainMail tissue = std::move(ChainMail::create(volume, kNoHistory, arena)).value();
    std::int64_t moved = 0;
    EXPECT_EQ(allocations_of([&] {
                  tissue.reset();
                  moved = tissue.push_elements(elements, {4, -3, 2})->moved_elements;
              }),
              0);
    EXPECT_GT(moved, 5000);
}

TEST_P(SweepAllocations, NoneInPushesUnderRoundedLimitsAfterTheFirst) {
    const TaskArena arena(GetParam());
    ChainMailSettings settings = kNoHistory;
    settings.limits = LinkLimits::Rounded;
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    EXPECT_EQ(allocations_of([&] {
                  tissue.reset();
                  EXPECT_TRUE(tissue.push_elements(elements, {4, -3, 2}).ok());
                  EXPECT_TRUE(tissue.push_elements(elements, {-4, 3, -2}).ok());
              }),
              0);
}

TEST_P(SweepAllocations, NoneInPushesToAndFroAfterTheFirst) {
    const TaskArena arena(GetParam());
    ChainMail tissue = std::move(ChainMail::create(volume, kNoHistory, arena)).value();
    EXPECT_EQ(allocations_of([&] {
                  EXPECT_TRUE(tissue.push_elements(elements, {4, -3, 2}).ok());
                  EXPECT_TRUE(tissue.push_elements(elements, {-4, 3, -2}).ok());
              }),
              0);
}

TEST_P(SweepAllocations, NoneInFramesOfADrag) {
    const TaskArena arena(GetParam());
    ChainMail tissue = std::move(ChainMail::create(volume, kNoHistory, arena)).value();
    ASSERT_TRUE(tissue.grab_elements(elements, 8).ok());
    EXPECT_EQ(allocations_of([&] {
                  EXPECT_TRUE(tissue.drag_to({4, -3, 2}).ok());
                  EXPECT_TRUE(tissue.drag_to({-1, 2, 0}).ok());
              }),
              0);
}

INSTANTIATE_TEST_SUITE_P(Threads, SweepAllocations, ::testing::Values(1, 2));

TEST(SweepAllocationsCounter, CountsWhatIsAllocated) {
    const std::int64_t before = allocation_count();
    const auto memory = std::make_unique<std::array<int, 100>>();
    EXPECT_GT(allocation_count(), before) << memory.get();
}

}  // namespace
}  // namespace pliant::test
