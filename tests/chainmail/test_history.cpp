// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo: bit-identical states, within a limit of memory.

#include "chainmail/chainmail_impl.h"
#include "chainmail/history.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <climits>

#include "chainmail/history_kernel.h"
#include "chainmail/tissues.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kHistorySeed = 20260302;

TEST(HistoryCodec, AnyChangeComesBack) {
    Random random(kHistorySeed);
    for (int n = 0; n < 400; ++n) {
        const int size = random.whole(2, 9);
        const auto count = std::size_t(size * size * size);
        std::vector<Fixed> before(3 * count), after(3 * count);
        const int kind = n % 4;
        for (std::size_t i = 0; i < 3 * count; ++i) {
            before[i] = kind == 0 ? Fixed(random.next()) : random.whole(-1000, 1000);
            after[i] = kind == 0   ? Fixed(random.next())
                       : kind == 1 ? before[i] + 5
                       : kind == 2 ? before[i]
                                   : before[i] + random.whole(0, 1) * 70'000;
        }
        const auto parts = [&](const std::vector<Fixed>& v) {
            return Components{v.data(), v.data() + count, v.data() + 2 * count};
        };
        Bytes raw;
        ASSERT_EQ(encode_change(parts(before), parts(after), size, raw), before != after);
        if (before == after) {
            ASSERT_TRUE(raw.empty());
            continue;
        }
        const Bytes packed = pack(raw);
        Bytes unpacked(raw.size());
        ASSERT_TRUE(unpack(packed, unpacked));
        std::span<const std::byte> left = unpacked;
        std::vector<std::uint32_t> change(3 * count);
        ASSERT_TRUE(decode_change(
            left, size, {change.data(), change.data() + count, change.data() + 2 * count}));
        ASSERT_TRUE(left.empty());
        for (std::size_t i = 0; i < 3 * count; ++i)
            ASSERT_EQ(Fixed(std::uint32_t(before[i]) + change[i]), after[i]);
    }
}

/// Input of packing: the bitwise or of all values, and the four byte planes.
std::vector<std::byte> planes_of(const ChangeKernels& kernels, const std::vector<Fixed>& before,
                                 const std::vector<Fixed>& after) {
    const std::size_t count = before.size();
    std::vector<std::uint32_t> values(count);
    const std::uint32_t any = kernels.predict(before.data(), after.data(), 8, values.data());
    std::vector<std::byte> out(4 * count + 4);
    for (int plane = 0; plane < 4; ++plane) {
        const auto p = std::size_t(plane);
        out[4 * count + p] = std::byte(any >> 8 * plane & 0xff);
        if (any != 0) kernels.copy_plane(values.data(), int(count), plane, &out[p * count]);
    }
    return out;
}

TEST(HistoryKernel, VectorsGiveTheBitsOfPlainLoopsOnEveryInstructionSet) {
    int targets = 0;
    for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
        hwy::SetSupportedTargetsForTest(rest & -rest);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        ++targets;
        for (std::uint64_t n = 0; n < 100; ++n) {
            Random random(kHistorySeed + n);
            std::vector<Fixed> before(512), after(512);
            const bool any_number = n % 2 == 0;
            for (Fixed& u : before) u = any_number ? Fixed(random.next()) : random.whole(-9, 9);
            after = before;
            // No element, one, or all.
            if (n % 5 == 1) after[std::size_t(random.whole(0, 511))] += 1;
            if (n % 5 > 1)
                for (Fixed& u : after) u = any_number ? Fixed(random.next()) : random.whole(-9, 9);
            ASSERT_EQ(planes_of(vector_change_kernels(), before, after),
                      planes_of(plain_change_kernels(), before, after))
                << hwy::TargetName(rest & -rest) << ", seed " << kHistorySeed + n;
        }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GT(targets, 0);
}

