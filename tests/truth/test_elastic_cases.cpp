// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases of the elastic scan: each motion again by make_elastic(), exact inverses, bone at rest.
// Covers: truth/maker.cpp, truth/motions.cpp.

#include <gtest/gtest.h>
#include <pliant/data/truth.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <random>

#include "support/made.h"

namespace pliant::test {
namespace {

class ElasticTruth : public ::testing::Test {
  protected:
    static std::uint64_t drawn_seed() { return std::random_device{}() % 1'000'000; }
    static Volume phantom(const char* name, int size) {
        const TaskArena arena(2);
        return made(make_phantom({.name = name, .size = {size, size, size}}, arena)).volume;
    }
    static TruthMaker maker_of(const Volume& scan, const TruthSettings& settings,
                               const TaskArena& arena) {
        auto maker = TruthMaker::create(scan, ElasticScanSettings{}, settings, arena);
        EXPECT_TRUE(maker.ok()) << maker.error().message;
        return std::move(*maker);
    }
    static std::int16_t value(const Volume& volume, std::size_t n) {
        return (*std::get_if<VoxelArray<std::int16_t>>(&volume.voxels))[n];
    }

    TaskArena m_arena{2};
};

TEST_F(ElasticTruth, FieldsAreThoseOfTheSameMotionsByTheTissue) {
    std::uint64_t seed = drawn_seed();
    const Volume scan = phantom("airway", 40);
    const TruthMaker maker = maker_of(scan, {.kinds = "contact", .motions = 1}, m_arena);
    auto made = maker.make(seed);
    // A motion that is too short is followed by another one.
    while (made.ok() && made->motions.size() > 1) made = maker.make(++seed);
    SCOPED_TRACE("seed " + std::to_string(seed));
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto tissue = make_elastic(scan, {}, m_arena);
    ASSERT_TRUE(tissue.ok());
    const TruthMotion& motion = made->motions.back();
    const auto report = (*tissue)->push(1, {.point_mm = motion.point_mm,
                                            .push_mm = motion.motion_mm,
                                            .sphere_radius_mm = motion.radius_mm});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->step_fraction, motion.fraction);
    const auto settled = (*tissue)->advance({.max_steps = 1000});
    ASSERT_TRUE(settled.ok() && settled->settled);
    ASSERT_TRUE((*tissue)->update_deformation().ok());
    std::size_t n = 0;
    double largest = 0;
    for (int k = 0; k < 40; ++k)
        for (int j = 0; j < 40; ++j)
            for (int i = 0; i < 40; ++i, ++n) {
                const Vec3d u = (*tissue)->deformation().displacement_mm({i, j, k});
                const Vec3f f = made->forward.vectors_mm[n];
                ASSERT_LT(norm(u - Vec3d{f.x, f.y, f.z}), 1e-5);
                largest = std::max(largest, norm(u));
            }
    EXPECT_NEAR(largest, made->max_displacement_mm, 1e-5);
    EXPECT_GT(largest, 0.1);
}

TEST_F(ElasticTruth, FieldsAreInversesWhereTheMasksSaySo) {
    const std::uint64_t drawn = drawn_seed();
    const Volume scan = phantom("airway", 40);
    for (const char* const kinds : {"contact", "slide", "contact,breathing"}) {
        SCOPED_TRACE(kinds);
        const TruthMaker maker = maker_of(scan, {.kinds = kinds, .motions = 2}, m_arena);
        std::uint64_t seed = drawn;
        auto made = maker.make(seed);
        // Balls that hardly touch the wall leave no voxel for a landmark: 3 of 40 cases of slides.
        while (made.ok() && made->max_displacement_mm < 2 * kTruthMovedMm)
            made = maker.make(++seed);
        SCOPED_TRACE("seed " + std::to_string(seed));
        ASSERT_TRUE(made.ok()) << made.error().message;
        EXPECT_LE(made->inverse_error_mm, 1e-4);
        EXPECT_LE(made->landmark_error_mm, 1e-4);
        EXPECT_GT(made->landmarks.size(), 10U);
        std::int64_t moved = 0, tissue = 0, ambiguous = 0;
        const auto nx = std::size_t(scan.grid.size.x), ny = std::size_t(scan.grid.size.y);
        for (std::size_t n = 0; n < voxel_count(scan.grid); ++n) {
            if (value(made->labels, n) != std::int16_t(TruthLabel::Air)) {
                ++tissue;
                ambiguous += value(made->fixed_mask, n) == std::int16_t(TruthMask::Ambiguous);
            }
            const Vec3f v = made->inverse.vectors_mm[n];
            if (value(made->moving_mask, n) != 0 || v == Vec3f{0, 0, 0}) continue;
            ++moved;
            if (n % 5) continue;
            const Vec3d p = world_from_voxel(
                scan.grid, {double(n % nx), double(n / nx % ny), double(n / nx / ny)});
            const auto back = made->map->moving_from_fixed(p + Vec3d{v.x, v.y, v.z});
            ASSERT_TRUE(back);
            EXPECT_LE(norm(*back - p), 1e-4);
        }
        EXPECT_GT(moved, 500);
        EXPECT_LT(double(ambiguous), 0.02 * double(tissue));
    }
}

TEST_F(ElasticTruth, SameBitsForAnyNumberOfThreads) {
    const std::uint64_t seed = drawn_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("airway", 40);
    const TaskArena one(1);
    const TruthSettings settings{.kinds = "contact,slide", .motions = 2};
    const auto expected = maker_of(scan, settings, one).make(seed);
    const auto again = maker_of(scan, settings, m_arena).make(seed);
    const auto another = maker_of(scan, settings, m_arena).make(seed + 1);
    ASSERT_TRUE(expected.ok() && again.ok() && another.ok());
    EXPECT_EQ(again->hash, expected->hash);
    EXPECT_NE(another->hash, expected->hash);
}

TEST_F(ElasticTruth, BoneNeverMovesAndLabelsFollowTheModuli) {
    const std::uint64_t seed = drawn_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("knee", 48);
    const auto made = maker_of(scan, {.kinds = "contact", .motions = 2}, m_arena).make(seed);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::int64_t bone = 0;
    for (std::size_t n = 0; n < voxel_count(scan.grid); ++n) {
        const auto label = TruthLabel(value(made->labels, n));
        EXPECT_EQ(label == TruthLabel::Air, value(scan, n) <= -950);  // void
        EXPECT_EQ(label == TruthLabel::Bone, value(scan, n) > 300);
        if (label != TruthLabel::Bone) continue;
        ++bone;
        EXPECT_EQ(made->forward.vectors_mm[n], (Vec3f{0, 0, 0}));
    }
    EXPECT_GT(bone, 100);
}

TEST_F(ElasticTruth, WhatItCanNotDoIsNamed) {
    const Volume scan = phantom("airway", 24);
    for (const char* const kinds : {"cut", "contact,interface"}) {
        const auto maker =
            TruthMaker::create(scan, ElasticScanSettings{}, {.kinds = kinds}, m_arena);
        ASSERT_FALSE(maker.ok());
        EXPECT_EQ(maker.error().field, "kinds");
        EXPECT_NE(maker.error().message.find("without cuts"), std::string::npos);
    }
    const auto wrong = TruthMaker::create(scan, ElasticScanSettings{.window_cells = 9},
                                          {.kinds = "contact"}, m_arena);
    ASSERT_FALSE(wrong.ok());
    EXPECT_NE(wrong.error().message.find("window_cells"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
