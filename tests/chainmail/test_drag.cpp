// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A drag against pushes of the same elements by the same steps: all results must be equal.
// Covers: chainmail/chainmail_drag.cpp, propagate/drag*.cpp.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "chainmail/air_tissues.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "propagate/drag_kernel.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kDragSeed = 20260401;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kDrags = 20;
#else
constexpr std::uint64_t kDrags = 200;
#endif

/// A vector that fixed point represents exactly, so that offsets and steps add up exactly.
Vec3d whole_vector(Random& random, double largest) {
    Vec3d v = random.vector(largest);
    for (int a = 0; a < 3; ++a) v[a] = std::round(v[a] * 1024) / 1024;
    return v;
}

Vec3d displacement_mm(const ChainMail& tissue, Vec3i e) {
    const Vec3<Fixed> u = lattice_of(tissue).displacement_at(e);
    return {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
}

/// With or without bone, movement limits and symmetric laws; the grid's axes are the world's.
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
    Lattice& lattice = lattice_of(tissue);
    BrickEdits edits(std::size_t(lattice.elements_per_brick()), 0);
    for (auto& flags : edits)
        if (random.whole(0, 9) == 0) flags = std::uint8_t(random.whole(1, 7));
    lattice.set_edits({0, 0, 0}, edits);
}

/// Tests the bounds of bricks against their contents.
void check_bounds(const ChainMail& tissue, bool exact) {
    const auto count = std::size_t(lattice_of(tissue).elements_per_brick());
    lattice_of(tissue).for_each_brick([&](const Brick& brick) {
        for (int a = 0; a < 3; ++a) {
            const Fixed* u = brick.u[std::size_t(a)];
            const auto [low, high] = std::minmax_element(u, u + count);
            ASSERT_TRUE(exact ? brick.u_min[a] == *low : brick.u_min[a] <= *low);
            ASSERT_TRUE(exact ? brick.u_max[a] == *high : brick.u_max[a] >= *high);
        }
    });
}

struct Outcomes {
    int limited = 0, renewed = 0, from_deformed = 0;
};

void run_drag(Random& random, ChainMail& dragged, ChainMail& pushed, Outcomes& outcomes) {
    const Grid& grid = dragged.volume().grid;
    const std::vector<Vec3i> grabbed = random_grab(random, grid);
    for (int before = random.whole(0, 2); before > 0; --before, ++outcomes.from_deformed) {
        const auto elements = random.whole(0, 2) ? random_grab(random, grid) : grabbed;
        const Vec3d push_mm = whole_vector(random, 3);
        ASSERT_TRUE(dragged.push_elements(elements, push_mm).ok());
        ASSERT_TRUE(pushed.push_elements(elements, push_mm).ok());
    }
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
        ASSERT_NO_FATAL_FAILURE(check_bounds(dragged, false)) << "frame " << frame;
        outcomes.limited += push->step_fraction < 1;
    }
    dragged.let_go();
    ASSERT_NO_FATAL_FAILURE(check_bounds(dragged, true));
    const LatticeState a = dragged.state(), b = pushed.state();
    ASSERT_EQ(a.resident_bricks, b.resident_bricks);
    ASSERT_EQ(a.moved_elements, b.moved_elements);
}

ChainMailSolver random_solver(Random& random) {
    return random.whole(0, 3) ? ChainMailSolver::Sweep : ChainMailSolver::PlainSweep;
}

TEST(Drag, IsBitForBitAPushOfTheSameElementsByTheSameSteps) {
    Outcomes outcomes;
    for (std::uint64_t n = 0; n < kDrags && !::testing::Test::HasFatalFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kDragSeed + n));
        Random random(kDragSeed + n);
        const TaskArena arena(1 + int(n % 2));
        const Instance instance = drag_instance(random);
        ChainMail dragged = tissue_of(instance, arena, random_solver(random));
        ChainMail pushed = tissue_of(instance, arena);
        if (random.whole(0, 2) == 0) {
            Random same = random;
            cut_some(random, dragged);
            cut_some(same, pushed);
        }
        run_drag(random, dragged, pushed, outcomes);
    }
    // The drags reach all kinds of ends.
    EXPECT_GT(outcomes.limited, int(kDrags) / 4);
    EXPECT_GT(outcomes.renewed, int(kDrags) / 4);
    EXPECT_GT(outcomes.from_deformed, int(kDrags) / 4);
}