TEST(HistoryCodec, DamagedBytesAreRefusedOrDecodeWithoutACrash) {
    Random random(kHistorySeed);
    const int size = 4, count = 64;
    std::vector<Fixed> before(3 * count, 0), after(3 * count);
    for (Fixed& u : after) u = random.whole(-100'000, 100'000);
    Bytes raw;
    encode_change({before.data(), before.data() + count, before.data() + 2 * count},
                  {after.data(), after.data() + count, after.data() + 2 * count}, size, raw);
    std::vector<std::uint32_t> change(3 * count);
    const auto decode = [&](std::span<const std::byte> bytes) {
        return decode_change(bytes, size,
                             {change.data(), change.data() + count, change.data() + 2 * count});
    };
    for (std::size_t length = 0; length < raw.size(); ++length)
        EXPECT_FALSE(decode(std::span(raw).first(length)));
    const Bytes packed = pack(raw);
    Bytes unpacked(raw.size());
    for (int n = 0; n < 500; ++n) {
        Bytes damaged = packed;
        damaged[std::size_t(random.whole(0, int(packed.size()) - 1))] = std::byte(random.next());
        if (unpack(damaged, unpacked)) (void)decode(unpacked);
    }
    EXPECT_FALSE(unpack(std::span(packed).first(packed.size() / 2), unpacked));
}

/// One random step of any kind; most have an effect.
void random_step(Random& random, ChainMail& tissue, double reach) {
    switch (random.whole(0, 5)) {
        case 0:
            return random_cut(random, tissue);
        case 1:
            return random_carve(random, tissue);
        case 2:
            tissue.begin_group("drag");
            for (int n = 0; n < 3; ++n) random_push(random, tissue, reach);
            tissue.end_group();
            return;
        default:
            return random_push(random, tissue, reach);
    }
}

void run_history_instance(std::uint64_t seed) {
    Random random(seed);
    const TaskArena arena(random.whole(1, 2));
    const Instance instance = random_instance(random, 5, 12, true);
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    settings.brick_size = random.whole(2, 9);
    settings.bounded = random.whole(0, 1);
    ChainMail tissue = tissue_of(instance.volume, arena, settings);
    const double reach = 3 * instance.push_limit_mm.x;
    std::vector<std::uint64_t> hashes = {tissue.hash()};  // after each step that can be undone
    for (int n = 0; n < 60; ++n) {
        const int action = random.whole(0, 5);
        const auto at = std::size_t(tissue.undo_steps());
        if (action == 0 && tissue.undo_steps() > 0) {
            ASSERT_TRUE(tissue.undo().ok());
            ASSERT_EQ(tissue.hash(), hashes[at - 1]);
        } else if (action == 1 && tissue.redo_steps() > 0) {
            ASSERT_TRUE(tissue.redo().ok());
            ASSERT_EQ(tissue.hash(), hashes[at + 1]);
        } else {
            const std::uint64_t before = tissue.hash();
            random_step(random, tissue, reach);
            if (tissue.hash() == before) continue;
            ASSERT_EQ(std::size_t(tissue.undo_steps()), at + 1);
            ASSERT_EQ(tissue.redo_steps(), 0);
            hashes.resize(at + 1);
            hashes.push_back(tissue.hash());
        }
        if (n % 10 == 0) {
            ASSERT_LT(tissue.state().max_violation_mm, 1e-9);
        }
    }
    for (auto at = std::size_t(tissue.undo_steps()); at > 0; --at) {
        ASSERT_TRUE(tissue.undo().ok());
        ASSERT_EQ(tissue.hash(), hashes[at - 1]);
    }
    const LatticeState state = tissue.state();
    EXPECT_EQ(state.moved_elements + state.cut_links + state.carved_elements, 0);
    EXPECT_EQ(state.resident_bricks, 0);
    while (tissue.redo_steps() > 0) ASSERT_TRUE(tissue.redo().ok());
    EXPECT_EQ(tissue.hash(), hashes.back());
}

TEST(History, UndoAndRedoGiveTheSameBitsAfterAnySteps) {
    for (std::uint64_t n = 0; n < 30 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kHistorySeed + n));
        run_history_instance(kHistorySeed + n);
    }
}

class HistoryTest : public ::testing::Test {
  protected:
    TaskArena arena{2};
    Volume volume = block({24, 24, 24});
    void push(ChainMail& tissue, Vec3d push_mm) {
        ASSERT_TRUE(tissue.push({.point_mm = {10.5, 11.5, 12.5}, .push_mm = push_mm}).ok());
    }
};

TEST_F(HistoryTest, TwoHundredStepsCanBeUndone) {
    ChainMail tissue = tissue_of(volume, arena);
    const std::uint64_t rest = tissue.hash();
    for (int n = 0; n < 200; ++n) push(tissue, {n % 2 ? -0.4 : 0.5, 0.01, 0});
    EXPECT_EQ(tissue.undo_steps(), 200);
    EXPECT_LT(tissue.history_bytes(), 256'000'000u);
    for (int n = 0; n < 200; ++n) ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(tissue.hash(), rest);
    EXPECT_EQ(tissue.undo().error().code, ErrorCode::NotFound);
}

