// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/voxel_builder.h"

#include <gtest/gtest.h>

#include <limits>

namespace pliant {
namespace {

template <class T>
Voxels built(Component component, const std::vector<T>& values,
             std::vector<std::string>* notes = nullptr) {
    std::vector<std::string> unused;
    VoxelBuilder builder(values.size());
    builder.add(component, values.data(), values.size());
    return builder.finish(notes ? *notes : unused);
}

using ShortVector = std::vector<std::int16_t>;
using Floats = std::vector<float>;

TEST(VoxelBuilder, KeepsWholeNumbersThatFitInSixteenBits) {
    EXPECT_EQ(built<std::int8_t>(Component::Int8, {-128, 127}), Voxels(ShortVector{-128, 127}));
    EXPECT_EQ(built<std::uint8_t>(Component::UInt8, {0, 255}), Voxels(ShortVector{0, 255}));
    EXPECT_EQ(built<std::int16_t>(Component::Int16, {-32768, 32767}),
              Voxels(ShortVector{-32768, 32767}));
    EXPECT_EQ(built<std::uint16_t>(Component::UInt16, {0, 32767}), Voxels(ShortVector{0, 32767}));
    EXPECT_EQ(built<std::int32_t>(Component::Int32, {-32768, 32767}),
              Voxels(ShortVector{-32768, 32767}));
    EXPECT_EQ(built<float>(Component::Float32, {-32768, 32767, -0.0f}),
              Voxels(ShortVector{-32768, 32767, 0}));
    EXPECT_EQ(built<double>(Component::Float64, {-5, 7}), Voxels(ShortVector{-5, 7}));
}

TEST(VoxelBuilder, BecomesFloatAtTheFirstValueThatDoesNotFit) {
    EXPECT_EQ(built<std::uint16_t>(Component::UInt16, {1, 32768, 2}), Voxels(Floats{1, 32768, 2}));
    EXPECT_EQ(built<std::int32_t>(Component::Int32, {1, -32769}), Voxels(Floats{1, -32769}));
    EXPECT_EQ(built<std::uint32_t>(Component::UInt32, {4000000000u}), Voxels(Floats{4e9f}));
    EXPECT_EQ(built<std::uint64_t>(Component::UInt64, {~0ull}),
              Voxels(Floats{18446744073709551616.f}));
    EXPECT_EQ(built<float>(Component::Float32, {1, 2.5f, 3}), Voxels(Floats{1, 2.5f, 3}));
    EXPECT_EQ(built<float>(Component::Float32, {32768}), Voxels(Floats{32768}));
}

TEST(VoxelBuilder, StaysFloatForLaterPieces) {
    VoxelBuilder builder(3);
    const float half = 0.5f;
    const std::int16_t whole = 7;
    builder.add(Component::Int16, &whole, 1);
    builder.add(Component::Float32, &half, 1);
    builder.add(Component::Int16, &whole, 1);
    std::vector<std::string> notes;
    EXPECT_EQ(builder.finish(notes), Voxels(Floats{7, 0.5f, 7}));
    EXPECT_TRUE(notes.empty());
}

TEST(VoxelBuilder, MakesValuesThatAreNotFiniteAirAndSaysSo) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    std::vector<std::string> notes;
    EXPECT_EQ(built<float>(Component::Float32, {kNan, 3, -kInf}, &notes),
              Voxels(ShortVector{kAirHu, 3, kAirHu}));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], "2 voxels had no finite value and became air");
    EXPECT_EQ(built<float>(Component::Float32, {0.5f, kInf}), Voxels(Floats{0.5f, kAirHu}));
    EXPECT_EQ(built<double>(Component::Float64, {0.5, 1e300}), Voxels(Floats{0.5f, kAirHu}));
}

TEST(VoxelBuilder, SaysWhenFloatsCannotHoldTheStoredNumbers) {
    std::vector<std::string> notes;
    (void)built<std::int32_t>(Component::Int32, {16777217, 40000}, &notes);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], "1 voxel rounded to 32-bit floats");
    notes.clear();
    (void)built<double>(Component::Float64, {0.5, 0.25}, &notes);
    EXPECT_TRUE(notes.empty());
}

}  // namespace
}  // namespace pliant
