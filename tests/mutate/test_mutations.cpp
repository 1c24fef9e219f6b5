// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mutations: the same from the same random numbers, and mostly other bytes than before.

#include <gtest/gtest.h>

#include "mutate/mutations.h"

namespace pliant::mutate {
namespace {

TEST(Mutations, AreTheSameFromTheSameSeed) {
    const std::string good = "NRRD0004\ntype: short\nsizes: 4 3 2\n\n\1\2\3\4";
    int changed = 0, longer = 0, data_alone = 0;
    for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
        std::string one = good, other = good;
        Random a(seed), b(seed);
        mutate(one, 35, {"encoding: "}, a);
        mutate(other, 35, {"encoding: "}, b);
        EXPECT_EQ(one, other) << "seed " << seed;
        changed += one != good;
        longer += one.size() > good.size() + 1000;
        data_alone += one != good && one.starts_with(good.substr(0, 35));
    }
    EXPECT_GT(changed, 1600);
    EXPECT_GT(longer, 50);
    EXPECT_GT(data_alone, 200);
    EXPECT_LT(data_alone, 800);
}

TEST(Mutations, TakeAnyBytes) {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        Random random(seed);
        for (std::string bytes : {"", "\n", "a", "\n\n\n", "1", "=", "-."}) {
            mutate(bytes, std::size_t(random.whole(0, 4)), {}, random);
            mutate(bytes, 0, {"word"}, random);
        }
    }
}

}  // namespace
}  // namespace pliant::mutate