TEST_F(HistoryTest, OldestStepsAreForgottenAtTheBoundAndTheReportSaysSo) {
    ChainMailSettings settings;
    settings.history_max_steps = 3;
    ChainMail tissue = tissue_of(volume, arena, settings);
    for (int n = 0; n < 3; ++n) push(tissue, {0.5, 0, 0});
    const std::uint64_t after_two = [&] {
        EXPECT_TRUE(tissue.undo().ok());
        const std::uint64_t hash = tissue.hash();
        EXPECT_TRUE(tissue.redo().ok());
        return hash;
    }();
    const auto fourth = tissue.push({.point_mm = {10.5, 11.5, 12.5}, .push_mm = {0, 1, 0}});
    EXPECT_EQ(fourth->forgotten_steps, 1);
    const auto fifth = tissue.push({.point_mm = {10.5, 11.5, 12.5}, .push_mm = {0, 1, 0}});
    EXPECT_EQ(fifth->forgotten_steps, 1);
    while (tissue.undo_steps() > 0) ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(tissue.hash(), after_two);
}

TEST_F(HistoryTest, BytesStayWithinTheBound) {
    ChainMailSettings settings;
    settings.history_max_mb = 1;
    settings.max_movement_mm = 200;
    const Volume large = block({80, 80, 80});
    ChainMail tissue = tissue_of(large, arena, settings);
    Random random(kHistorySeed);
    int forgotten = 0;
    for (int n = 0; n < 60; ++n) {
        const auto report =
            tissue.push({.point_mm = {random.real(1, 78), random.real(1, 78), random.real(1, 78)},
                         .push_mm = random.vector(4)});
        ASSERT_TRUE(report.ok());
        forgotten += report->forgotten_steps;
        ASSERT_LE(tissue.history_bytes(), 1'000'000u);
        ASSERT_GT(tissue.undo_steps(), 0);
    }
    EXPECT_GT(forgotten, 5);
    EXPECT_EQ(tissue.undo_steps() + forgotten, 60);
}

TEST_F(HistoryTest, StepLargerThanTheBoundLeavesNothingToUndo) {
    ChainMailSettings settings;
    settings.history_max_mb = 0;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const auto report = tissue.push({.point_mm = {10.5, 11.5, 12.5}, .push_mm = {1, 0, 0}});
    EXPECT_EQ(report->forgotten_steps, -1);
    EXPECT_EQ(tissue.undo_steps(), 0);
    EXPECT_EQ(tissue.history_bytes(), 0u);
}

TEST_F(HistoryTest, WithoutStepsNothingIsKept) {
    ChainMailSettings settings;
    settings.history_max_steps = 0;
    ChainMail tissue = tissue_of(volume, arena, settings);
    const auto report = tissue.push({.point_mm = {10.5, 11.5, 12.5}, .push_mm = {1, 0, 0}});
    EXPECT_EQ(report->forgotten_steps, 0);
    EXPECT_EQ(tissue.undo_steps(), 0);
    EXPECT_FALSE(tissue.undo().ok());
}

TEST_F(HistoryTest, RejectedPushIsNoStepAndKeepsWhatCanBeRedone) {
    ChainMail tissue = tissue_of(volume, arena);
    push(tissue, {1, 0, 0});
    ASSERT_TRUE(tissue.undo().ok());
    push(tissue, {0, 0, 0});
    EXPECT_EQ(tissue.redo_steps(), 1);
    push(tissue, {0, 1, 0});
    EXPECT_EQ(tissue.redo_steps(), 0);
    EXPECT_EQ(tissue.redo().error().code, ErrorCode::NotFound);
}

TEST_F(HistoryTest, GroupIsOneStepWithItsName) {
    ChainMail tissue = tissue_of(volume, arena);
    const std::uint64_t rest = tissue.hash();
    tissue.begin_group("drag");
    for (int n = 0; n < 5; ++n) push(tissue, {0.3, 0, 0});
    push(tissue, {-0.5, 0, 0});
    EXPECT_EQ(tissue.undo().error().code, ErrorCode::InvalidArgument);
    tissue.end_group();
    EXPECT_EQ(tissue.next_undo_name(), "drag");
    EXPECT_EQ(tissue.undo_steps(), 1);
    ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(tissue.next_redo_name(), "drag");
    EXPECT_EQ(tissue.next_undo_name(), "");
    EXPECT_EQ(tissue.hash(), rest);
    EXPECT_EQ(lattice_of(tissue).resident_brick_count(), 0);
}

