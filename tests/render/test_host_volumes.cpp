// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of volumes that a program hands over: one that check_volume refuses shows air, and
// values that are no numbers are no walls.
// Covers: render/ray_caster.cpp, render/section.cpp.

#include <gtest/gtest.h>
#include <pliant/render.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/broken_volumes.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

constexpr int kWide = 24, kHigh = 18;

/// Looks at a volume in every way there is; nothing may crash. @returns whether a ray hit a wall
bool look_at(const Volume& volume, Random& random) {
    const TaskArena& arena = one_thread();
    const Vec3d eye = random.vector(30), look = random.vector(1);
    const Endoscope endoscope{.eye_mm = eye, .look = look};
    RayCaster caster(volume, arena);
    const Box3i box{{0, 0, 0}, volume.grid.size};
    if (check_volume(volume).ok()) caster.update({&box, 1});
    bool hit = caster.first_hit(eye, look, -500, Polarity::Rising).has_value();
    const std::vector<Vec3d> directions{look, -look, {1, 0, 0}, {0, 0, 0}};
    std::vector<double> distances(directions.size());
    caster.first_hits(eye, directions, -500, Polarity::Falling, distances);
    for (const double d : distances) hit = hit || std::isfinite(d);
    hit = hit || caster.nearest_surface(eye, 50, -500, Polarity::Rising).has_value();
    hit = hit || caster.pick(endoscope, kWide, kHigh, 3, 4).has_value();
    EXPECT_EQ(caster.endoscope_view(endoscope, kWide, kHigh).pixels.size(),
              std::size_t(kWide * kHigh));
    EXPECT_EQ(caster.blended_view(endoscope, {}, kWide, kHigh).pixels.size(),
              std::size_t(kWide * kHigh));
    hit = hit || find_endoscope(volume, -500, Polarity::Rising, arena).has_value();
    hit = hit || find_look(volume, eye, -500, Polarity::Rising, arena).has_value();
    EXPECT_TRUE(is_finite(
        aim_endoscope(volume, {1, 2, 3}, {1, 0, 0}, -500, Polarity::Rising, arena).eye_mm));
    (void)four_up_view(volume, {.endoscope = endoscope, .section = {}, .caption = ""}, 2 * kWide,
                       2 * kHigh, arena);
    (void)fluoroscopy_view(volume, {}, kWide, kHigh, arena);
    return hit;
}

TEST(HostVolumes, OneWithABrokenFieldLooksLikeAir) {
    const Volume air{
        {.size = {2, 2, 2}}, VoxelArray<std::int16_t>(std::vector<std::int16_t>(8, kAirHu)), {}};
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        EXPECT_FALSE(look_at(broken.volume, random));
        RayCaster caster(broken.volume, one_thread());
        const Box3i box{{0, 0, 0}, {4, 4, 4}};
        caster.update({&box, 1});
        for (const float w : water_lengths_mm(broken.volume, {}, kWide, kHigh, one_thread()))
            ASSERT_EQ(w, 0);
        const Section section{.width_mm = random.ratio(0.1, 100)};
        EXPECT_EQ(section_view(broken.volume, section, kWide, kHigh, one_thread()).pixels,
                  section_view(air, section, kWide, kHigh, one_thread()).pixels);
        expect_refused(find_lumen_path(broken.volume, {0, 0, 0}, {1, 1, 1}, {}, one_thread()),
                       "volume." + broken.field);
    }
}

TEST(HostVolumes, ThinOnesAndStrangeValuesCanBeLookedAt) {
    int hits = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Volume volume =
            random.whole(0, 1) ? good_volume(random, 1) : volume_with_strange_values(random);
        volume.grid.origin_mm = random.vector(5);
        hits += look_at(volume, random);
    }
    EXPECT_GT(hits, 20);
}

TEST(HostVolumes, AVoxelThatIsNoNumberIsBlackInSectionsAndNothingInFluoroscopy) {
    Volume volume{{.size = {3, 3, 3}}, VoxelArray<float>(std::size_t(27)), {}};
    volume.voxels = std::vector<float>(27, float(kNotANumber));
    const Section section{.point_mm = {1, 1, 1}, .width_mm = 2, .crosshair = false};
    Volume air = volume;
    air.voxels = std::vector<float>(27, float(kAirHu));
    EXPECT_EQ(section_view(volume, section, 64, 64, one_thread()).pixels,
              section_view(air, section, 64, 64, one_thread()).pixels);
    for (const float w :
         water_lengths_mm(volume, {.centre_mm = {1, 1, 1}, .width_mm = 2}, 8, 8, one_thread()))
        EXPECT_EQ(w, 0);
}

TEST(HostVolumes, APathAmongVoxelsThatAreNoNumbersIsFoundOrRefused) {
    constexpr int kSize = 24;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    int refused = 0;
    for (const float strange : {-kInfinity, kInfinity, std::nanf(""), -3e38F})
        for (int first = 0; first < 7; ++first) {
            SCOPED_TRACE(testing::Message() << strange << ", from voxel " << first);
            // A tube along k, with every seventh voxel replaced.
            Volume tube;
            tube.grid.size = {kSize, kSize, kSize};
            std::vector<float> voxels;
            for (int n = 0; n < kSize * kSize * kSize; ++n) {
                const double beside = std::hypot(n % kSize - 12, n / kSize % kSize - 12);
                voxels.push_back(n % 7 == first ? strange : beside < 6 ? -1000.0F : 40.0F);
            }
            tube.voxels = voxels;
            const auto path = find_lumen_path(tube, {12, 12, 3}, {12, 12, 20}, {}, one_thread());
            refused += !path.ok();
            if (path.ok()) {
                EXPECT_TRUE(std::isfinite(path->length_mm));
            }
        }
    EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace pliant::test
