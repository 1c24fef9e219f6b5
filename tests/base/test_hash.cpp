// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/hash.h"

#include <gtest/gtest.h>
#include <pliant/core/vec.h>

#include <set>
#include <vector>

namespace pliant {
namespace {

std::uint64_t hash_of(const std::vector<std::uint8_t>& bytes) {
    Hash64 hash;
    hash.add(std::span<const std::uint8_t>(bytes));
    return hash.value();
}

TEST(Hash64, IsTheSameForTheSameBytes) {
    EXPECT_EQ(hash_of({1, 2, 3}), hash_of({1, 2, 3}));
}

TEST(Hash64, ChangesWithEveryBitAndWithTheLength) {
    std::set<std::uint64_t> seen;
    std::vector<std::uint8_t> bytes(19, 0);
    seen.insert(hash_of(bytes));
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        bytes[bit / 8] ^= std::uint8_t(1 << bit % 8);
        EXPECT_TRUE(seen.insert(hash_of(bytes)).second) << bit;
        bytes[bit / 8] ^= std::uint8_t(1 << bit % 8);
    }
    for (std::size_t size = 0; size < 40; ++size) {
        if (size == bytes.size()) continue;
        EXPECT_TRUE(seen.insert(hash_of(std::vector<std::uint8_t>(size, 0))).second) << size;
    }
}

TEST(Hash64, DependsOnTheOrder) {
    Hash64 one, other;
    one.add_word(1), one.add_word(2);
    other.add_word(2), other.add_word(1);
    EXPECT_NE(one.value(), other.value());
}

TEST(Hash64, KeepsItsGoldenValue) {
    EXPECT_EQ(Hash64().value(), 0x51ed270b2a8d5f1bULL);
    Hash64 hash;
    hash.add_word(42);
    EXPECT_EQ(hash.value(), 0xc5abfb1f2f93f45bULL);
}

template <class T>
std::uint64_t hash_of_numbers(const std::vector<T>& numbers) {
    Hash64 hash;
    hash.add(std::span<const T>(numbers));
    return hash.value();
}

TEST(Hash64, OfNumbersIsTheSameForEachByteOrder) {
    EXPECT_EQ(hash_of({1, 2, 3, 4, 5, 6, 7, 8, 9}), 0x94506e6856509dfdULL);
    EXPECT_EQ(hash_of_numbers<std::int16_t>({1, -2, 300, 4, -500}), 0x32fa49c69299973eULL);
    EXPECT_EQ(hash_of_numbers<float>({1.5F, -2, 3}), 0x43ec8fcf6529c0f1ULL);
    EXPECT_EQ(hash_of_numbers<double>({1.5, -2}), 0x73b3c958b20bc2ebULL);
    EXPECT_EQ(hash_of_numbers<Vec3f>({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}), 0x717967ccc463aba1ULL);
}

}  // namespace
}  // namespace pliant
