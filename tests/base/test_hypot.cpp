// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/hypot.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>

#include "base/hash.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::uint64_t bits_of(double value) {
    return std::bit_cast<std::uint64_t>(value);
}

/// Numbers of all sizes that are finite.
double any_number(Random& random) {
    for (;;) {
        const double number = std::bit_cast<double>(random.next());
        if (std::isfinite(number)) return number;
    }
}

TEST(Hypot, HasTheRecordedBitsOnAllMachines) {
    Random random(1);
    Hash64 hash;
    for (int n = 0; n < 200'000; ++n) {
        const bool any = n % 2;
        const double x = any ? any_number(random) : random.real(-50, 50);
        const double y = any ? any_number(random) : random.real(-50, 50);
        const double h = pliant::hypot(x, y);
        hash.add_word(bits_of(h));
        // Within a unit in the last place.
        const double exact = std::hypot(x, y);
        ASSERT_LE(std::abs(std::int64_t(bits_of(h)) - std::int64_t(bits_of(exact))), 1)
            << x << " " << y;
    }
    EXPECT_EQ(hash.value(), 0xfb2d4a44f1f1fba2u);
}

TEST(Hypot, IsExactForWholeTrianglesOfAllSizes) {
    for (const double size : {1.0, 0x1p-1070, 0x1p-1020, 0x1p-500, 0x1p500, 0x1p1020})
        for (const auto& [a, b, c] : {std::array{3.0, 4.0, 5.0}, {5.0, 12.0, 13.0}, {8, 0, 8}}) {
            EXPECT_EQ(pliant::hypot(size * a, -size * b), size * c) << size;
            EXPECT_EQ(pliant::hypot(-size * b, size * a), size * c) << size;
        }
}

TEST(Hypot, KnowsZeroInfinityAndNoNumber) {
    EXPECT_EQ(bits_of(pliant::hypot(-0.0, 0)), bits_of(0));
    EXPECT_EQ(pliant::hypot(kInfinity, std::nan("")), kInfinity);
    EXPECT_EQ(pliant::hypot(1, -kInfinity), kInfinity);
    EXPECT_TRUE(std::isnan(pliant::hypot(std::nan(""), 1)));
    EXPECT_TRUE(std::isnan(pliant::hypot(1, std::nan(""))));
    EXPECT_EQ(pliant::hypot(1.7e308, 1.7e308), kInfinity);
}

}  // namespace
}  // namespace pliant::test
