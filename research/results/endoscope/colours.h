// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colour statistics of an endoscope's picture, in the quantities of the clinical literature.

#pragma once

#include <pliant/render.h>

#include <span>

namespace pliant::results {

/// Colour of a pixel, or the median of many in each quantity.
struct Colour {
    double hue_deg = 0;      ///< −180…180; 0: red, 30: orange
    double saturation = 0;   ///< HSV, 0…1
    double haemoglobin = 0;  ///< IHb = 32 log₂(R/G) of linear light [Asaki2001]
    double x = 0, y = 0;     ///< CIE 1931 chromaticity, white point D65
};
Colour colour_of(Rgb8 pixel);

/// Statistics of the pixels inside the field whose value (largest channel) is at least 0.15.
struct ColourStatistics {
    Colour median;
    /// Share of highlights: value ≥ 0.8, saturation below ¾ of the median, and green at least 1.15
    /// times its mean over 25 × 25 pixels. Bright, pale, and contrasted with the surroundings: the
    /// criteria of [Arnold2010], with our thresholds.
    double highlights = 0;
    double clipped = 0;       ///< share: a channel ≥ 250 of 255
    std::int64_t pixels = 0;  ///< number of pixels in the statistics
};

/// @param field  radius of the field [halves of the picture's height]
ColourStatistics measure_colours(const Image& image, double field = 0.97);

/// Linear light of a channel before RealLook's tone curve, inverted by bisection.
/// @param value  0…255; ≥ 254 is clipped, and the result a lower bound
double light_before_tone(std::uint8_t value);

/// One step of stairs across the view.
struct Stair {
    double distance_mm;  ///< from the lens, median
    double light;        ///< of the red channel before the tone curve, median
};

/// Median light on walls at 8…60 mm in one picture of the style Real, without shadows and vignette.
std::vector<Stair> light_on_stairs(const TaskArena& arena);

/// n of light ~ distance⁻ⁿ, least squares over logarithms.
double falloff_exponent(std::span<const Stair> stairs);

}  // namespace pliant::results
