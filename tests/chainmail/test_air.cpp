// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Air as a material, and the two artefacts of [Draeger2005, 5.2] that it removes.
// Covers: material/material.cpp, material/material_map.cpp, material/air.h, material/air_bits.h.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "material/air.h"

namespace pliant::test {
namespace {

constexpr int kTissueHu = 40;
/// Fraction of its length by which a link of this tissue yields.
double tissue_play() {
    const double w = 1040 / 4095.0;
    return 0.2 * (1 - w * w);
}

template <class IsTissue>
Volume volume_where(Vec3i size, const IsTissue& is_tissue) {
    return volume_of(size, [&](Vec3i e) { return is_tissue(e) ? kTissueHu : int(kAirHu); });
}

ChainMail tissue_with(const Volume& volume, bool air_enabled, const TaskArena& arena) {
    ChainMailSettings settings;
    settings.air_enabled = air_enabled;
    return tissue_of(volume, arena, settings);
}

std::vector<Vec3i> box_of(Vec3i begin, Vec3i end) {
    std::vector<Vec3i> elements;
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x) elements.push_back({x, y, z});
    return elements;
}

// Two walls that face each other across a gap of `gap` elements along x; the left one ends at 11.
class GapTest : public ::testing::TestWithParam<int> {
  protected:
    Volume two_walls() const {
        const int gap = GetParam();
        return volume_where({24 + gap, 16, 16},
                            [gap](Vec3i e) { return e.x < 12 || e.x >= 12 + gap; });
    }
    /// Motion of the far wall when a patch of the near one moves by push_mm.
    double far_motion(bool air_enabled, Vec3d push_mm, int axis) const {
        const Volume volume = two_walls();
        ChainMail tissue = tissue_with(volume, air_enabled, arena);
        const auto patch = box_of({11, 6, 6}, {12, 10, 10});
        const auto report = tissue.push_elements(patch, push_mm);
        EXPECT_EQ(report->status, PushStatus::Applied);
        EXPECT_LT(tissue.state().max_violation_mm, 1e-5);
        double largest = 0;
        for (const Vec3i& e : box_of({12 + GetParam(), 0, 0}, volume.grid.size))
            largest = std::max(largest, std::abs(tissue.displacement_mm(e)[axis]));
        return largest;
    }
    TaskArena arena{2};
};

TEST_P(GapTest, WithoutAirTheFarWallMovesLongBeforeContact) {
    // Figure 5.11: the gap is a piece of the object like any other.
    const int gap = GetParam();
    const double half_way = 0.5 * gap + 0.2;
    const double expected = half_way - (gap * 0.2 + tissue_play());
    EXPECT_GT(expected, 0);
    EXPECT_NEAR(far_motion(false, {half_way, 0, 0}, 0), expected, 1e-4);
}

TEST_P(GapTest, WithAirTheFarWallStandsStillUntilContactAndThenIsPushed) {
    const int gap = GetParam();
    // The gap closes to 2 %, and the rest is a link of tissue.
    const double contact = 0.98 * gap + tissue_play();
    EXPECT_EQ(far_motion(true, {0.5 * gap, 0, 0}, 0), 0);
    EXPECT_EQ(far_motion(true, {contact - 0.01, 0, 0}, 0), 0);
    EXPECT_NEAR(far_motion(true, {contact + 0.5, 0, 0}, 0), 0.5, 1e-4);
    EXPECT_NEAR(far_motion(true, {contact + 2, 0, 0}, 0), 2, 1e-4);
}

TEST_P(GapTest, WithAirWallsComeApartAndSlideFreely) {
    EXPECT_EQ(far_motion(true, {-3, 0, 0}, 0), 0);
    EXPECT_EQ(far_motion(true, {0, 3, 0}, 1), 0);
    EXPECT_GT(far_motion(false, {-3, 0, 0}, 0), 0.5);
    EXPECT_GT(far_motion(false, {0, 3, 0}, 1), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Gaps, GapTest, ::testing::Values(1, 2, 3, 5, 8));

// A polyp: a head on a stalk over a floor of tissue, with a gap of four elements below the head.
//
//        hhhhhhhhhhh     z = 17…19
//            s  :        z = 13…16
//     tttttttttttttttt   z ≤ 12
class BumpTest : public ::testing::Test {
  protected:
    Volume volume = volume_where({40, 24, 32}, [](Vec3i e) {
        const bool floor = e.z <= 12;
        const bool stalk = e.z <= 16 && e.x >= 12 && e.x < 15 && e.y >= 10 && e.y < 14;
        const bool head = e.z >= 17 && e.z <= 19 && e.x >= 10 && e.x < 28 && e.y >= 10 && e.y < 14;
        return floor || stalk || head;
    });
    /// Pushes the head's far end down, and measures the motion of the floor below it.
    double floor_motion(bool air_enabled, double push_mm) const {
        ChainMail tissue = tissue_with(volume, air_enabled, arena);
        const auto report =
            tissue.push_elements(box_of({24, 10, 17}, {28, 14, 20}), {0, 0, -push_mm});
        EXPECT_EQ(report->status, PushStatus::Applied);
        return -tissue.displacement_mm({26, 12, 12}).z;
    }
    TaskArena arena{2};
};

TEST_F(BumpTest, WithoutAirItSinksIntoTheTissueAsAWhole) {
    // Figure 5.12: the gap below hardly yields, so the floor moves down with the bump.
    EXPECT_NEAR(floor_motion(false, 3), 3 - (4 * 0.2 + tissue_play()), 1e-3);
}

TEST_F(BumpTest, WithAirItBendsUntilItTouchesTheFloor) {
    EXPECT_EQ(floor_motion(true, 3), 0);
    // From the pushed end to the floor below it along head and stalk there are 25 links or more.
    const double contact = 4 * 0.98 + tissue_play();
    EXPECT_NEAR(floor_motion(true, contact + 0.4), 0.4, 1e-3);
    ChainMail tissue = tissue_with(volume, true, arena);
    ASSERT_TRUE(tissue.push_elements(box_of({24, 10, 17}, {28, 14, 20}), {0, 0, -3}).ok());
    const double free_end = tissue.displacement_mm({26, 12, 18}).z;
    const double at_stalk = tissue.displacement_mm({14, 12, 18}).z;
    EXPECT_NEAR(free_end - at_stalk, -10 * tissue_play(), 1e-3);
}

/// Position at which a profile along x, from tissue to air, falls through −500 HU [mm].
double surface_of(const Volume& volume, int y, int z, int from) {
    for (int x = from; x + 1 < volume.grid.size.x; ++x) {
        const double here = volume.at({x, y, z}), next = volume.at({x + 1, y, z});
        if (here >= -500 && next < -500) return x + (here + 500) / (here - next);
    }
    return -1;
}

TEST(Air, AWallThatIsPushedAwayLeavesNoSmearInTheLumen) {
    const Volume volume = volume_where({40, 20, 20}, [](Vec3i e) { return e.x < 16; });
    const TaskArena arena(2);
    ChainMail tissue = tissue_with(volume, true, arena);
    const auto patch = box_of({14, 6, 6}, {16, 14, 14});
    ASSERT_TRUE(tissue.push_elements(patch, {-5, 0, 0}).ok());
    const Deformed deformed = deform_volume(tissue).value();
    const double before = surface_of(volume, 10, 10, 4),
                 after = surface_of(deformed.volume, 10, 10, 4);
    EXPECT_NEAR(after - before, -5, 0.2);
    // Directly behind the surface is air.
    for (int x = int(after) + 3; x < 40; ++x) EXPECT_LT(deformed.volume.at({x, 10, 10}), -950) << x;
}

TEST(Air, AThinWallKeepsItsThickness) {
    const Volume volume = volume_where({48, 20, 20}, [](Vec3i e) { return e.x >= 20 && e.x < 24; });
    const TaskArena arena(2);
    ChainMail tissue = tissue_with(volume, true, arena);
    ASSERT_TRUE(tissue.push_elements(box_of({20, 8, 8}, {24, 12, 12}), {6, 0, 0}).ok());
    const Deformed deformed = deform_volume(tissue).value();
    double thickness = 0;
    for (int x = 0; x < 48; ++x)
        thickness += (deformed.volume.at({x, 10, 10}) - kAirHu) / double(kTissueHu - kAirHu);
    EXPECT_NEAR(thickness, 4, 0.3);
}

TEST(Air, SkinIsAtMostThreeElementsAndLeavesTheMiddleOfAGap) {
    for (int gap = 1; gap <= 12; ++gap) {
        std::vector<int> skin;
        for (int place = 1; place <= gap; ++place) {
            const unsigned axes = skin_axes([&](int axis, int steps) {
                if (axis != 1) return true;
                return place + steps >= 1 && place + steps <= gap;
            });
            EXPECT_EQ(axes & ~2u, 0u);
            if (axes) skin.push_back(place);
        }
        std::vector<int> expected;
        const int depth = std::min(3, (gap - 1) / 2);
        for (int place = 1; place <= gap; ++place)
            if (place <= depth || place > gap - depth) expected.push_back(place);
        EXPECT_EQ(skin, expected) << gap;
    }
}

/// Materials of bricks, in and around the scan, against an evaluation element by element.
void check_bricks(const Volume& volume, const ChainMailSettings& settings, int brick_size) {
    Lattice lattice(volume, MaterialMap(volume, settings), brick_size, false);
    for (int z = -4; z < 24; ++z)
        for (int y = -4; y < 24; ++y)
            for (int x = -4; x < 26; ++x) {
                const ElementRef element = lattice.ensure_element({x, y, z});
                const MaterialId held =
                    lattice.brick(element.brick).material[std::size_t(element.index)];
                ASSERT_EQ(held, lattice.material_at({x, y, z}));
            }
}

TEST(Air, BricksHoldTheSameMaterialsAsSingleElements) {
    for (unsigned seed = 11; seed < 35 && !::testing::Test::HasFatalFailure(); ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        // From a few elements of tissue in air to a few of air in tissue.
        const int one_in = random.whole(2, 40);
        const bool mostly_air = random.whole(0, 1);
        Volume volume = volume_where(
            {21, 18, 19}, [&](Vec3i) { return (random.whole(1, one_in) == 1) == mostly_air; });
        ChainMailSettings settings;
        if (random.whole(0, 1)) settings.air_threshold_hu = random.real(-1100, -400);
        if (random.whole(0, 1)) {
            std::vector<float> values(voxel_count(volume.grid));
            const float threshold = float(std::floor(settings.air_threshold_hu));
            for (float& value : values)
                value = random.whole(0, 50) ? threshold + 0.25f * float(random.whole(-9, 9))
                                            : std::numeric_limits<float>::quiet_NaN();
            volume.voxels = values;
        }
        check_bricks(volume, settings, seed % 4 ? 8 : random.whole(3, 13));
    }
}

TEST(Air, ACustomLawSpeaksForAirToo) {
    const Volume volume = volume_where({12, 12, 12}, [](Vec3i) { return false; });
    const TaskArena arena(1);
    ChainMailSettings settings;
    settings.custom_law = [](int) {
        return ElementLimits{{.1, .1, .1}, {.1, .1, .1}, {.1, .1, .1}, 100, false};
    };
    ChainMail tissue = std::move(ChainMail::create(volume, settings, arena)).value();
    const std::vector<Vec3i> one = {{6, 6, 6}};
    ASSERT_TRUE(tissue.push_elements(one, {1, 0, 0}).ok());
    EXPECT_NEAR(tissue.displacement_mm({6, 6, 9}).x, 0.7, 1e-4);
}

}  // namespace
}  // namespace pliant::test
