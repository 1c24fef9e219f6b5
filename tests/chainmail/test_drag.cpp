// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A drag against pushes of the same elements by the same steps: everything must be the same.

#include <gtest/gtest.h>

#include <cmath>

#include "chainmail/lattice.h"
#include "chainmail/tissues.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kSeed = 20260401;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kDrags = 20;
#else
constexpr std::uint64_t kDrags = 200;
#endif

/// A vector that fixed point represents exactly, so that offsets and steps add up to the unit.
Vec3d whole_vector(Random& random, double largest) {
    Vec3d v = random.vector(largest);
    for (int a = 0; a < 3; ++a) v[a] = std::round(v[a] * 1024) / 1024;
    return v;
}

Vec3d displacement_mm(const ChainMail& tissue, Vec3i e) {
    const Vec3<Fixed> u = tissue.lattice().displacement_at(e);
    return {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
}

/// Bone, movement limits, symmetric laws or not; the grid's axes are the world's.
Instance drag_instance(Random& random) {
    Instance instance = random_instance(random, 5, 20, true);
    if (random.whole(0, 1)) instance.law = symmetric(instance.law);
    if (random.whole(0, 1))
        instance.law = [law = instance.law, tightest = random.real(0.5, 3)](int value) {
            ElementLimits limits = law(value);
            if (value >= 0) limits.max_movement_mm = tightest * (1 + value % 3);
            return limits;
        };
    return instance;
}

void cut_some(Random& random, ChainMail& tissue) {
    Lattice& lattice = const_cast<Lattice&>(tissue.lattice());
    BrickEdits edits(std::size_t(lattice.elements_per_brick()), 0);
    for (auto& flags : edits)
        if (random.whole(0, 9) == 0) flags = std::uint8_t(random.whole(1, 7));
    lattice.set_edits({0, 0, 0}, edits);
}

struct Outcomes {
    int limited = 0, renewed = 0, from_deformed = 0;
};

void run_drag(std::uint64_t seed, Outcomes& outcomes) {
    Random random(seed);
    const TaskArena arena(2);
    const Instance instance = drag_instance(random);
    ChainMail dragged = tissue_of(
        instance, arena, random.whole(0, 3) ? ChainMailSolver::Sweep : ChainMailSolver::PlainSweep);
    ChainMail pushed = tissue_of(instance, arena);
    if (random.whole(0, 2) == 0) {
        Random same = random;
        cut_some(random, dragged);
        cut_some(same, pushed);
    }
    for (int before = random.whole(0, 2); before > 0; --before, ++outcomes.from_deformed) {
        const auto elements = random_grab(random, instance.volume.grid);
        const Vec3d push_mm = whole_vector(random, 3);
        ASSERT_TRUE(dragged.push_elements(elements, push_mm).ok());
        ASSERT_TRUE(pushed.push_elements(elements, push_mm).ok());
    }
    const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
    const double reach_mm = random.real(0.5, 4);
    const auto grab = dragged.grab_elements(grabbed, reach_mm);
    ASSERT_TRUE(grab.ok());
    ASSERT_EQ(grab->grabbed_elements, std::int64_t(grabbed.size()));
    const Vec3d start = displacement_mm(dragged, grabbed[0]);
    for (int frame = 0; frame < 8; ++frame) {
        const Vec3d offset = whole_vector(random, 3);
        outcomes.renewed += norm(offset) > reach_mm;
        const Vec3d now = displacement_mm(dragged, grabbed[0]) - start;
        const auto drag = dragged.drag_to(offset);
        const auto push = pushed.push_elements(grabbed, offset - now);
        ASSERT_TRUE(drag.ok() && push.ok());
        ASSERT_EQ(dragged.hash(), pushed.hash()) << "frame " << frame;
        ASSERT_EQ(drag->step_fraction, push->step_fraction) << "frame " << frame;
        ASSERT_EQ(drag->moved_elements, push->moved_elements) << "frame " << frame;
        ASSERT_EQ(drag->limited_by, push->limited_by) << "frame " << frame;
        ASSERT_EQ(drag->status, push->status) << "frame " << frame;
        outcomes.limited += push->step_fraction < 1;
    }
    dragged.let_go();
    const LatticeState a = dragged.state(), b = pushed.state();
    ASSERT_EQ(a.resident_bricks, b.resident_bricks);
    ASSERT_EQ(a.moved_elements, b.moved_elements);
}

TEST(Drag, IsBitForBitAPushOfTheSameElementsByTheSameSteps) {
    Outcomes outcomes;
    for (std::uint64_t n = 0; n < kDrags && !::testing::Test::HasFatalFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kSeed + n));
        run_drag(kSeed + n, outcomes);
    }
    // The drags really come to all kinds of ends.
    EXPECT_GT(outcomes.limited, int(kDrags) / 4);
    EXPECT_GT(outcomes.renewed, int(kDrags) / 4);
    EXPECT_GT(outcomes.from_deformed, int(kDrags) / 4);
}

