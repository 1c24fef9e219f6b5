// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reuse of dropped bricks, which may keep former materials and zeros: a used tissue gives the same
// bits as a new one.
// Covers: field/field.cpp, propagate/propagate_sweep.cpp.

#include <pliant/chainmail.h>

#include <gtest/gtest.h>

#include "support/random.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kSweepMemorySeed = 20261121;

class SweepMemory : public ::testing::Test {
  protected:
    void SetUp() override {
        SCOPED_TRACE("seed " + std::to_string(kSweepMemorySeed));
        Random random(kSweepMemorySeed);
        volume.grid.size = {44, 44, 44};
        std::vector<std::int16_t> values(voxel_count(volume.grid));
        for (auto& value : values) value = std::int16_t(random.whole(0, 3) * 90 - 100);
        volume.voxels = values;
    }
    ChainMail make(const ChainMailSettings& settings) const {
        return std::move(ChainMail::create(volume, settings, arena)).value();
    }
    /// Positions far enough apart that their bricks are created in another order.
    static void push(ChainMail& tissue, Vec3d push_mm) {
        for (const double x : {31.5, 8.5})
            ASSERT_TRUE(tissue.push({.point_mm = {x, 21.5, 20.5}, .push_mm = push_mm}).ok());
    }
    /// Leaves dropped bricks behind.
    static void use(ChainMail& tissue, Vec3d push_mm) {
        push(tissue, push_mm);
        tissue.reset();
    }

    TaskArena arena{2};
    Volume volume;
};

TEST_F(SweepMemory, EachComponentStartsFromRestWhicheverMovedBefore) {
    ChainMail used = make({});
    for (const Vec3d push_mm : {Vec3d{3, 0, 0}, Vec3d{0, -2.5, 0}, Vec3d{0, 2, 4}, Vec3d{1, 0, 0},
                                Vec3d{2, -1, 3}, Vec3d{0, 0, -3}}) {
        ChainMail fresh = make({});
        push(fresh, push_mm);
        push(used, push_mm);
        EXPECT_EQ(used.hash(), fresh.hash());
        EXPECT_EQ(used.state().moved_elements, fresh.state().moved_elements);
        used.reset();
    }
}

TEST_F(SweepMemory, DroppedBricksForgetMaterialsThatChangedMeanwhile) {
    ChainMailSettings stiffer;
    stiffer.offset = 0.11;
    stiffer.air_threshold_hu = 0;  // moves elements between entries of the table
    ChainMail used = make({}), fresh = make(stiffer), softer = make({});
    use(used, {3, 1, 0});
    ASSERT_TRUE(used.set_materials(stiffer).ok());
    for (ChainMail* tissue : {&used, &fresh, &softer}) push(*tissue, {3, 1, 0});
    EXPECT_EQ(used.hash(), fresh.hash());
    EXPECT_NE(used.hash(), softer.hash());
}

TEST_F(SweepMemory, DroppedBricksForgetThatElementsWereNotCarvedYet) {
    const CarveTool tool{.from_mm = {20, 21, 20}, .to_mm = {20, 23, 20}, .radius_mm = 4};
    ChainMail used = make({}), fresh = make({});
    use(used, {3, 1, 0});
    ASSERT_TRUE(used.carve(tool).ok());
    ASSERT_TRUE(fresh.carve(tool).ok());
    for (ChainMail* tissue : {&used, &fresh}) push(*tissue, {3, 1, 0});
    EXPECT_EQ(used.hash(), fresh.hash());
    EXPECT_EQ(used.state().carved_elements, fresh.state().carved_elements);
    EXPECT_GT(used.state().carved_elements, 0);
    EXPECT_LT(used.state().max_violation_mm, 1e-6);
}

TEST_F(SweepMemory, ReusedBricksDragLikeNewOnes) {
    ChainMail used = make({}), fresh = make({});
    use(used, {0, 3, 0});
    for (ChainMail* tissue : {&used, &fresh}) {
        ASSERT_TRUE(tissue->grab({.point_mm = {21.5, 21.5, 20.5}}, 5).ok());
        for (const Vec3d to_mm : {Vec3d{2, 0, 0}, Vec3d{3, 0, 1}, Vec3d{-1, 1, 0}})
            ASSERT_TRUE(tissue->drag_to(to_mm).ok());
        tissue->let_go();
    }
    EXPECT_EQ(used.hash(), fresh.hash());
}

}  // namespace
}  // namespace pliant::test
