// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Half floats, checksums, dirty blocks and frames, each against something simpler.
// Covers: protocol/dirty_blocks.cpp, protocol/half.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "hub/read_frames.h"
#include "hub/test_client.h"
#include "protocol/dirty_blocks.h"
#include "protocol/half.h"
#include "support/random.h"

namespace pliant::serve {
namespace {

using test::Random;

/// Value of a half float's bits, by its definition.
double value_of(std::uint16_t half) {
    const int exponent = half >> 10 & 31;
    const double rest = half & 1023;
    const double size = exponent ? std::ldexp(1024 + rest, exponent - 25) : std::ldexp(rest, -24);
    return half & 0x8000 ? -size : size;
}

TEST(Half, IsTheNearestOfAll) {
    const std::uint64_t seed = 20261121;
    SCOPED_TRACE(seed);
    Random random(seed);
    for (int n = 0; n < 600; ++n) {
        float value = 0;
        switch (n % 4) {
            case 0:
                value = float(random.real(-3000, 3000));
                break;
            case 1:
                value = float(random.ratio(1e-9, 60000));
                break;
            case 2:
                value = std::bit_cast<float>(std::uint32_t(random.next()));
                break;
            default:  // halfway between two halves
                const auto low = std::uint16_t(random.whole(0, 0x7bfe));
                value = float((value_of(low) + value_of(std::uint16_t(low + 1))) / 2);
        }
        const std::uint16_t half = half_from_float(value);
        if (std::isnan(value)) {
            EXPECT_EQ(half & 0x7fff, 0x7e00);
            continue;
        }
        const double clamped = std::clamp(double(value), -65504.0, 65504.0);
        std::uint16_t best = 0;
        for (std::uint16_t h = 0; h < 0x7c00; ++h) {
            const double d = std::abs(value_of(h) - std::abs(clamped));
            const double best_d = std::abs(value_of(best) - std::abs(clamped));
            if (d < best_d || (d == best_d && h % 2 == 0)) best = h;
        }
        if (std::signbit(value)) best |= 0x8000;
        ASSERT_EQ(half, best) << value;
        ASSERT_EQ(double(float_from_half(half)), value_of(half));
    }
}

TEST(Half, HoldsEveryWholeNumberUpTo2048) {
    for (int v = -2048; v <= 2048; ++v) EXPECT_EQ(float_from_half(half_from_float(float(v))), v);
}

TEST(Checksum, IsTheOneThatEverybodyCallsMurmur3) {
    const auto sum_of = [](std::string_view text) {
        Murmur32 sum;
        sum.add(std::as_bytes(std::span(text)));
        return sum.value();
    };
    EXPECT_EQ(sum_of(""), 0U);
    EXPECT_EQ(sum_of("test"), 0xba6bd213U);
    EXPECT_EQ(sum_of("Hello, world!"), 0xc0363e43U);
    EXPECT_EQ(sum_of("The quick brown fox jumps over the lazy dog"), 0x2e4ff723U);
}

/// Random values, whole or not.
Volume random_volume(Vec3i size, bool whole, Random& random) {
    Volume volume;
    volume.grid.size = size;
    std::vector<std::int16_t> numbers;
    std::vector<float> floats;
    for (std::size_t n = 0; n < voxel_count(volume.grid); ++n) {
        numbers.push_back(std::int16_t(random.whole(-32768, 32767)));
        floats.push_back(float(random.real(-2000, 4000)));
    }
    if (whole)
        volume.voxels = numbers;
    else
        volume.voxels = floats;
    return volume;
}

TEST(Half, OfEveryFewVoxelsIsThatOfThese) {
    Random random(8);
    for (const bool whole : {true, false}) {
        const Volume volume = random_volume({13, 9, 10}, whole, random);
        const Box3i box{{1, 0, 1}, {4, 3, 3}};
        std::vector<std::uint16_t> halves(3 * 3 * 2);
        halves_of_every(volume, 4, box, halves);
        std::size_t n = 0;
        for (const int k : {4, 8})
            for (const int j : {0, 4, 8})
                for (const int i : {4, 8, 12})
                    EXPECT_EQ(halves[n++], half_from_float(volume.at({i, j, k})));
    }
}

TEST(Checksum, OfAVolumeIsThatOfItsHalves) {
    Random random(7);
    for (const Vec3i size : {Vec3i{1, 1, 1}, {3, 5, 7}, {31, 17, 40}, {64, 64, 9}})
        for (const bool whole : {true, false}) {
            const Volume volume = random_volume(size, whole, random);
            std::vector<std::uint16_t> halves(voxel_count(volume.grid));
            halves_of_box(volume, voxel_box(volume.grid), halves);
            EXPECT_EQ(checksum_of_halves(volume), test::murmur3(halves));
            for (std::size_t n = 0; n < halves.size(); ++n) {
                const Vec3i p{int(n % std::size_t(size.x)),
                              int(n / std::size_t(size.x) % std::size_t(size.y)),
                              int(n / std::size_t(size.x) / std::size_t(size.y))};
                ASSERT_EQ(halves[n], half_from_float(volume.at(p)));
            }
        }
}

Box3i random_box(Vec3i size, Random& random) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int p = random.whole(-3, size[a] + 3), q = random.whole(-3, size[a] + 3);
        box.begin[a] = std::min(p, q);
        box.end[a] = std::max(p, q) + 1;
    }
    return box;
}