class DragTest : public ::testing::Test {
  protected:
    void SetUp() override {
        volume.grid.size = {40, 40, 40};
        volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
    }
    TaskArena arena{2};
    Volume volume;
    const Push place{.point_mm = {20.5, 20.5, 20.5}};
};

TEST_F(DragTest, ReportsWhatItHoldsAndReaches) {
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    const auto grab = tissue.grab(place, 3);
    ASSERT_TRUE(grab.ok());
    EXPECT_TRUE(tissue.is_grabbing());
    EXPECT_EQ(grab->grabbed_elements, 8);
    // A push by the whole reach moves exactly the elements that the grab promises.
    ChainMail pushed = std::move(ChainMail::create(volume, {}, arena)).value();
    EXPECT_EQ(grab->reach_elements,
              pushed.push({.point_mm = place.point_mm, .push_mm = {3, 3, 3}})->moved_elements);
    EXPECT_EQ(tissue.state().moved_elements, 0);
    EXPECT_GT(grab->field_bytes, 0);
    ASSERT_TRUE(tissue.drag_to({3, 3, 3}).ok());
    EXPECT_EQ(tissue.hash(), pushed.hash());
}

TEST_F(DragTest, TissueThatWasCarriedAlongStaysWhereLinksAllow) {
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    ASSERT_TRUE(tissue.grab(place, 4).ok());
    ASSERT_TRUE(tissue.drag_to({3, 0, 0}).ok());
    const double carried = tissue.displacement_mm({26, 20, 20}).x;
    EXPECT_GT(carried, 0.5);
    ASSERT_TRUE(tissue.drag_to({2.5, 0, 0}).ok());
    EXPECT_EQ(tissue.displacement_mm({26, 20, 20}).x, carried);
}

TEST_F(DragTest, AnyOtherChangeLetsGo) {
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    ASSERT_TRUE(tissue.grab(place, 2).ok());
    ASSERT_TRUE(tissue.push({.point_mm = {20.5, 20.5, 20.5}, .push_mm = {0, 0, 1}}).ok());
    EXPECT_FALSE(tissue.is_grabbing());
    ASSERT_TRUE(tissue.grab(place, 2).ok());
    tissue.reset();
    EXPECT_FALSE(tissue.is_grabbing());
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

TEST_F(DragTest, LettingGoWithoutAMoveLeavesNoBrickBehind) {
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    ASSERT_TRUE(tissue.grab(place, 3).ok());
    EXPECT_GT(tissue.state().resident_bricks, 0);
    tissue.let_go();
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

TEST_F(DragTest, WrongUseIsRefusedWithOneLine) {
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    const auto nothing = tissue.drag_to({1, 0, 0});
    ASSERT_FALSE(nothing.ok());
    EXPECT_NE(nothing.error().message.find("nothing is grabbed"), std::string::npos);
    for (const double reach : {0.0, -1.0, 501.0, std::nan("")}) {
        const auto grab = tissue.grab(place, reach);
        ASSERT_FALSE(grab.ok());
        EXPECT_NE(grab.error().message.find("reach_mm"), std::string::npos);
    }
    ASSERT_TRUE(tissue.grab(place, 2).ok());
    EXPECT_FALSE(tissue.drag_to({std::nan(""), 0, 0}).ok());
    EXPECT_FALSE(tissue.drag_to({600, 0, 0}).ok());
    EXPECT_TRUE(tissue.is_grabbing());
    EXPECT_FALSE(tissue.grab({.point_mm = {-5, 0, 0}}, 2).ok());
}

TEST_F(DragTest, ReachBeyondTheElementsAllowedGrabsNothing) {
    ChainMailSettings settings;
    settings.max_elements = 20000;
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    const auto grab = tissue.grab(place, 15);
    ASSERT_FALSE(grab.ok());
    EXPECT_EQ(grab.error().code, ErrorCode::LimitExceeded);
    EXPECT_FALSE(tissue.is_grabbing());
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

}  // namespace
}  // namespace pliant::test
