// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shadows of a box and a ball with known lengths along a ray; the fade beyond a scan; noise and
// collimator.

#include <gtest/gtest.h>
#include <pliant/render.h>

#include <algorithm>
#include <cmath>

#include "render/analytic_volumes.h"
#include "render/detector.h"
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

/// The ray through a pixel's middle, from the header's definition of source, centre and width.
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
                            .width_mm = 60,
                            .border_mm = 0};
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

TEST(Fluoroscopy, FadesOutBeyondTheScan) {
    const TaskArena arena(2);
    // Rays that are parallel, a pixel for each 2 mm: 30 mm of 1.5 times water in the middle.
    const Volume block =
        make_volume<std::int16_t>(grid_of({21, 31, 21}, {2, 1, 2}), [](Vec3d) { return 500; });
    Fluoroscopy s{.look = {0, 1, 0}, .source_mm = 1e7, .width_mm = 160};
    const double third = std::cbrt(40.0 * 30 * 40) / 3;
    for (const double border : {third, 25.0, 0.0}) {
        if (border != third) s.border_mm = border;  // a third is the default
        const auto lengths = water_lengths_mm(block, s, 80, 80, arena);
        for (int y = 0; y < 80; ++y)
            for (int x = 0; x < 80; ++x) {
                const auto beyond = [](int n) {
                    return std::max(0.0, std::abs(2 * n - 79.0) - 20);
                };
                const double e = std::hypot(beyond(x), beyond(y));
                const double left =
                    e == 0 ? 1 : std::pow(std::max(0.0, 1 - e * e / border / border), 2);
                const double expected = e > 0 && border == 0 ? 0 : 45 * left;
                EXPECT_NEAR(lengths[std::size_t(80 * y + x)], expected, 0.02)
                    << border << ": " << x << ' ' << y;
            }
    }
}

TEST(Fluoroscopy, HasNoEdgeWhereRaysLeaveThroughASide) {
    const std::uint64_t seed = 23;
    SCOPED_TRACE(seed);
    Random random(seed);
    const TaskArena arena(2);
    const Volume block =
        make_volume<std::int16_t>(grid_of({40, 50, 45}, {1, 1, 1}), [](Vec3d) { return 40; });
    const auto steepest = [&](const Fluoroscopy& s) {
        constexpr int kSide = 100;
        const auto lengths = water_lengths_mm(block, s, kSide, kSide, arena);
        double most = 0;
        for (std::size_t n = 0; n + kSide < lengths.size(); ++n)
            most = std::max(most, std::abs(double(lengths[n + kSide]) - double(lengths[n])));
        return most;
    };
    for (int n = 0; n < 6; ++n) {
        Fluoroscopy s{.look = n == 0 ? Vec3d{0, 1, 0} : random.vector(1),
                      .source_mm = random.real(200, 2000),
                      .width_mm = 150};
        EXPECT_LT(steepest(s), 9) << n;  // of some 50 to 80 mm, per 1.5 mm
        s.border_mm = 0;
        if (n == 0) {
            EXPECT_GT(steepest(s), 40);
        }
    }
}

TEST(Fluoroscopy, LeavesAirAroundABodyAsItIs) {
    const TaskArena arena(2);
    const Volume body = make_volume<std::int16_t>(
        grid_of({40, 40, 40}, {1, 1, 1}), [](Vec3d p) { return norm(p) < 15 ? 100 : -1000; });
    Fluoroscopy s{.look = {0.4, 1, 0.2}, .width_mm = 60};
    const auto with = water_lengths_mm(body, s, 50, 50, arena);
    s.border_mm = 0;
    EXPECT_EQ(with, water_lengths_mm(body, s, 50, 50, arena));
}

TEST(Fluoroscopy, NoiseIsThatOfThePage) {
    // The shader has the same hash; test_fluoroscopy_picture.ts compares pictures.
    EXPECT_EQ(std::uint32_t(16777216 * render::corner_noise(0, 0, 0)), 1178882U);
    EXPECT_EQ(std::uint32_t(16777216 * render::corner_noise(1, 2, 3)), 11785499U);
    EXPECT_EQ(std::uint32_t(16777216 * render::corner_noise(1919, 1079, 123456789)), 4850027U);
}

