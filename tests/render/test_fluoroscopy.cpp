// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shadows of a box and a ball, whose lengths along a ray are known.

#include <gtest/gtest.h>
#include <pliant/fluoroscopy.h>

#include <cmath>

#include "render/scenes.h"
#include "support/random.h"

namespace pliant {
namespace {

using test::make_volume;
using test::Random;

Grid grid_of(Vec3i size, Vec3d spacing, const Mat3d& direction = kIdentity3) {
    Grid grid;
    grid.size = size;
    grid.spacing_mm = spacing;
    grid.direction = direction;
    const Vec3d middle =
        world_from_voxel(grid, {0.5 * (size.x - 1), 0.5 * (size.y - 1), 0.5 * (size.z - 1)});
    grid.origin_mm = -middle;
    return grid;
}

/// The ray through a pixel's middle, from what the header says of source, centre and width.
struct Ray {
    Vec3d eye, direction;
};
Ray ray_of(const Fluoroscopy& s, int width, int height, int x, int y) {
    const Vec3d ahead = normalized(s.look), right = normalized(cross(ahead, s.up)),
                up = cross(right, ahead);
    const double mm = s.width_mm / width;
    const Vec3d at =
        s.centre_mm + (x + 0.5 - 0.5 * width) * mm * right - (y + 0.5 - 0.5 * height) * mm * up;
    const Vec3d eye = s.centre_mm - s.source_mm * ahead;
    return {eye, normalized(at - eye)};
}

/// How long a ray is in a box around the origin.
double length_in_box(const Ray& ray, Vec3d half) {
    double low = -1e300, high = 1e300;
    for (int a = 0; a < 3; ++a) {
        const double t0 = (-half[a] - ray.eye[a]) / ray.direction[a],
                     t1 = (half[a] - ray.eye[a]) / ray.direction[a];
        low = std::max(low, std::min(t0, t1));
        high = std::min(high, std::max(t0, t1));
    }
    return std::max(0.0, high - low);
}

TEST(Fluoroscopy, OfAnEvenBlockIsItsLengthAlongTheRay) {
    const std::uint64_t seed = 17;
    SCOPED_TRACE(seed);
    Random random(seed);
    const TaskArena arena(2);
    const Volume block =
        make_volume<std::int16_t>(grid_of({30, 20, 25}, {1, 2, 1.5}), [](Vec3d) { return 500; });
    const Vec3d half{14.5, 19, 18};  // to the outermost voxel centres
    for (int n = 0; n < 10; ++n) {
        const Fluoroscopy s{.centre_mm = random.vector(5),
                            .look = random.vector(1),
                            .up = random.vector(1),
                            .source_mm = random.real(80, 1000),
                            .width_mm = 60};
        constexpr int kWide = 32, kHigh = 24;
        const auto lengths = water_lengths_mm(block, s, kWide, kHigh, arena);
        int hits = 0;
        for (int y = 0; y < kHigh; ++y)
            for (int x = 0; x < kWide; ++x) {
                const double exact = 1.5 * length_in_box(ray_of(s, kWide, kHigh, x, y), half);
                EXPECT_NEAR(lengths[std::size_t(y * kWide + x)], exact, 1e-4 + 1e-6 * exact);
                hits += exact > 0;
            }
        EXPECT_GT(hits, 50);
        EXPECT_EQ(lengths, water_lengths_mm(block, s, kWide, kHigh, TaskArena(1)));
    }
}

TEST(Fluoroscopy, OfABallInAirIsItsChord) {
    const TaskArena arena(2);
    constexpr double kRadius = 20;
    const auto ball = [](Vec3d p) {  // its edge over a voxel, as a scanner would have it
        const double share = std::clamp(0.5 - (norm(p) - kRadius), 0.0, 1.0);
        return float(-1000 + 1600 * share);
    };
    const Volume volume = make_volume<float>(grid_of({60, 60, 60}, {1, 1, 1}), ball);
    const Fluoroscopy s{.look = {0.3, 1, -0.2}, .up = {0, 0, 1}, .source_mm = 700, .width_mm = 56};
    constexpr int kSide = 56;
    const auto lengths = water_lengths_mm(volume, s, kSide, kSide, arena);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const Ray ray = ray_of(s, kSide, kSide, x, y);
            const double off = norm(cross(ray.eye, ray.direction));
            const double chord = off < kRadius ? 2 * std::sqrt(kRadius * kRadius - off * off) : 0;
            const double found = lengths[std::size_t(y * kSide + x)];
            // Near its rim a ray meets little else than the voxels' soft edge.
            if (off < kRadius - 4 || off > kRadius + 1.5) {
                EXPECT_NEAR(found, 1.6 * chord, 0.02 * 1.6 * chord + 0.01) << x << ' ' << y;
            }
        }
}

/// Grey of a line integral beyond the exposure.
int grey_of(double excess) {
    return int(255 / (1 + 0.55 / 0.45 * std::exp(excess)) + 0.5);
}

TEST(Fluoroscopy, IsASigmoidOfTheLineIntegral) {
    const TaskArena arena(1);
    // Water, 40 mm thick; below air nothing is made brighter.
    const Volume water =
        make_volume<std::int16_t>(grid_of({41, 41, 41}, {1, 1, 1}), [](Vec3d) { return 0; });
    Fluoroscopy s{.look = {0, 1, 0}, .source_mm = 1e6, .width_mm = 20};
    s.exposure_water_mm = 30;
    const auto grey = [&](const Volume& volume) {
        const Image image = fluoroscopy_view(volume, s, 16, 16, arena);
        return int(image.pixels[8 * 16 + 8].r);
    };
    EXPECT_NEAR(grey(water), grey_of(0.02 * 10), 1);
    s.contrast = 2;
    EXPECT_NEAR(grey(water), grey_of(0.04 * 10), 1);
    const Volume nothing =
        make_volume<std::int16_t>(grid_of({41, 41, 41}, {1, 1, 1}), [](Vec3d) { return -1500; });
    EXPECT_NEAR(grey(nothing), grey_of(-0.04 * 30), 1);
    // Metered: the median is 45 % grey.
    s.exposure_water_mm.reset();
    EXPECT_NEAR(grey(water), 115, 1);
}

TEST(Fluoroscopy, MetersTheCentralThirdAlone) {
    const TaskArena arena(1);
    // Water, and bone beside the central third: three quarters of the picture.
    const Volume block = make_volume<std::int16_t>(grid_of({61, 41, 61}, {1, 1, 1}), [](Vec3d p) {
        return std::max(std::abs(p.x), std::abs(p.z)) < 13 ? 0 : 1000;
    });
    const Fluoroscopy s{.look = {0, 1, 0}, .source_mm = 1e6, .width_mm = 60};
    const Image image = fluoroscopy_view(block, s, 60, 60, arena);
    EXPECT_NEAR(image.pixels[30 * 60 + 30].r, 115, 1);
    EXPECT_NEAR(image.pixels[30 * 60 + 5].r, grey_of(0.02 * 40), 1);
}

TEST(Fluoroscopy, HasNothingToShowBesideTheScan) {
    const TaskArena arena(1);
    const Volume water =
        make_volume<std::int16_t>(grid_of({11, 11, 11}, {1, 1, 1}), [](Vec3d) { return 0; });
    const Fluoroscopy s{.centre_mm = {500, 0, 0}, .width_mm = 50};
    for (const float length : water_lengths_mm(water, s, 16, 16, arena)) EXPECT_EQ(length, 0);
    EXPECT_EQ(fluoroscopy_view(water, s, 16, 16, arena).pixels[0], (Rgb8{115, 115, 115}));
}

}  // namespace
}  // namespace pliant
