// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: results_endoscope/colours.h.

#include <gtest/gtest.h>

#include <cmath>

#include "endoscope/colours.h"

namespace pliant::results {
namespace {

TEST(Colours, AreThoseOfTheDefinitions) {
    const Colour white = colour_of({255, 255, 255});
    EXPECT_NEAR(white.x, 0.3127, 2e-4);  // D65
    EXPECT_NEAR(white.y, 0.3290, 2e-4);
    EXPECT_NEAR(white.haemoglobin, 0, 1e-9);
    const Colour red = colour_of({255, 0, 0});
    EXPECT_NEAR(red.x, 0.64, 1e-3);  // the primary of sRGB
    EXPECT_NEAR(red.y, 0.33, 1e-3);
    EXPECT_NEAR(colour_of({200, 100, 50}).hue_deg, 20, 1e-9);
    EXPECT_NEAR(colour_of({200, 50, 100}).hue_deg, -20, 1e-9);
    EXPECT_NEAR(colour_of({200, 100, 50}).saturation, 0.75, 1e-9);
    // 188 is half of the light of 255.
    EXPECT_NEAR(colour_of({255, 188, 0}).haemoglobin, 32, 0.3);
}

TEST(Colours, AreMeasuredInsideTheFieldWhereItIsNotDark) {
    Image image{200, 100, std::vector<Rgb8>(20000, Rgb8{0, 255, 0})};
    int inside = 0, bright = 0;
    for (int j = 0; j < 100; ++j)
        for (int i = 0; i < 200; ++i) {
            const double u = (2 * i + 1.0 - 200) / 100, v = (2 * j + 1.0 - 100) / 100;
            if (std::hypot(u, v) > 0.98) continue;
            Rgb8& pixel = image.pixels[std::size_t(j) * 200 + std::size_t(i)];
            pixel = {200, 100, 50};
            if (i > 95 && i < 105 && j < 50) pixel = {20, 10, 30};              // the dark lumen
            if (i > 60 && i < 63 && j > 50 && j < 70) pixel = {255, 240, 230};  // a highlight
            inside += std::hypot(u, v) <= 0.9 && pixel.r > 30;
            bright += std::hypot(u, v) <= 0.9 && pixel.r == 255;
        }
    ASSERT_GT(bright, 30);
    const ColourStatistics s = measure_colours(image, 0.9);
    EXPECT_EQ(s.pixels, inside);
    EXPECT_NEAR(s.median.hue_deg, 20, 1e-9);
    EXPECT_NEAR(s.median.saturation, 0.75, 1e-9);
    EXPECT_NEAR(s.highlights, double(bright) / inside, 1e-12);
    EXPECT_NEAR(s.clipped, double(bright) / inside, 1e-12);
}

TEST(Colours, LightIsThatBeforeTheToneCurve) {
    for (const double light : {0.02, 0.1, 0.4, 1.0, 2.0}) {
        const double x = 0.9 * light;
        const double toned = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
        const double shown = 1.055 * std::pow(toned, 1 / 2.4) - 0.055;
        const auto value = std::uint8_t(std::lround(255 * shown));
        EXPECT_NEAR(light_before_tone(value) / light, 1, 0.05) << light;
    }
}

TEST(Colours, FalloffIsTheSlopeOverLogarithms) {
    std::vector<Stair> stairs;
    for (const double d : {5.0, 9.0, 17.0, 40.0}) stairs.push_back({d, 3 * std::pow(d, -1.7)});
    EXPECT_NEAR(falloff_exponent(stairs), 1.7, 1e-9);
}

}  // namespace
}  // namespace pliant::results
