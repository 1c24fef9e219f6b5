// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Copies, writes and moves in any order against plain vectors, and their memory.
// Covers: pliant/volume.h, volume/voxel_memory.cpp.

#include <pliant/volume.h>

#include "support/random.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <string>
#include <thread>

namespace pliant {
namespace {

using Shorts = VoxelArray<std::int16_t>;

constexpr std::size_t kLarge = 3'000'001;  // 6 MB, and no whole number of pages

std::vector<std::int16_t> ramp(std::size_t count, int first = 0) {
    std::vector<std::int16_t> values(count);
    for (std::size_t n = 0; n < count; ++n) values[n] = std::int16_t(first + int(n * 7));
    return values;
}

bool holds(const Shorts& array, const std::vector<std::int16_t>& values) {
    return array.size() == values.size() && std::equal(array.begin(), array.end(), values.begin());
}

/// Whether the array's pieces, one after the other, are these values.
bool pieces_hold(const Shorts& array, const std::vector<std::int16_t>& values) {
    std::vector<std::int16_t> all;
    const bool whole = array.for_each_piece(
        [&](std::span<const std::int16_t> p) { all.insert(all.end(), p.begin(), p.end()); });
    return whole && all == values;
}

std::string bytes_of(const std::vector<std::int16_t>& values) {
    return {reinterpret_cast<const char*>(values.data()), 2 * values.size()};
}

/// A number of kilobytes from /proc/self/status.
double kilobytes(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string word; file >> word;)
        if (double value = 0; word == name + ":" && file >> value) return value;
    return -1;
}

TEST(VoxelArray, HoldsWhatItWasMadeOf) {
    for (const std::size_t count : {std::size_t(0), std::size_t(1), std::size_t(5000), kLarge}) {
        const auto values = ramp(count);
        const Shorts array = values;
        EXPECT_TRUE(holds(array, values)) << count;
        EXPECT_TRUE(pieces_hold(array, values)) << count;
        EXPECT_EQ(array.empty(), count == 0);
        const Shorts zeros(count);
        EXPECT_TRUE(holds(zeros, std::vector<std::int16_t>(count))) << count;
        EXPECT_EQ(array == zeros, count < 2);
    }
    EXPECT_TRUE(holds(Shorts{4, -5}, {4, -5}));
    EXPECT_TRUE(Shorts().empty());
}

TEST(VoxelArray, CopiesAreIndependentInBothDirections) {
    for (const std::size_t count : {std::size_t(1000), kLarge}) {
        auto values = ramp(count);
        Shorts first = values;
        Shorts second = first;
        second[count / 2] = 11;
        EXPECT_TRUE(holds(first, values));
        first[count - 1] = 12;
        EXPECT_EQ(second[count - 1], values[count - 1]);
        const Shorts third = second;  // of one that was changed
        second[count / 2] = 13;
        values[count / 2] = 11;
        EXPECT_TRUE(holds(third, values));
        first = {};
        second = {};
        EXPECT_TRUE(holds(third, values));
    }
}

TEST(VoxelArray, WhatIsNotFrozenIsCopiedAsItIs) {
    Shorts first(kLarge);
    first[5] = 7;
    const Shorts second = first;
    first[5] = 8;
    first.freeze();
    const Shorts third = first;
    first[5] = 9;
    EXPECT_EQ(second[5], 7);
    EXPECT_EQ(third[5], 8);
    EXPECT_EQ(first[5], 9);
}

TEST(VoxelArray, MovingTakesTheValuesAlong) {
    const auto values = ramp(kLarge);
    Shorts first = values;
    const std::int16_t* place = first.data();
    Shorts second = std::move(first);
    EXPECT_EQ(second.data(), place);
    Shorts third = {1, 2};
    third = std::move(second);
    EXPECT_EQ(third.data(), place);
    EXPECT_TRUE(holds(third, values));
    const Shorts& same = third;
    third = same;
    EXPECT_TRUE(holds(third, values));
}

TEST(VoxelArray, AnyOrderOfCopiesAndWritesGivesWhatVectorsGive) {
    const std::uint64_t seed = 20261;
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const test::TemporaryFolder folder;
    const auto on_disk = ramp(900'000, 3);
    const auto path = folder.write("a.raw", "xx" + bytes_of(on_disk));
    std::vector<Shorts> arrays(4);
    std::vector<std::vector<std::int16_t>> expected(4);
    for (int step = 0; step < 1500; ++step) {
        const auto a = std::size_t(random.whole(0, 3)), b = std::size_t(random.whole(0, 3));
        switch (random.whole(0, 9)) {
            case 0:
                expected[a] = ramp(std::size_t(random.whole(400'000, 700'000)), step);
                arrays[a] = expected[a];
                break;
            case 1:
                expected[a] = on_disk;
                arrays[a] = *Shorts::mapped(path, 2, on_disk.size());
                break;
            case 2:
                expected[a] = std::vector<std::int16_t>(600'000);
                arrays[a] = Shorts(600'000);
                break;
            case 3:
                arrays[a].freeze();
                arrays[b].let_go();
                break;
            case 4:
            case 5:
                expected[a] = expected[b];
                arrays[a] = arrays[b];
                break;
            default:  // one page, or several
                if (expected[a].empty()) break;
                for (int n = 0; n < random.whole(1, 5); ++n) {
                    const auto at = std::size_t(random.whole(0, int(expected[a].size()) - 1));
                    arrays[a][at] = expected[a][at] = std::int16_t(step);
                }
        }
        if (step % 10 > 0) continue;
        for (std::size_t n = 0; n < 4; ++n) {
            ASSERT_TRUE(holds(arrays[n], expected[n])) << "step " << step;
            ASSERT_TRUE(pieces_hold(arrays[n], expected[n])) << "step " << step;
        }
    }
    EXPECT_EQ(test::bytes_of(path), "xx" + bytes_of(on_disk));
}

TEST(VoxelArray, ACopyCostsOnlyThePagesThatAreWritten) {
    const Shorts first = ramp(40'000'000);  // 80 MB
    const double before = kilobytes("RssAnon");
    if (before < 0) GTEST_SKIP() << "this system doesn't say what is in memory";
    Shorts second = first;
    for (std::size_t n = 0; n < second.size(); n += 2'000'000) second[n] = 1;
    const Shorts third = second;
    EXPECT_LT(kilobytes("RssAnon") - before, 8000);
    EXPECT_EQ(third[2'000'000], 1);
}

TEST(VoxelArray, RunningThroughTheFilesPagesLeavesThemOutOfMemory) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.raw", bytes_of(ramp(40'000'000)));
    const double before = kilobytes("VmRSS");
    if (before < 0) GTEST_SKIP() << "this system doesn't say what is in memory";
    const auto array = Shorts::mapped(path, 0, 40'000'000);
    ASSERT_TRUE(array);
    std::int64_t sum = 0;
    EXPECT_TRUE(array->for_each_piece([&](std::span<const std::int16_t> piece) {
        sum = std::accumulate(piece.begin(), piece.end(), sum);
    }));
    EXPECT_LT(kilobytes("VmRSS") - before, 20000);
    EXPECT_EQ(sum, std::accumulate(array->begin(), array->end(), std::int64_t(0)));
}

TEST(VoxelArray, LettingGoFreesMemoryAndLosesNothing) {
    auto values = ramp(40'000'000);
    Shorts array = values;
    for (std::size_t n = 0; n < values.size(); n += 1'234'567) array[n] = values[n] = -3;
    EXPECT_TRUE(holds(array, values));
    const double before = kilobytes("VmRSS");
    array.let_go();
    const double after = kilobytes("VmRSS");
    EXPECT_TRUE(holds(array, values));
    Shorts small = {1, 2, 3};
    small.let_go();
    EXPECT_TRUE(holds(small, {1, 2, 3}));
    Shorts open(kLarge);
    open[9] = 9;
    open.let_go();
    EXPECT_EQ(open[9], 9);
    if (before < 0) GTEST_SKIP() << "this system doesn't say what is in memory";
    EXPECT_LT(after, before - 60000);
}

TEST(VoxelArray, ThreadsMayCopyTheSameArray) {
    auto values = ramp(kLarge);
    Shorts first = values;
    first[77] = values[77] = -1;
    std::vector<std::thread> threads;
    std::vector<Shorts> copies(4);
    for (std::size_t n = 0; n < 4; ++n)
        threads.emplace_back([&, n] {
            const Shorts& source = first;
            copies[n] = source;
            copies[n][78] = std::int16_t(n);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_TRUE(holds(first, values));
    for (std::size_t n = 0; n < 4; ++n) {
        values[78] = std::int16_t(n);
        EXPECT_TRUE(holds(copies[n], values)) << n;
    }
}

TEST(VoxelArray, WithoutAnyMoreFilesItStillHoldsAndCopies) {
    auto values = ramp(kLarge);
    Shorts early = values;
    early[3] = values[3] = 99;
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
    rlimit none = limit;
    none.rlim_cur = 0;
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
    const Shorts made = values, copied = early, copied_twice = copied;
    const bool pieces = pieces_hold(early, values);
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
    EXPECT_TRUE(pieces);
    EXPECT_TRUE(holds(made, values));
    EXPECT_TRUE(holds(copied, values));
    EXPECT_TRUE(holds(copied_twice, values));
}

TEST(MappedVoxelArray, ShowsTheFileAndNeverChangesIt) {
    const test::TemporaryFolder folder;
    const auto values = ramp(kLarge);
    for (const std::size_t offset : {0, 2, 4094, 4096, 10'000}) {
        const auto path = folder.write("a.raw", std::string(offset, 'x') + bytes_of(values) + "yy");
        auto array = Shorts::mapped(path, offset, kLarge);
        ASSERT_TRUE(array) << offset;
        EXPECT_TRUE(holds(*array, values)) << offset;
        for (std::size_t n = 0; n < kLarge; n += 1000) (*array)[n] = 1;
        const Shorts copy = *array;
        EXPECT_EQ(copy[1000], 1);
        EXPECT_EQ(copy[1001], values[1001]);
        EXPECT_EQ(test::bytes_of(path).substr(offset, 2 * kLarge), bytes_of(values)) << offset;
    }
}

TEST(MappedVoxelArray, LivesOnWhenTheFileIsReplacedOrRemoved) {
    const test::TemporaryFolder folder;
    const auto values = ramp(kLarge);
    const auto path = folder.write("a.raw", bytes_of(values));
    const auto array = Shorts::mapped(path, 0, kLarge);
    ASSERT_TRUE(array);
    std::filesystem::rename(folder.write("b.raw", "other"), path);
    EXPECT_TRUE(holds(*array, values));
    std::filesystem::remove(path);
    const Shorts copy = *array;
    EXPECT_TRUE(holds(copy, values));
}

TEST(ViewedVoxelArray, IsTheHostsMemoryAndItsCopiesAreNot) {
    for (const std::size_t count : {std::size_t(0), std::size_t(5000), kLarge}) {
        std::vector<std::int16_t> values = ramp(count);
        const auto expected = values;
        const Shorts view = Shorts::viewed(std::span<const std::int16_t>(values));
        if (count > 0) {
            EXPECT_EQ(view.data(), values.data());
        }
        EXPECT_TRUE(pieces_hold(view, expected));
        Shorts copy = view, moved = Shorts::viewed(std::span(values));
        EXPECT_TRUE(holds(copy, expected));
        const Shorts target = std::move(moved);
        view.let_go();
        for (std::int16_t& value : values) ++value;
        EXPECT_TRUE(holds(view, values));
        EXPECT_TRUE(holds(target, values));
        EXPECT_TRUE(holds(copy, expected));
        for (std::int16_t& value : copy) value = 7;
        EXPECT_TRUE(holds(view, values));
    }
    // Writes go to the host.
    std::vector<std::int16_t> values(100, 1);
    Shorts view = Shorts::viewed(std::span(values));
    view[42] = 5;
    view.freeze();
    EXPECT_EQ(values[42], 5);
}

TEST(MappedVoxelArray, IsRefusedWhereTheFileDoesNotHoldIt) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.raw", std::string(1000, 'x'));
    EXPECT_TRUE(Shorts::mapped(path, 0, 500));
    EXPECT_FALSE(Shorts::mapped(path, 0, 501));
    EXPECT_FALSE(Shorts::mapped(path, 2, 500));
    EXPECT_FALSE(Shorts::mapped(path, 1, 400)) << "an odd place";
    EXPECT_FALSE(Shorts::mapped(path, 2000, 1));
    EXPECT_FALSE(Shorts::mapped(path, 0, 0));
    EXPECT_FALSE(Shorts::mapped(folder / "gone.raw", 0, 1));
    EXPECT_FALSE(Shorts::mapped(folder.path(), 0, 1)) << "a folder";
}

TEST(MappedVoxelArray, RunningThroughAFileThatWasCutShortSaysSo) {
    const test::TemporaryFolder folder;
    const auto path = folder.write("a.raw", bytes_of(ramp(kLarge)));
    const auto array = Shorts::mapped(path, 0, kLarge);
    ASSERT_TRUE(array);
    std::filesystem::resize_file(path, 1'000'000);
    std::size_t count = 0;
    std::int16_t last = -1;
    EXPECT_FALSE(array->for_each_piece([&](std::span<const std::int16_t> piece) {
        count += piece.size();
        last = piece.back();
    }));
    EXPECT_EQ(count, kLarge);
    EXPECT_EQ(last, 0);
}

}  // namespace
}  // namespace pliant