TEST(Fluoroscopy, NoiseOfAPixelHasVarianceOneAndSharesHalfWithItsNeighbour) {
    constexpr int kSide = 400;
    for (const std::uint32_t seed : {0U, 1U, 77U}) {
        double sum = 0, square = 0, beside = 0, diagonal = 0, far = 0, next = 0;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const double n = render::pixel_noise(x, y, seed);
                sum += n;
                square += n * n;
                beside += n * render::pixel_noise(x + 1, y, seed);
                diagonal += n * render::pixel_noise(x + 1, y + 1, seed);
                far += n * render::pixel_noise(x, y + 2, seed);
                next += n * render::pixel_noise(x, y, seed + 1);
            }
        constexpr double kCount = double(kSide) * kSide, kBound = 0.02;
        EXPECT_NEAR(sum / kCount, 0, kBound);
        EXPECT_NEAR(square / kCount, 1, kBound);
        EXPECT_NEAR(beside / kCount, 0.5, kBound);
        EXPECT_NEAR(diagonal / kCount, 0.25, kBound);
        EXPECT_NEAR(far / kCount, 0, kBound);
        EXPECT_NEAR(next / kCount, 0, kBound);
    }
}

TEST(Fluoroscopy, NoiseGrowsWhereFewPhotonsArrive) {
    const Volume water =
        make_volume<std::int16_t>(grid_of({61, 41, 61}, {1, 1, 1}), [](Vec3d) { return 0; });
    Fluoroscopy s{.look = {0, 1, 0}, .source_mm = 1e6, .width_mm = 20, .contrast = 0.5, .noise = 1};
    // Standard deviation of the line integral, by the curve's slope.
    for (const double excess : {0.0, -1.0, 1.5}) {
        s.exposure_water_mm = 40 - excess / s.water_per_mm;
        const Image image = fluoroscopy_view(water, s, 128, 128, TaskArena(2));
        EXPECT_EQ(image.pixels, fluoroscopy_view(water, s, 128, 128, TaskArena(1)).pixels);
        double sum = 0, square = 0;
        for (const Rgb8 p : image.pixels) {
            sum += p.r;
            square += double(p.r) * p.r;
        }
        const double count = double(image.pixels.size()), mean = sum / count;
        const double light = render::curve(s.contrast * excess);
        const double expected =
            255 * light * (1 - light) * s.contrast * 0.05 * std::exp(excess / 2);
        EXPECT_NEAR(mean, 255 * light, 0.5) << excess;
        const double rounding = 1.0 / 12;
        EXPECT_NEAR(std::sqrt(square / count - mean * mean - rounding), expected, 0.05 * expected)
            << excess;
        Fluoroscopy other = s;
        other.seed = 1;
        EXPECT_NE(image.pixels, fluoroscopy_view(water, other, 128, 128, TaskArena(1)).pixels);
    }
    EXPECT_DOUBLE_EQ(render::quantum_noise(100), 0.2);
}

TEST(Fluoroscopy, CollimatorIsRoundOrEightSidedOrOpen) {
    const TaskArena arena(1);
    const Volume air =
        make_volume<std::int16_t>(grid_of({11, 11, 11}, {1, 1, 1}), [](Vec3d) { return -1000; });
    Fluoroscopy s{.width_mm = 50, .exposure_water_mm = 0};
    const auto black = [&](FieldStop stop, int width, int height) {
        s.field_stop = stop;
        const Image image = fluoroscopy_view(air, s, width, height, arena);
        EXPECT_EQ(image.pixels[std::size_t(height / 2 * width + width / 2)], (Rgb8{115, 115, 115}));
        return double(std::ranges::count(image.pixels, Rgb8{0, 0, 0})) / (width * height);
    };
    // All in the circle, or the octagon, that touches the picture's nearer sides.
    EXPECT_EQ(black(FieldStop::Full, 100, 80), 0);
    EXPECT_NEAR(black(FieldStop::Round, 200, 200), 1 - 0.7854, 0.01);
    EXPECT_NEAR(black(FieldStop::Round, 300, 200), 1 - 0.7854 / 1.5, 0.01);
    EXPECT_NEAR(black(FieldStop::Round, 200, 300), 1 - 0.7854 / 1.5, 0.01);
    EXPECT_NEAR(black(FieldStop::Octagon, 200, 200), 1 - 0.8284, 0.01);
}

}  // namespace
}  // namespace pliant
