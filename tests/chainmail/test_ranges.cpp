// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans of any range of values: the same tissue in other numbers moves in the same way.
// Covers: material/material.cpp, material/settings_rows.cpp, pliant/chainmail.h.

#include <gtest/gtest.h>
#include <pliant/resample.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "chainmail/tissues.h"
#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Tissue with a cave of air, and bone, in HU.
Volume body() {
    Random random(5);
    return volume_of({40, 36, 32}, [&](Vec3i e) {
        const Vec3d from{e.x - 14.0, e.y - 18.0, e.z - 16.0};
        if (norm(from) < 7) return -1000 + random.whole(0, 60);
        return e.x > 34 ? 900 : random.whole(-120, 260);
    });
}

/// The values times a factor, plus a shift.
template <class T>
Volume converted(const Volume& body, double factor, double shift) {
    Volume other;
    other.grid = body.grid;
    std::vector<T> values;
    for (const std::int16_t v : std::get<0>(body.voxels)) values.push_back(T(v * factor + shift));
    other.voxels = VoxelArray<T>(values);
    other.background = float(kAirHu * factor + shift);
    return other;
}

ChainMailSettings converted(double factor, double shift) {
    ChainMailSettings settings;
    settings.range = {-1000 * factor + shift, 3095 * factor + shift};
    settings.bone_threshold_hu = 300 * factor + shift;
    settings.air_threshold_hu = -500.5 * factor + shift;
    return settings;
}

class RangeTest : public ::testing::Test {
  protected:
    std::uint64_t hash_after_pushes(const Volume& volume, const ChainMailSettings& settings) {
        ChainMail tissue = tissue_of(volume, m_arena, settings);
        for (const Vec3d way : {Vec3d{3, 0, 0}, Vec3d{0, -4, 1}, Vec3d{30, 0, 0}})
            made(tissue.push({.point_mm = {22, 18, 16}, .push_mm = way, .sphere_radius_mm = 2}));
        return tissue.hash();
    }
    TaskArena m_arena{2};
};

TEST_F(RangeTest, TissueInOtherNumbersMovesByTheSameBits) {
    const Volume hu = body();
    const std::uint64_t expected = hash_after_pushes(hu, {});
    EXPECT_EQ(hash_after_pushes(converted<float>(hu, 1.0 / 4095, 1000.0 / 4095),
                                converted(1.0 / 4095, 1000.0 / 4095)),
              expected);
    EXPECT_EQ(hash_after_pushes(converted<float>(hu, 16, 16000), converted(16, 16000)), expected);
    EXPECT_EQ(hash_after_pushes(converted<float>(hu, 1e-6, 0), converted(1e-6, 0)), expected);
    EXPECT_EQ(hash_after_pushes(converted<std::int16_t>(hu, 1, 1000), converted(1, 1000)),
              expected);
    EXPECT_EQ(hash_after_pushes(converted<std::int16_t>(hu, 5, 8000), converted(5, 8000)),
              expected);
    // The settings count: with those of HU, the same floats are one material.
    EXPECT_NE(hash_after_pushes(converted<float>(hu, 1.0 / 4095, 1000.0 / 4095), {}), expected);
}

TEST_F(RangeTest, AFloatScanInHuMovesLikeTheSameIn16Bits) {
    const Volume hu = body();
    EXPECT_EQ(hash_after_pushes(converted<float>(hu, 1, 0), {}), hash_after_pushes(hu, {}));
}

TEST_F(RangeTest, PercentilesAreTheRangeOfTheScansValues) {
    const Volume hu = body();
    ChainMailSettings by_percent, by_value;
    by_percent.range_percent = ValueSpan{0, 100};
    by_value.range = {-1000, 900};
    EXPECT_EQ(hash_after_pushes(hu, by_percent), hash_after_pushes(hu, by_value));
    EXPECT_NE(hash_after_pushes(hu, by_percent), hash_after_pushes(hu, {}));
}

TEST_F(RangeTest, BrightTissueOfAnMrIsPushed) {
    // Above 3095, which is rigid in CT.
    Volume head = volume_of({32, 32, 32}, [](Vec3i e) { return e.x < 4 ? 20 : 7000 + e.y; });
    head.background = 20;
    const Push push{.point_mm = {16, 16, 16}, .push_mm = {2, 0, 0}, .sphere_radius_mm = 2};
    ChainMail as_ct = tissue_of(head, m_arena);
    EXPECT_EQ(made(as_ct.push(push)).status, PushStatus::Rejected);
    ReadNotes mr;
    mr.modality = "MR";
    ChainMailSettings settings;
    suit_materials(value_defaults(head, mr), settings);
    ChainMail as_mr = tissue_of(head, m_arena, settings);
    EXPECT_EQ(made(as_mr.push(push)).status, PushStatus::Applied);
}

