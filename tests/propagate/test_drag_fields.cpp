// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The six fields of a pick against six solves of the reference, and the sharing of arrays.
// Covers: propagate/drag.cpp, propagate/drag_*.cpp.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <string>

#include "chainmail/air_tissues.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "propagate/drag_fields.h"
#include "propagate/drag_kernel.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kDragFieldsSeed = 20261121;

/// Positions of a lattice's bricks in one direction: sign·u, after a solve.
template <class Place>
void for_each_place(const Lattice& lattice, const Place& place) {
    lattice.for_each_brick([&](const Brick& brick) {
        for (int n = 0; n < lattice.elements_per_brick(); ++n)
            place(brick, lattice.element_of(brick.coord, n), std::size_t(n));
    });
}

struct Found {
    int shared = 0, split = 0;
};

/// Two lattices of the same tissue: one for the fields, one for the heap.
struct Twins {
    TaskArena arena{2};
    Volume volume;
    ChainMailSettings settings;
    std::vector<Vec3i> grabbed;
    Fixed reach = 0;

    explicit Twins(Random& random)
        : volume(scan_with_air(random, 20)), settings(settings_with_air(random)) {
        grabbed = random_grab(random, volume.grid);
        reach = units_from_mm(random.real(0.5, 3));
    }
    /// At rest, deformed about the grabbed elements such that all have moved alike, or deformed at
    /// random.
    void deform(Random& random, ChainMail& tissue) const {
        const int way = random.whole(0, 2);
        if (way == 0) return;
        const auto pushed = way == 1 ? grabbed : random_grab(random, volume.grid);
        ASSERT_TRUE(tissue.push_elements(pushed, random.vector(2)).ok());
        if (random.whole(0, 2) == 0) random_cut(random, tissue);
    }
};

std::vector<ElementRef> hold(Lattice& lattice, const std::vector<Vec3i>& elements) {
    std::vector<ElementRef> held;
    for (const Vec3i& e : elements)
        if (!lattice.is_void(e)) held.push_back(lattice.ensure_element(e));
    return held;
}

void check_fields(std::uint64_t seed, Found& found) {
    Random random(seed);
    const Twins twins(random);
    ChainMail subject = tissue_of(twins.volume, twins.arena, twins.settings);
    ChainMail reference = tissue_of(twins.volume, twins.arena, twins.settings);
    Random same = random;
    ASSERT_NO_FATAL_FAILURE(twins.deform(random, subject));
    ASSERT_NO_FATAL_FAILURE(twins.deform(same, reference));
    Lattice& lattice = lattice_of(subject);
    Lattice& oracle = lattice_of(reference);
    const auto held = hold(lattice, twins.grabbed), held_there = hold(oracle, twins.grabbed);
    if (held.empty()) return;
    const bool vectors = twins.settings.brick_size == 8 && random.whole(0, 3) > 0;
    DragFields fields;
    SweepWork work;
    ASSERT_TRUE(fields.solve(lattice, held, twins.reach,
                             vectors ? vector_sweep_kernels() : plain_sweep_kernels(), twins.arena,
                             1 << 20, work));
    for (std::size_t d = 0; d < kDirections; ++d) {
        const Fixed sign = d % 2 ? 1 : -1;
        const auto a = d / 2;
        ASSERT_TRUE(propagate_by_heap(oracle, held_there, {int(a), sign, twins.reach}, 1 << 20));
        const auto expected_at = [&](Vec3i e) {
            const int index = oracle.find_brick(oracle.brick_of(e));
            if (index < 0) return 0;
            const Brick& brick = oracle.brick(index);
            const auto n = std::size_t(oracle.index_in_brick(e));
            return brick.reached[a] ? brick.raised[a][n] : sign * brick.u[a][n];
        };
        const auto place_at = [&](Vec3i e) {
            const int index = lattice.find_brick(lattice.brick_of(e));
            if (index < 0) return 0;
            const Brick& brick = lattice.brick(index);
            const auto n = std::size_t(lattice.index_in_brick(e));
            const Fixed u = brick.is_unplaced ? 0 : sign * brick.u[a][n];
            const Fixed* v = fields.of_brick(index)[d];
            return v ? std::max(u, v[n] + fields.ahead()[d]) : u;
        };
        for (const Lattice* either : {&lattice, &oracle})
            for_each_place(*either, [&](const Brick&, Vec3i e, std::size_t) {
                ASSERT_EQ(place_at(e), expected_at(e)) << "direction " << d;
            });
        oracle.for_each_brick([](Brick& brick) { brick.reached = {}; });
    }
    for (const int index : work.touched) {
        const FieldArrays& of = fields.of_brick(index);
        (of[0] == of[5] ? found.shared : found.split) += of[0] != nullptr;
    }
}

