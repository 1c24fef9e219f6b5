// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: base/assert.cpp, pliant/result.h.

#include <pliant/result.h>

#include <gtest/gtest.h>

#include <memory>

namespace pliant {
namespace {

TEST(Result, HoldsAValueOrAnError) {
    Result<int> good = 5;
    EXPECT_TRUE(good.ok());
    EXPECT_EQ(*good, 5);
    const Result<int> bad = Error{ErrorCode::NotFound, "a: is missing"};
    EXPECT_FALSE(bad);
    EXPECT_EQ(bad.error().code, ErrorCode::NotFound);
    EXPECT_EQ(bad.error().message, "a: is missing");
}

TEST(Result, GivesItsValueAway) {
    Result<std::unique_ptr<int>> owner = std::make_unique<int>(7);
    const std::unique_ptr<int> taken = std::move(owner).value();
    EXPECT_EQ(*taken, 7);
}

#ifdef PLIANT_ASSERTIONS
TEST(ResultDeathTest, AskingForTheWrongOneIsTheProgrammersMistake) {
    const Result<int> bad = Error{};
    EXPECT_DEATH((void)bad.value(), "assertion failed: ok");
}
#endif

}  // namespace
}  // namespace pliant
