// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases and scores whose n-th allocation fails: LimitExceeded, and the next case is the same.
// Covers: truth/maker.cpp, truth/score.cpp.

#include <gtest/gtest.h>
#include <pliant/data/truth.h>

#include <random>

#include "support/each_allocation_of.h"
#include "support/made.h"

namespace pliant::test {
namespace {

class TruthOutOfMemory : public ::testing::TestWithParam<int> {
  protected:
    static EachAllocation some() {
        return {.all_up_to = 25, .of_the_rest = 25, .seed = std::random_device{}()};
    }
    static Volume made_scan(const TaskArena& arena) {
        return made(make_phantom({.name = "airway", .size = {24, 24, 24}}, arena)).volume;
    }

    TaskArena m_arena{GetParam()};
    Volume m_scan = made_scan(m_arena);
    TruthSettings m_settings{.kinds = "contact,slide,cut,breathing", .motions = 3, .landmarks = 20};
};

TEST_P(TruthOutOfMemory, MakesAMakerOrNone) {
    const Failures failures = fail_each_allocation_of(
        [&] { return TruthMaker::create(m_scan, {}, m_settings, m_arena); }, some());
    EXPECT_GT(failures.failed, 20);
}

TEST_P(TruthOutOfMemory, MakesACaseOrNoneAndTheSameOneAfterwards) {
    const auto maker = TruthMaker::create(m_scan, {}, m_settings, m_arena);
    ASSERT_TRUE(maker.ok()) << maker.error().message;
    const auto expected = maker->make(3);
    ASSERT_TRUE(expected.ok()) << expected.error().message;
    const Failures failures = fail_each_allocation_of([&] { return maker->make(3); }, some());
    EXPECT_GT(failures.failed, 20);
    const auto again = maker->make(3);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->hash, expected->hash);
}

TEST_P(TruthOutOfMemory, ScoresOrDoesNot) {
    const auto maker = TruthMaker::create(m_scan, {}, m_settings, m_arena);
    ASSERT_TRUE(maker.ok()) << maker.error().message;
    const auto one = maker->make(3);
    ASSERT_TRUE(one.ok()) << one.error().message;
    const TruthData& truth = *one;
    std::vector<Vec3d> points;
    for (const TruthLandmark& landmark : one->landmarks) points.push_back(landmark.moving_mm);
    fail_each_allocation_of([&] { return score_field(truth, one->forward, m_arena); }, some());
    fail_each_allocation_of([&] { return score_nothing(truth, m_arena); }, some());
    fail_each_allocation_of([&] { return score_points(truth, points); }, some());
}

INSTANTIATE_TEST_SUITE_P(Threads, TruthOutOfMemory, ::testing::Values(1, 2));

}  // namespace
}  // namespace pliant::test
