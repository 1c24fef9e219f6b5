// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random sequences of operations give the same bits on each instruction set of this machine.
// `./dev differential` runs a million of them.
// Covers: support/random_operations.cpp.

#include "support/random_operations.h"

#include <gtest/gtest.h>

#include <map>

namespace pliant::test {
namespace {

constexpr std::uint64_t kFirstSeed = 20261201;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kSequences = 20;
#else
constexpr int kSequences = 150;
#endif

TEST(RandomOperations, GiveTheSameBitsOnEveryInstructionSet) {
    const auto targets = own_targets();
    ASSERT_FALSE(targets.empty());
    for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSequences; ++seed) {
        std::vector<OperationHash> expected;
        for (const std::int64_t target : targets) {
            const OnTarget on(target);
            const auto found = run_random_operations(seed);
            if (target == targets[0]) expected = found;
            ASSERT_EQ(found.size(), expected.size()) << name_of_target(target) << ", seed " << seed;
            for (std::size_t n = 0; n < found.size(); ++n)
                ASSERT_EQ(found[n].hash, expected[n].hash)
                    << name_of_target(target) << ", seed " << seed << ", operation " << n << ", "
                    << found[n].name;
        }
    }
}

TEST(RandomOperations, ContainEachOperationAndMoveTissue) {
    std::map<std::string_view, int> count, changed;
    for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 100; ++seed) {
        const auto found = run_random_operations(seed);
        for (std::size_t n = 0; n < found.size(); ++n) {
            ++count[found[n].name];
            changed[found[n].name] += n == 0 || found[n].hash != found[n - 1].hash;
        }
    }
    for (const char* name : {"push", "drag", "slide", "cut", "carve", "undo", "redo", "relax",
                             "save", "reset", "drive"})
        EXPECT_GT(count[name], 0) << name;
    EXPECT_EQ(count["look"], 100);
    EXPECT_GT(changed["push"], count["push"] / 2);
}

}  // namespace
}  // namespace pliant::test