TEST_F(HistoryTest, StepThatEndsWhereItBeganIsNoStep) {
    const auto rigid = [](int) { return ElementLimits{.max_movement_mm = 100}; };
    ChainMailSettings settings;
    settings.custom_law = rigid;
    settings.bounded = true;
    ChainMail tissue = tissue_of(volume, arena, settings);
    tissue.begin_group("there and back");
    push(tissue, {1, 0, 0});
    push(tissue, {-1, 0, 0});
    tissue.end_group();
    EXPECT_EQ(tissue.undo_steps(), 0);
}

struct Number final : Exchange {
    Number(int& p, int v) : place(p), value(v) { std::swap(place, value); }
    void exchange() noexcept override { std::swap(place, value); }
    std::size_t bytes() const override { return sizeof *this; }
    int& place;
    int value;
};

TEST_F(HistoryTest, OtherThingsAreExchangedInTheOrderTheyWereDone) {
    Lattice lattice(volume, {[](int) { return ElementLimits{}; }}, 8, false);
    PlasticRest rest;
    History history(lattice, rest, arena, 10, 1'000'000);
    int setting = 1;
    history.begin("threshold");
    history.add(std::make_unique<Number>(setting, 2));
    history.add(std::make_unique<Number>(setting, 3));
    history.end();
    EXPECT_EQ(setting, 3);
    history.undo();
    EXPECT_EQ(setting, 1);
    history.redo();
    EXPECT_EQ(setting, 3);
    EXPECT_GE(history.bytes(), 2 * sizeof(Number));
}

TEST_F(HistoryTest, AStepsNameCountsByItsLength) {
    Lattice lattice(volume, {[](int) { return ElementLimits{}; }}, 8, false);
    PlasticRest rest;
    History history(lattice, rest, arena, 10, 1'000'000);
    int setting = 1;
    std::vector<std::size_t> bytes;
    for (const std::string& name : {std::string("a"), std::string(31, 'b'), std::string(9, 'c')}) {
        history.begin(name);
        history.add(std::make_unique<Number>(setting, 2));
        history.end();
        bytes.push_back(history.bytes());
    }
    EXPECT_EQ(bytes[1] - bytes[0], bytes[0] + 30);
    EXPECT_EQ(bytes[2] - bytes[1], bytes[0] + 8);
    EXPECT_GT(bytes[0], sizeof(Number));
}

TEST(HistoryCodec, MoreBytesThanAnIntCountsAreRefused) {
    const Bytes some(8);
    Bytes raw(8);
    constexpr std::size_t kMore = std::size_t(INT_MAX) + 1;  // none of them is looked at
    EXPECT_FALSE(unpack(std::span<const std::byte>(some.data(), kMore), raw));
    EXPECT_FALSE(unpack(some, std::span<std::byte>(raw.data(), kMore)));
}

TEST_F(HistoryTest, StepThatEndsWhereMovedTissueBeganIsNoStep) {
    const auto rigid = [](int) { return ElementLimits{.max_movement_mm = 100}; };
    ChainMailSettings settings;
    settings.custom_law = rigid;
    settings.bounded = true;
    ChainMail tissue = tissue_of(volume, arena, settings);
    push(tissue, {1, 0.5, -0.25});
    for (const Vec3d way : {Vec3d{1, 0, 0}, {0, 2, 0}, {0, 0, -1}, {0.5, 0.5, 0.5}}) {
        tissue.begin_group("there and back");
        push(tissue, way);
        push(tissue, -way);
        tissue.end_group();
        EXPECT_EQ(tissue.undo_steps(), 1);
    }
}

/// A lattice with a history, whose bricks get random displacements.
struct WrittenLattice {
    Lattice lattice;
    PlasticRest rest;
    History history;
    Random random{kHistorySeed};

