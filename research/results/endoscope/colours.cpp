// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "colours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant::results {
namespace {

double linear(double s) {
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double value_of_pixel(Rgb8 c) {
    return std::max({c.r, c.g, c.b}) / 255.0;
}

/// Mean of green over a square around each pixel, clipped at the picture's edge.
class GreenAround {
  public:
    explicit GreenAround(const Image& image)
        : m_width(image.width), m_height(image.height), m_sums(sum_count(), 0) {
        for (int j = 0; j < m_height; ++j)
            for (int i = 0; i < m_width; ++i)
                m_sums[at(i + 1, j + 1)] =
                    m_sums[at(i, j + 1)] + m_sums[at(i + 1, j)] - m_sums[at(i, j)] +
                    image.pixels[std::size_t(j) * std::size_t(m_width) + std::size_t(i)].g;
    }
    double mean(int i, int j) const {
        constexpr int kReach = 12;
        const int x0 = std::max(i - kReach, 0), x1 = std::min(i + kReach + 1, m_width);
        const int y0 = std::max(j - kReach, 0), y1 = std::min(j + kReach + 1, m_height);
        const double sum =
            m_sums[at(x1, y1)] - m_sums[at(x0, y1)] - m_sums[at(x1, y0)] + m_sums[at(x0, y0)];
        return sum / ((x1 - x0) * (y1 - y0));
    }

  private:
    std::size_t sum_count() const { return std::size_t(m_width + 1) * std::size_t(m_height + 1); }
    std::size_t at(int i, int j) const {
        return std::size_t(j) * std::size_t(m_width + 1) + std::size_t(i);
    }

    int m_width, m_height;
    std::vector<double> m_sums;
};

}  // namespace

Colour colour_of(Rgb8 c) {
    const std::array<double, 3> s{c.r / 255.0, c.g / 255.0, c.b / 255.0};
    const double most = std::max({s[0], s[1], s[2]}), least = std::min({s[0], s[1], s[2]});
    const double range = std::max(most - least, 1e-9);
    double hue = most == s[0]   ? (s[1] - s[2]) / range
                 : most == s[1] ? 2 + (s[2] - s[0]) / range
                                : 4 + (s[0] - s[1]) / range;
    if (hue > 3) hue -= 6;
    const double r = linear(s[0]), g = linear(s[1]), b = linear(s[2]);
    // IEC 61966-2-1.
    const double x = 0.4124 * r + 0.3576 * g + 0.1805 * b;
    const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    const double z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
    const double sum = std::max(x + y + z, 1e-9);
    return {.hue_deg = 60 * hue,
            .saturation = (most - least) / std::max(most, 1e-9),
            .haemoglobin = 32 * std::log2(std::max(r, 1e-6) / std::max(g, 1e-6)),
            .x = x / sum,
            .y = y / sum};
}

ColourStatistics measure_colours(const Image& image, double field) {
    std::vector<Colour> colours;
    std::vector<std::array<int, 2>> positions;
    std::int64_t clipped = 0;
    const auto at = [&](int i, int j) {
        return image.pixels[std::size_t(j) * std::size_t(image.width) + std::size_t(i)];
    };
    for (int j = 0; j < image.height; ++j)
        for (int i = 0; i < image.width; ++i) {
            const double u = (2 * i + 1.0 - image.width) / image.height;
            const double v = (2 * j + 1.0 - image.height) / image.height;
            if (u * u + v * v > field * field || value_of_pixel(at(i, j)) < 0.15) continue;
            colours.push_back(colour_of(at(i, j)));
            positions.push_back({i, j});
            clipped += value_of_pixel(at(i, j)) >= 250 / 255.0;
        }
    const auto median_of = [&](double Colour::*quantity) {
        std::vector<double> values;
        for (const Colour& c : colours) values.push_back(c.*quantity);
        return median(std::move(values));
    };
    ColourStatistics s{.median = {.hue_deg = median_of(&Colour::hue_deg),
                                  .saturation = median_of(&Colour::saturation),
                                  .haemoglobin = median_of(&Colour::haemoglobin),
                                  .x = median_of(&Colour::x),
                                  .y = median_of(&Colour::y)},
                       .pixels = std::int64_t(colours.size())};
    const GreenAround green(image);
    std::int64_t highlights = 0;
    for (std::size_t n = 0; n < colours.size(); ++n) {
        const auto [i, j] = positions[n];
        highlights += value_of_pixel(at(i, j)) >= 0.8 &&
                      colours[n].saturation < 0.75 * s.median.saturation &&
                      at(i, j).g >= 1.15 * green.mean(i, j);
    }
    const double count = std::max(1.0, double(colours.size()));
    s.highlights = double(highlights) / count;
    s.clipped = double(clipped) / count;
    return s;
}

double light_before_tone(std::uint8_t value) {
    const double shown = linear(value / 255.0);
    double low = 0, high = 16;
    for (int step = 0; step < 60; ++step) {
        const double light = 0.5 * (low + high), x = 0.9 * light;
        const double toned = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
        (toned < shown ? low : high) = light;
    }
    return 0.5 * (low + high);
}

double falloff_exponent(std::span<const Stair> stairs) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const Stair& s : stairs) {
        const double x = std::log(s.distance_mm), y = std::log(s.light);
        n += 1;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return -(n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace pliant::results