TEST(Drag, IsBitForBitAPushThroughAirToo) {
    Outcomes outcomes;
    for (std::uint64_t n = 0; n < kDrags / 2 && !::testing::Test::HasFatalFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kDragSeed + n));
        Random random(kDragSeed + n);
        const TaskArena arena(1 + int(n % 2));
        const Volume volume = scan_with_air(random, 20);
        ChainMailSettings settings = settings_with_air(random);
        settings.max_movement_mm = random.real(3, 30);
        ChainMail pushed = tissue_of(volume, arena, settings);
        settings.solver = random_solver(random);
        ChainMail dragged = tissue_of(volume, arena, settings);
        run_drag(random, dragged, pushed, outcomes);
    }
    EXPECT_GT(outcomes.limited, int(kDrags) / 16);
    EXPECT_GT(outcomes.renewed, int(kDrags) / 8);
    EXPECT_GT(outcomes.from_deformed, int(kDrags) / 8);
}

/// Position of an element whose field is `raised`, after some turns from rest.
Fixed after(std::span<const DragTurn> turns, Fixed raised) {
    Fixed u = 0;
    for (const DragTurn turn : turns)
        u = turn.sign > 0 ? std::max(u, raised - turn.left) : std::min(u, turn.left - raised);
    return u;
}

TEST(DragTurns, TellWhatAllMovesTogetherDid) {
    int lost = 0, several = 0;
    for (std::uint64_t n = 0; n < 400; ++n) {
        SCOPED_TRACE("seed " + std::to_string(kDragSeed + n));
        Random random(kDragSeed + n);
        const int reach = 100;
        DragTurns turns;
        std::vector<DragTurn> all;
        Fixed offset = 0;
        for (int move = random.whole(1, 25); move > 0 && !turns.is_lost(); --move) {
            const Fixed to = random.whole(-40, 40);
            if (to == offset) continue;
            const Fixed sign = to > offset ? 1 : -1;
            offset = to;
            all.push_back({reach - sign * to, sign});
            turns.add(all.back());
            if (turns.is_lost()) break;
            ASSERT_LE(turns.turns().size(), DragTurns::kMost);
            for (Fixed raised = 0; raised <= reach; ++raised)
                ASSERT_EQ(after(turns.turns(), raised), after(all, raised)) << raised;
        }
        lost += turns.is_lost();
        several += turns.turns().size() > 1;
    }
    EXPECT_GT(lost, 5);
    EXPECT_GT(several, 100);
}

TEST(Drag, OfMoreThanTheCachesHoldIsBitForBitPushesToo) {
    // From rest on, to and fro: the turns then determine the positions.
    Random random(kDragSeed);
    const TaskArena arena(2);
    Volume volume;
    volume.grid.size = {112, 112, 112};
    volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    ChainMail dragged = std::move(ChainMail::create(volume, settings, arena)).value();
    ChainMail pushed = std::move(ChainMail::create(volume, settings, arena)).value();
    const Push place{.point_mm = {56.5, 56.5, 56.5}};
    const auto held = pushed.elements_at(place);
    ASSERT_TRUE(held.ok());
    ASSERT_GT(dragged.grab(place, 40).value().reach_elements, 600000);
    Vec3d at{0, 0, 0};
    for (int frame = 0; frame < 14; ++frame) {
        SCOPED_TRACE("frame " + std::to_string(frame));
        Vec3d to = at;
        for (int a = 0; a < 3; ++a)
            if (random.whole(0, 3)) to[a] = random.whole(-576, 576) / 32.0;  // whole units
        const auto drag = dragged.drag_to(to);
        const auto push = pushed.push_elements(*held, to - at);
        ASSERT_TRUE(drag.ok() && push.ok());
        ASSERT_EQ(dragged.hash(), pushed.hash());
        ASSERT_EQ(drag->moved_elements, push->moved_elements);
        ASSERT_EQ(push->step_fraction, 1);
        at = to;
    }
}