TEST_F(RangeTest, GapsAndPlacesFromOutsideHaveTheBackgroundsValue) {
    for (const bool is_16_bit : {true, false}) {
        Volume head = block({24, 24, 24}, 100);
        if (!is_16_bit) head = converted<float>(head, 1, 0.5);
        head.background = 10;
        ChainMailSettings settings;
        settings.air_enabled = false;
        ChainMail tissue = tissue_of(head, m_arena, settings);
        made(tissue.push({.point_mm = {2, 12, 12}, .push_mm = {5, 0, 0}, .sphere_radius_mm = 4}));
        made(tissue.carve({.from_mm = {12, 12, 12}, .to_mm = {12, 12, 12}, .radius_mm = 3}));
        const Volume after = made(deform_volume(tissue, Mapping::Cells)).volume;
        EXPECT_LT(after.at({0, 12, 12}), 60);  // from beyond the border
        EXPECT_EQ(after.at({12, 12, 12}), 10);
        float lowest = 1000;
        for_each_element(after.grid, [&](Vec3i e) { lowest = std::min(lowest, after.at(e)); });
        EXPECT_EQ(lowest, 10);
    }
}

TEST_F(RangeTest, TheLawFollowsTheRangeAndTheFactor) {
    ChainMailSettings settings;
    settings.range = {0, 200};
    settings.bone_threshold_hu = 1000;
    settings.factor = {1, 0.5, 0.25};
    const MaterialLaw law = draeger_law(settings);
    EXPECT_EQ(law(0).shear, (Vec3d{0.2, 0.1, 0.05}));
    EXPECT_EQ(law(-5).compress, law(0).compress);
    EXPECT_DOUBLE_EQ(law(100).stretch.y, 0.1 * 0.75);
    EXPECT_DOUBLE_EQ(law(100).max_movement_mm, 20 * 0.75);
    EXPECT_EQ(law(200).stretch, (Vec3d{0, 0, 0}));
    EXPECT_FALSE(law(1000).fixed);
    EXPECT_TRUE(law(1001).fixed);
}

TEST_F(RangeTest, AnAxisWithALargerFactorYieldsMore) {
    const Volume volume = block({48, 48, 48});
    std::array<std::int64_t, 2> moved{};
    for (int n = 0; n < 2; ++n) {
        ChainMailSettings settings;
        settings.factor = n == 0 ? Vec3d{1, 1, 1} : Vec3d{1, 3, 1};
        ChainMail tissue = tissue_of(volume, m_arena, settings);
        moved[std::size_t(n)] =
            made(tissue.push_elements(std::vector{Vec3i{24, 24, 24}}, {0, 2, 0})).moved_elements;
    }
    EXPECT_LT(moved[1], moved[0]);
    // A factor that lets links lose more than their length is refused.
    ChainMailSettings settings;
    settings.factor = {6, 1, 1};
    const auto refused = ChainMail::create(volume, settings, m_arena);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find("compress.x"), std::string::npos)
        << refused.error().message;
}

TEST_F(RangeTest, BoneIsNamedWithItsThresholdDistanceAndPlace) {
    const Volume volume = volume_of({40, 20, 20}, [](Vec3i e) { return e.x >= 30 ? 900 : 40; });
    ChainMail tissue = tissue_of(volume, m_arena);
    const auto report = made(tissue.push_elements(std::vector{Vec3i{26, 10, 10}}, {30, 0, 0}));
    EXPECT_EQ(report.status, PushStatus::Limited);
    EXPECT_EQ(report.message,
              "stopped: bone (values above [material] bone_threshold_hu = 300) is in the way, 4 mm "
              "from the tool's tissue, at 30, 10, 10");
    const auto none = made(tissue.push_elements(std::vector{Vec3i{26, 10, 10}}, {30, 0, 0}));
    EXPECT_EQ(none.status, PushStatus::Rejected);
    EXPECT_EQ(none.message.find("nothing moved: bone (values above"), 0u) << none.message;
}

TEST_F(RangeTest, ThresholdsKeepTheirPlacesInAnotherRange) {
    ValueDefaults grey;
    grey.kind = ValueKind::XRay;
    grey.range = {100, 4195};
    grey.air_threshold = 600;
    grey.bone_threshold = 1400;
    ChainMailSettings settings;
    settings.range = {0, 1};
    suit_thresholds(grey, settings);
    EXPECT_NEAR(settings.air_threshold_hu, 500.0 / 4095, 1e-12);
    EXPECT_NEAR(settings.bone_threshold_hu, 1300.0 / 4095, 1e-12);
    suit_materials(ValueDefaults{}, settings);  // CT in HU
    EXPECT_EQ(settings.range, (ValueSpan{0, 1}));
}

}  // namespace
}  // namespace pliant::test