    WrittenLattice(const Volume& volume, const TaskArena& arena)
        : lattice(volume, {[](int) { return ElementLimits{}; }}, 8, false),
          history(lattice, rest, arena, 10, 1'000'000) {}
    void write(Vec3i coord) {
        const int index = lattice.ensure_brick(coord);
        Brick& brick = lattice.brick(index);
        lattice.before_move(brick);
        for (Fixed* const u : brick.u)
            for (int n = 0; n < 512; ++n) u[n] = random.whole(-999, 999);
        lattice.update_bounds(index);
    }
    /// Of all bricks; 0 at rest.
    std::vector<Fixed> displacements() const {
        std::vector<Fixed> found;
        for (int n = 0; n < 27; ++n) {
            const int index = lattice.find_brick({n % 3, n / 3 % 3, n / 9});
            for (std::size_t a = 0; a < 3; ++a)
                for (int e = 0; e < 512; ++e)
                    found.push_back(index < 0 ? 0 : lattice.brick(index).u[a][e]);
        }
        return found;
    }
};

TEST_F(HistoryTest, AStepGoesOnAfterASafeguardThatWasCancelled) {
    WrittenLattice written(volume, arena);
    const auto at_rest = written.displacements();
    written.history.begin("group");
    written.write({0, 0, 0});
    const auto before = written.displacements();
    const std::uint64_t made = written.lattice.made_count();
    written.history.open_safeguard();
    for (const Vec3i coord : {Vec3i{0, 0, 0}, {1, 0, 0}, {2, 1, 0}}) written.write(coord);
    written.history.cancel_safeguard(made);
    EXPECT_EQ(written.displacements(), before);
    written.write({1, 1, 1});
    const auto after = written.displacements();
    written.history.end();
    written.history.undo();
    EXPECT_EQ(written.displacements(), at_rest);
    written.history.redo();
    EXPECT_EQ(written.displacements(), after);
}

TEST_F(HistoryTest, SafeguardsThatCloseArePartsOfTheStep) {
    WrittenLattice written(volume, arena);
    const auto at_rest = written.displacements();
    written.history.begin("group");
    for (int n = 0; n < 3; ++n) {
        written.history.open_safeguard();
        for (int x = 0; x < 3; ++x) written.write({x, n, n});
        written.write({1, 1, 1});
        written.history.close_safeguard();
    }
    const auto after = written.displacements();
    written.history.end();
    EXPECT_EQ(written.history.undo_steps(), 1);
    written.history.undo();
    EXPECT_EQ(written.displacements(), at_rest);
    written.history.redo();
    EXPECT_EQ(written.displacements(), after);
}

TEST_F(HistoryTest, AStepThatIsSetAsideGoesOnWhenItIsReopened) {
    WrittenLattice written(volume, arena);
    const auto at_rest = written.displacements();
    written.history.begin("drag");
    written.write({0, 0, 0});
    written.history.set_aside();
    EXPECT_TRUE(written.history.has_aside());
    written.history.reopen();
    EXPECT_FALSE(written.history.has_aside());
    written.write({1, 0, 0});
    written.history.set_aside();
    const auto after = written.displacements();
    EXPECT_EQ(written.history.settle(), 0);
    EXPECT_EQ(written.history.undo_steps(), 1);
    written.history.undo();
    EXPECT_EQ(written.displacements(), at_rest);
    written.history.redo();
    EXPECT_EQ(written.displacements(), after);
}

TEST_F(HistoryTest, ACancelledStepRestoresEachComponent) {
    Lattice lattice(volume, {[](int) { return ElementLimits{}; }}, 8, false);
    PlasticRest rest;
    History history(lattice, rest, arena, 10, 1'000'000);
    Random random(kHistorySeed);
    const auto write = [&] {
        const int index = lattice.ensure_brick({1, 1, 1});
        Brick& brick = lattice.brick(index);
        lattice.before_move(brick);
        for (Fixed* const u : brick.u)
            for (int n = 0; n < 512; ++n) u[n] = random.whole(-999, 999);
        lattice.update_bounds(index);
        return std::vector<std::vector<Fixed>>{{brick.u[0], brick.u[0] + 512},
                                               {brick.u[1], brick.u[1] + 512},
                                               {brick.u[2], brick.u[2] + 512}};
    };
    history.begin("first");
    const auto first = write();
    history.end();
    history.begin("second");
    const std::uint64_t made = lattice.made_count();
    const auto second = write();
    EXPECT_NE(first, second);
    history.cancel(made);
    const Brick& brick = lattice.brick(lattice.find_brick({1, 1, 1}));
    for (std::size_t a = 0; a < 3; ++a)
        EXPECT_EQ(std::vector<Fixed>(brick.u[a], brick.u[a] + 512), first[a]);
}

}  // namespace
}  // namespace pliant::test