TEST(DirtyBlocks, AreAllTakenAndNothingTwice) {
    const std::uint64_t seed = 4711;
    SCOPED_TRACE(seed);
    Random random(seed);
    for (int round = 0; round < 60; ++round) {
        const Vec3i size{random.whole(1, 70), random.whole(1, 70), random.whole(1, 70)};
        DirtyBlocks dirty(size), other(size);
        std::vector<bool> due(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
        const auto at = [&](int i, int j, int k) {
            return std::size_t(i) +
                   std::size_t(size.x) * (std::size_t(j) + std::size_t(size.y) * std::size_t(k));
        };
        for (int n = random.whole(0, 6); n > 0; --n) {
            const Box3i box = random_box(size, random);
            (n % 2 ? dirty : other).mark(box);
            for (int k = std::max(box.begin.z, 0); k < std::min(box.end.z, size.z); ++k)
                for (int j = std::max(box.begin.y, 0); j < std::min(box.end.y, size.y); ++j)
                    for (int i = std::max(box.begin.x, 0); i < std::min(box.end.x, size.x); ++i)
                        due[at(i, j, k)] = true;
        }
        dirty.mark(other);
        const std::int64_t budget = random.whole(1, 50'000);
        std::int64_t covered = 0, wanted = 0;
        for (std::size_t n = 0; n < due.size(); ++n) wanted += due[n];
        for (int calls = 0; !dirty.empty(); ++calls) {
            ASSERT_LT(calls, 100'000);
            const auto boxes = dirty.take(budget);
            ASSERT_FALSE(boxes.empty());
            for (const Box3i& box : boxes) {
                ASSERT_FALSE(is_empty(box));
                for (int a = 0; a < 3; ++a) {
                    ASSERT_GE(box.begin[a], 0);
                    ASSERT_LE(box.end[a], size[a]);
                }
                for (int k = box.begin.z; k < box.end.z; ++k)
                    for (int j = box.begin.y; j < box.end.y; ++j)
                        for (int i = box.begin.x; i < box.end.x; ++i) {
                            ++covered;
                            due[at(i, j, k)] = false;
                        }
            }
        }
        EXPECT_EQ(std::count(due.begin(), due.end(), true), 0);
        EXPECT_GE(covered, wanted);
        EXPECT_TRUE(dirty.take(budget).empty());
    }
}

TEST(DirtyBlocks, OfABallCostLittleMoreThanTheBall) {
    DirtyBlocks dirty({200, 200, 200});
    std::int64_t blocks = 0;
    for (int k = 0; k < 25; ++k)
        for (int j = 0; j < 25; ++j)
            for (int i = 0; i < 25; ++i) {
                const double r = std::hypot(i - 12, j - 12, k - 12);
                if (r > 8) continue;
                ++blocks;
                dirty.mark({{8 * i, 8 * j, 8 * k}, {8 * i + 8, 8 * j + 8, 8 * k + 8}});
            }
    const auto boxes = dirty.take(1 << 30);
    std::int64_t voxels = 0;
    for (const Box3i& b : boxes) {
        const Vec3i n = b.end - b.begin;
        voxels += std::int64_t(n.x) * n.y * n.z;
        EXPECT_LE(std::int64_t(n.x) * n.y * n.z, DirtyBlocks::kMaxBoxVoxels);
    }
    EXPECT_LE(voxels, blocks * 512 * 3 / 2);
    EXPECT_LE(boxes.size(), 60U);
}

TEST(Frames, OfABoxComeBackAsTheyWere) {
    const std::uint64_t seed = 99;
    SCOPED_TRACE(seed);
    Random random(seed);
    for (int round = 0; round < 40; ++round) {
        const Vec3i size{random.whole(1, 40), random.whole(1, 40), random.whole(1, 40)};
        Volume volume = random_volume(size, round % 2 == 0, random);
        // Half of them are easy to pack.
        if (round % 4 < 2 && volume.is_16_bit())
            volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            box.begin[a] = random.whole(0, size[a] - 1);
            box.end[a] = random.whole(box.begin[a] + 1, size[a]);
        }
        const bool pack = random.whole(0, 1) == 1;
        const FrameHeader wanted{.flags = kFrameLastOfStep,
                                 .step = std::uint32_t(random.next()),
                                 .volume = std::uint32_t(random.next())};
        const std::string frame = box_frame(volume, box, wanted, pack);
        const auto header = read_frame_header(frame);
        ASSERT_TRUE(header);
        EXPECT_EQ(header->type, FrameType::Box);
        EXPECT_EQ(header->step, wanted.step);
        EXPECT_EQ(header->volume, wanted.volume);
        EXPECT_EQ(header->box, box);
        EXPECT_TRUE(header->flags & kFrameLastOfStep);
        const auto halves = read_box(frame);
        ASSERT_TRUE(halves);
        std::vector<std::uint16_t> expected(halves->size());
        halves_of_box(volume, box, expected);
        EXPECT_EQ(*halves, expected);
        if (!pack) {
            EXPECT_EQ(frame.size(), 32 + 2 * halves->size());
        }
        // Truncated or modified frames are refused or harmless.
        for (std::size_t n = 0; n < frame.size(); n += 1 + frame.size() / 50)
            EXPECT_FALSE(read_box(std::string_view(frame).substr(0, n)));
        for (int n = 0; n < 20; ++n) {
            std::string other = frame;
            other[std::size_t(random.whole(0, int(frame.size()) - 1))] ^=
                char(random.whole(1, 255));
            (void)read_box(other);
            (void)read_tools(other);
        }
    }
}

TEST(Frames, HaveTheirBytesWhereTheProtocolSays) {
    Volume volume;
    volume.grid.size = {2, 1, 1};
    volume.voxels = std::vector<std::int16_t>{1, -1000};
    const std::string frame = box_frame(volume, {{0, 0, 0}, {2, 1, 1}},
                                        {.flags = 2, .step = 0x01020304, .volume = 5}, false);
    const unsigned char expected[] = {'P', 'L', 'N', 'T', 1, 2, 1, 0, 4,    3,    2,    1,
                                      5,   0,   0,   0,   0, 0, 0, 0, 0,    0,    2,    0,
                                      1,   0,   1,   0,   4, 0, 0, 0, 0x00, 0x3c, 0xd0, 0xe3};
    ASSERT_EQ(frame.size(), sizeof expected);
    for (std::size_t n = 0; n < frame.size(); ++n)
        EXPECT_EQ(std::uint8_t(frame[n]), expected[n]) << "byte " << n;
    // Without voxels it is none.
    std::string empty = frame.substr(0, 32);
    empty[22] = empty[28] = 0;
    EXPECT_TRUE(read_frame_header(empty));
    EXPECT_FALSE(read_box(empty));
}

TEST(Frames, OfToolsComeBackAsTheyWere) {
    const std::vector<ToolPose> tools = {
        {.client = 3,
         .kind = ToolKind::Endoscope,
         .touches = true,
         .position_mm = {1, 2, 3},
         .direction = {0, 1, 0},
         .up = {0, 0, 1},
         .radius_mm = 2.5F,
         .force_n = {0, -1, 2},
         .energy_per_mm = {0, 0, -7},
         .fraction = 0.25F},
        {.client = 9, .kind = ToolKind::Sphere, .limited = true},
    };
    const std::string frame = tools_frame(tools, {.step = 4, .volume = 1});
    EXPECT_EQ(frame.size(), 32U + 2 * 80);
    const auto read = read_tools(frame);
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, tools);
    EXPECT_FALSE(read_tools(frame.substr(0, frame.size() - 1)));
}

}  // namespace
}  // namespace pliant::serve
