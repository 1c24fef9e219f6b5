// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The numbers that docs/results/chainmail/README.md claims.
// Covers: results_chainmail/setups.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "setups.h"

namespace pliant::results {
namespace {

TEST(ChainMailResults, TheTableOfTheThesisMovesAsManyElements) {
    const TaskArena arena(2);
    for (const TimingCase& timing : timing_cases()) {
        Scenario s = timing_scenario(timing, 8, arena);
        const std::int64_t moved = s.push(timing_push(s)).moved_elements;
        const std::int64_t visibly = visibly_moved(*s.tissue);
        // Where the push is a whole multiple of the offset, rounding decides about the outermost.
        EXPECT_LE(visibly, timing.elements_2005) << timing.offset;
        EXPECT_GE(moved, timing.elements_2005) << timing.offset;
        EXPECT_TRUE(moved == timing.elements_2005 || visibly == timing.elements_2005)
            << timing.offset << ": " << moved << ", " << visibly;
    }
}

TEST(ChainMailResults, ThickSlicesStretchTheDeformationOnlyWithoutTheAdjustment) {
    const TaskArena arena(2);
    const auto z_over_x = [&](bool adjusted) {
        Scenario s = cube_scenario({0.25, 1.2, 2.2, adjusted}, arena);
        s.push({kFace_mm, kThesisPush_mm});
        const auto r = roundness_of(s, kFace_mm, 1.2).across_push.radii_mm;
        return (r[90] + r[270]) / (r[0] + r[180]);
    };
    EXPECT_NEAR(z_over_x(false), 2.2, 0.05);
    EXPECT_NEAR(z_over_x(true), 1.16, 0.03);
}

TEST(ChainMailResults, BoxLimitsGiveContoursThatAreAsFarFromACircleAsThePageSays) {
    const TaskArena arena(2);
    for (const double z_scale : {1.0, 2.2}) {
        Scenario s = solid_scenario({0.25, 2.5, z_scale}, arena);
        s.push({{0, 0, 0}, kThesisPush_mm});
        const Roundness r = roundness_of(s, {0, 0, 0}, 2.5);
        EXPECT_NEAR(r.across_push.deviation, 0.29, 0.015);
        EXPECT_NEAR(r.along_push.deviation, 0.29, 0.015);
        EXPECT_NEAR(r.along_push_in_z.deviation, 0.29, 0.015);
    }
}

TEST(ChainMailResults, WithAirAsATissueTheFarWallMovesLongBeforeContact) {
    const TaskArena arena(2);
    for (const double sign : {1.0, -1.0}) {
        Scenario s = passage_scenario(false, arena);
        s.push(near_wall_patch(), {sign * kGap_mm, 0, 0});
        EXPECT_NEAR(sign * s.tissue->displacement_mm(kFarWall).x, 4.61, 0.02);
    }
}

TEST(ChainMailResults, WithAirOfItsOwnTheFarWallWaitsForContactAndIsThenPushed) {
    const TaskArena arena(2);
    Scenario s = passage_scenario(true, arena);
    s.push(near_wall_patch(), {kGap_mm, 0, 0});
    EXPECT_EQ(s.tissue->displacement_mm(kFarWall), (Vec3d{0, 0, 0}));
    s.push(near_wall_patch(), {4, 0, 0});
    EXPECT_NEAR(s.tissue->displacement_mm(kFarWall).x, 3.93, 0.02);
    Scenario away = passage_scenario(true, arena);
    away.push(near_wall_patch(), {-10, 0, 0});
    EXPECT_EQ(away.tissue->displacement_mm(kFarWall), (Vec3d{0, 0, 0}));
}

TEST(ChainMailResults, AnOverhangingBumpTakesTheWallAlongOnlyThroughAirThatIsTissue) {
    const TaskArena arena(2);
    for (const bool air : {false, true}) {
        Scenario s = bump_scenario(Bump::Overhang, air, arena);
        s.push(bump_push(Bump::Overhang));
        const double below =
            norm(s.tissue->displacement_mm({kHeadEnd.x, kWallFront + 1, kHeadEnd.z}));
        EXPECT_NEAR(below, air ? 0.0 : 4.43, air ? 0 : 0.02);
    }
}

TEST(ChainMailResults, AColumnTakesTheWallAlongWhateverAirIs) {
    const TaskArena arena(2);
    for (const bool air : {false, true}) {
        Scenario s = bump_scenario(Bump::Column, air, arena);
        s.push(bump_push(Bump::Column));
        EXPECT_NEAR(s.tissue->displacement_mm({kBumpTip.x, kWallFront + 1, kBumpTip.z}).y, 6.51,
                    0.02);
    }
}

TEST(ChainMailResults, AFingerSinksUnderAToolThatSticksAndIsBentAsideByOneThatItSlidesOff) {
    const TaskArena arena(2);
    for (const bool air : {false, true}) {
        const Vec3i wall{kBumpTip.x, kWallFront + 1, kBumpTip.z};
        Scenario sticks = bump_scenario(Bump::Finger, air, arena);
        push_finger(sticks);
        EXPECT_NEAR(sticks.tissue->displacement_mm(kBumpTip).y, 8, 0.02);
        EXPECT_NEAR(sticks.tissue->displacement_mm(wall).y, 5.94, 0.02);
        Scenario slides = bump_scenario(Bump::Finger, air, arena);
        EXPECT_EQ(slide_off_finger(slides).way_fraction, 1);
        EXPECT_NEAR(slides.tissue->displacement_mm(kBumpTip).x, air ? -2.41 : -2.62, 0.02);
        EXPECT_NEAR(slides.tissue->displacement_mm(kBumpTip).y, 2.02, 0.02);
        EXPECT_NEAR(slides.tissue->displacement_mm(wall).y, air ? 0.24 : 0.25, 0.01);
    }
}

/// Depth and volume of a dent without rays, by another mapping: voxel columns along y in the scan
/// resampled by tetrahedra, each with the first crossing between two voxels.
struct ColumnDent {
    double depth_mm = 0, volume_mm3 = 0;
};
ColumnDent column_dent(const Scenario& s, Vec3d position_mm, double threshold_hu) {
    const Volume deformed = deform_volume(*s.tissue, Mapping::Tetrahedra).value().volume;
    const Vec3d ijk = voxel_from_world(s.scan->grid, position_mm);
    const auto crossing = [&](const Volume& volume, int x, int z) {
        int y = int(ijk.y) - 6;
        while (volume.at({x, y + 1, z}) < threshold_hu) ++y;
        const double low = volume.at({x, y, z}), high = volume.at({x, y + 1, z});
        return y + (threshold_hu - low) / (high - low);
    };
    ColumnDent dent;
    for (int z = int(ijk.z) - 12; z <= int(ijk.z) + 13; ++z)
        for (int x = int(ijk.x) - 12; x <= int(ijk.x) + 13; ++x) {
            const double depth = crossing(deformed, x, z) - crossing(*s.scan, x, z);
            dent.depth_mm = std::max(dent.depth_mm, depth);
            dent.volume_mm3 += depth;
        }
    return dent;
}

TEST(ChainMailResults, OnTheSurfaceTheSofterHalfHasTheBiggerDent) {
    const TaskArena arena(2);
    for (const double threshold : {-500.0, -100.0}) {
        SCOPED_TRACE(threshold);
        Dent dents[2];
        ColumnDent columns[2];
        std::int64_t moved[2];
        for (int n = 0; n < 2; ++n) {
            Scenario s = layers_scenario(StiffHalf::Even, arena);
            const Vec3d place = n == 0 ? kSoft_mm : kStiff_mm;
            moved[n] = s.push({place, kThesisPush_mm}).moved_elements;
            dents[n] = dent_of(s, place, threshold, arena);
            columns[n] = column_dent(s, place, threshold);
            EXPECT_NEAR(dents[n].depth_mm, columns[n].depth_mm, 0.05);
            EXPECT_NEAR(dents[n].volume_mm3, columns[n].volume_mm3, 0.1 * dents[n].volume_mm3);
        }
        EXPECT_GT(dents[0].depth_mm, 1.03 * dents[1].depth_mm);
        EXPECT_GT(columns[0].depth_mm, 1.03 * columns[1].depth_mm);
        EXPECT_GT(dents[0].volume_mm3, 1.02 * dents[1].volume_mm3);
        EXPECT_GE(columns[0].volume_mm3, 0.999 * columns[1].volume_mm3);  // at -500 HU: equal
        EXPECT_GT(dents[0].half_above_mm, dents[1].half_above_mm);
        EXPECT_LT(dents[0].area_mm2, dents[1].area_mm2);  // the foot, though, is wider
        EXPECT_LT(moved[0], moved[1]);
        if (threshold == -100)
            EXPECT_GT(dents[0].slope, 2 * dents[1].slope);
        else
            EXPECT_LT(dents[0].slope, dents[1].slope);
    }
}

TEST(ChainMailResults, WithoutResamplingTheStiffHalfHasTheWiderDent) {
    const TaskArena arena(2);
    for (const double threshold : {-500.0, -100.0}) {
        SCOPED_TRACE(threshold);
        Dent dents[2];
        for (int n = 0; n < 2; ++n) {
            Scenario s = layers_scenario(StiffHalf::Even, arena);
            const Vec3d place = n == 0 ? kSoft_mm : kStiff_mm;
            s.push({place, kThesisPush_mm});
            dents[n] = moved_dent_of(s, place, threshold, arena);
        }
        EXPECT_LT(dents[0].half_above_mm, dents[1].half_above_mm - 0.4);
        EXPECT_LT(dents[0].volume_mm3, 0.9 * dents[1].volume_mm3);
        EXPECT_GT(dents[0].depth_mm, dents[1].depth_mm);
    }
}

TEST(ChainMailResults, AtTheBorderTheDentReachesFartherIntoTheSoftHalf) {
    const TaskArena arena(2);
    Scenario s = layers_scenario(StiffHalf::Graded, arena);
    s.push({kBorder_mm, kThesisPush_mm});
    for (const double threshold : {-500.0, -100.0}) {
        const Dent dent = dent_of(s, kBorder_mm, threshold, arena);
        EXPECT_GE(dent.half_above_mm, dent.half_below_mm + 0.5) << threshold;
    }
}

TEST(ChainMailResults, AChainFollowsByAsMuchAsItsLinksGiveWay) {
    const TaskArena arena(2);
    Scenario s = chain_scenario(arena);
    for (int step = 1; step <= 4; ++step) {
        s.push({{kChainHeld, 0, 0}}, {0.6, 0, 0});
        for (int n = 0; n < kChainElements; ++n)
            EXPECT_NEAR(s.tissue->displacement_mm({n, 0, 0}).x,
                        std::max(0.0, 0.6 * step - kChainRange * std::abs(n - kChainHeld)), 1e-5)
                << step << ", " << n;
    }
}

TEST(ChainMailResults, AnElasticSheetGoesBackAndAPlasticOneKeepsItsImprint) {
    const TaskArena arena(2);
    for (const double yield : {0.0, 0.4}) {
        const Recovery r = recovery_of(yield, arena);
        EXPECT_NEAR(r.pulled_mm, std::hypot(6, 9), 1e-5);
        EXPECT_NEAR(r.left_mm, yield == 0 ? 0 : (1 - yield) * r.pulled_mm, 1e-3);
    }
}

TEST(ChainMailResults, RoundedLimitsGiveRounderContoursInEachPlane) {
    const TaskArena arena(2);
    for (const double z_scale : {1.0, 2.2}) {
        Scenario s = solid_scenario(
            {.offset = 0.25, .scale = 2.5, .z_scale = z_scale, .limits = LinkLimits::Rounded},
            arena);
        s.push({{0, 0, 0}, kThesisPush_mm});
        const Roundness r = roundness_of(s, {0, 0, 0}, 2.5);
        EXPECT_NEAR(r.across_push.deviation, z_scale > 1 ? 0.114 : 0.060, 0.01);
        EXPECT_NEAR(r.along_push.deviation, 0.060, 0.01);
        EXPECT_NEAR(r.along_push_in_z.deviation, z_scale > 1 ? 0.114 : 0.060, 0.01);
    }
}

TEST(ChainMailResults, AFixedElementStopsAPullAtTheTautChain) {
    const TaskArena arena(2);
    Scenario s =
        gibson_object({{41, 41, 1}, [](Vec3i) { return true; }, [](Vec3i e) { return e.x == 0; }},
                      0.25, 0.25, arena);
    const PushReport& report = s.push({{20, 20, 0}}, {10, 0, 0});
    EXPECT_EQ(report.limited_by, LimitedBy::Bone);
    EXPECT_NEAR(report.step_fraction, 20 * 0.25 / 10, 1e-5);
}

TEST(ChainMailResults, MotionGoesThroughAnObjectAndNotAcrossItsOpening) {
    const TaskArena arena(2);
    // Two bars with nothing between them, joined at one end only.
    const auto inside = [](Vec3i e) { return e.y < 10 || e.y > 14 || e.x < 5; };
    Scenario s = gibson_object({{60, 25, 1}, inside, nullptr}, 0.1, 0.1, arena);
    s.push({{55, 12 + 5, 0}}, {0, -2, 0});
    EXPECT_EQ(s.tissue->displacement_mm({55, 9, 0}), (Vec3d{0, 0, 0}));
    EXPECT_LT(s.tissue->displacement_mm({55, 24, 0}).y, -0.5);
}

}  // namespace
}  // namespace pliant::results