constexpr int kElements = 512;

/// Fields and displacements of a brick, as in a drag: some lines can't move.
struct DraggedArrays {
    alignas(64) std::array<std::array<Fixed, kElements>, 3> u{}, raised{};
    std::array<Fixed, 3> left{}, sign{};
    std::size_t components = 0;
    bool one_field = false, known = false;
    std::array<std::vector<DragTurn>, 3> turns;  ///< if u is known

    explicit DraggedArrays(Random& random) : components(std::size_t(random.whole(1, 3))) {
        one_field = random.whole(0, 1) != 0;
        known = one_field && random.whole(0, 1);
        for (std::size_t c = 0; c < 3; ++c) {
            const int from = random.whole(-50, 50), first = random.whole(-100, 150);
            const int slope = random.whole(0, 400);
            left[c] = random.whole(0, 100);
            sign[c] = random.whole(0, 1) ? 1 : -1;
            for (int n = 0; n < kElements; ++n) {
                const int place = from + random.whole(0, 40);
                const int rise = first + n * slope / kElements + random.whole(0, 9);
                u[c][std::size_t(n)] = sign[c] * place;
                raised[c][std::size_t(n)] = left[c] + rise;
            }
        }
        for (std::size_t c = 0; known && c < 3; ++c) {
            for (int turn = random.whole(0, 4); turn > 0; --turn)
                turns[c].push_back({left[0] + random.whole(-50, 100), turn % 2 ? 1 : -1});
            for (std::size_t n = 0; n < kElements; ++n) u[c][n] = after(turns[c], raised[0][n]);
        }
    }
};

/// All results of a kernel.
std::vector<Fixed> results_of(MoveDragged move, DraggedArrays arrays) {
    std::array<DraggedComponent, 3> components;
    for (std::size_t c = 0; c < arrays.components; ++c) {
        auto& u = arrays.u[c];
        const auto [low, high] = std::minmax_element(u.begin(), u.end());
        const Fixed* raised = arrays.raised[arrays.one_field ? 0 : c].data();
        components[c] = {.u = u.data(),
                         .raised = raised,
                         .left = arrays.left[c],
                         .sign = arrays.sign[c],
                         .lowest = arrays.sign[c] > 0 ? *low : -*high,
                         .next_u = u.data(),
                         .next_raised = raised,
                         .turns = arrays.turns[c]};
    }
    const DraggedBrick result =
        move(std::span(components).first(arrays.components), kElements, arrays.known);
    std::vector<Fixed> all{result.moved, result.has_wide_bounds};
    for (std::size_t c = 0; c < arrays.components; ++c) {
        all.push_back(components[c].lowest);
        all.insert(all.end(), arrays.u[c].begin(), arrays.u[c].end());
    }
    return all;
}

TEST(DragKernel, VectorsGiveTheBitsOfPlainLoopsOnEveryInstructionSet) {
    int targets = 0, whole = 0, partly = 0;
    for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
        hwy::SetSupportedTargetsForTest(rest & -rest);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        ++targets;
        for (std::uint64_t n = 0; n < 200; ++n) {
            Random random(kDragSeed + n);
            const DraggedArrays arrays(random);
            const std::vector<Fixed> plain = results_of(plain_move_dragged(), arrays);
            ASSERT_EQ(results_of(vector_move_dragged(), arrays), plain)
                << hwy::TargetName(rest & -rest) << ", seed " << kDragSeed + n;
            whole += plain[0] > 0 && !plain[1];
            partly += plain[0] > 0 && plain[1];
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(targets, 0);
    EXPECT_GT(whole, 20 * targets);
    EXPECT_GT(partly, 20 * targets);
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
    // A push by the whole reach moves exactly the elements that the grab reports.
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