TEST(DragFields, EqualSixSolvesOfTheHeap) {
    Found found;
    for (std::uint64_t n = 0; n < 100 && !::testing::Test::HasFatalFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kDragFieldsSeed + n));
        check_fields(kDragFieldsSeed + n, found);
    }
    EXPECT_GT(found.shared, 50);
    EXPECT_GT(found.split, 200);
}

TEST(DragFields, TissueFarFromAirHasOneArrayForAllDirections) {
    // A slab of air at one end; the pick is at the other, at rest and after a drag.
    const Volume volume =
        volume_of({96, 64, 64}, [](Vec3i e) { return e.x < 88 ? 30 + e.y : int(kAirHu); });
    const TaskArena arena(2);
    ChainMail tissue = tissue_of(volume, arena);
    const std::vector<Vec3i> grabbed = {{30, 32, 32}, {31, 32, 32}};
    for (int turn = 0; turn < 2; ++turn) {
        const auto grab = tissue.grab_elements(grabbed, 3);
        ASSERT_TRUE(grab.ok());
        // No more than the data that each frame reads: no arrays beside the bricks' own.
        EXPECT_LE(grab->field_bytes, 128 * tissue.state().resident_bricks);
        ASSERT_TRUE(tissue.drag_to({2, -1, 0}).ok());
    }
    // Beside the air directions differ, and need more arrays.
    const auto grab = tissue.grab_elements(std::vector<Vec3i>{{86, 32, 32}}, 3);
    ASSERT_TRUE(grab.ok());
    EXPECT_GT(grab->field_bytes, 128 * tissue.state().resident_bricks);
}

TEST(DragFields, ElementsFarApartAreHeldByFieldsOfTheirOwn) {
    // The largest reach and displacement: no array is shared, and no number overflows.
    const Volume volume = block({20, 12, 12}, 40, {60, 60, 60});
    const TaskArena arena(1);
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    ChainMail dragged = tissue_of(volume, arena, settings);
    ChainMail pushed = tissue_of(volume, arena, settings);
    const std::vector<Vec3i> grabbed = {{10, 6, 6}};
    for (ChainMail* tissue : {&dragged, &pushed})
        ASSERT_TRUE(tissue->push_elements(grabbed, {400, 0, 0}).ok());
    ASSERT_TRUE(dragged.grab_elements(grabbed, 500).ok());
    Vec3d before{0, 0, 0};
    for (const Vec3d& offset : {Vec3d{-450, 0, 0}, Vec3d{0, 100, -100}, Vec3d{-300, 0, 0}}) {
        const auto drag = dragged.drag_to(offset);
        const auto push = pushed.push_elements(grabbed, offset - before);
        ASSERT_TRUE(drag.ok() && push.ok());
        ASSERT_EQ(push->step_fraction, 1);
        ASSERT_EQ(drag->moved_elements, push->moved_elements);
        ASSERT_EQ(dragged.hash(), pushed.hash());
        before = offset;
    }
}

constexpr int kBrickElements = 512;

struct LookedAtArrays {
    alignas(64) std::array<std::array<Fixed, kBrickElements>, 6> fields{};
    alignas(64) std::array<std::array<Fixed, kBrickElements>, 3> u{};
    FieldsOfBrick brick{};

    explicit LookedAtArrays(Random& random) {
        const bool one = random.whole(0, 1);
        brick.at_rest = random.whole(0, 1);
        const int level = random.whole(-60, 60);
        for (auto& field : fields)
            for (Fixed& value : field) value = level + random.whole(-20, 20);
        for (auto& component : u)
            for (Fixed& value : component) value = brick.at_rest ? 0 : random.whole(-20, 20);
        for (std::size_t d = 0; d < 6; ++d) {
            brick.of[d] = fields[one ? 0 : d].data();
            brick.u[d / 2] = u[d / 2].data();
            brick.ahead[d] = random.whole(-20, 20);
        }
    }
};

TEST(DragKernel, LooksGiveTheSameOnEveryInstructionSet) {
    int targets = 0, partly = 0;
    for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
        hwy::SetSupportedTargetsForTest(rest & -rest);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        ++targets;
        for (std::uint64_t n = 0; n < 200; ++n) {
            Random random(kDragFieldsSeed + n);
            const LookedAtArrays arrays(random);
            const LookAtFields plain = plain_look_at_fields()(arrays.brick, kBrickElements);
            const LookAtFields vectors = vector_look_at_fields()(arrays.brick, kBrickElements);
            ASSERT_EQ(vectors.reached, plain.reached)
                << hwy::TargetName(rest & -rest) << ", seed " << kDragFieldsSeed + n;
            ASSERT_EQ(vectors.highest, plain.highest)
                << hwy::TargetName(rest & -rest) << ", seed " << kDragFieldsSeed + n;
            partly += plain.reached > 0 && plain.reached < kBrickElements;
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(targets, 0);
    EXPECT_GT(partly, 20 * targets);
}

}  // namespace
}  // namespace pliant::test
