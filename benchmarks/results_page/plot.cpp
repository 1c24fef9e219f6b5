// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace pliant::results {
namespace {

double distance_to_segment(Point2 p, Point2 a, Point2 b) {
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const double along = (p.x - a.x) * dx + (p.y - a.y) * dy;
    const double t = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0;
    return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

std::uint8_t mixed(std::uint8_t under, std::uint8_t over, double opacity) {
    return std::uint8_t(std::lround(under + (over - under) * opacity));
}

/// The strokes of a digit, as in the displays of pocket calculators: pairs of corners of
///
///     0──1
///     2──3
///     4──5
std::string_view strokes_of(char digit) {
    constexpr std::string_view kStrokes[] = {
        "011335452402", "1335",         "0113232445", "0113233545",     "02231335",
        "0102233545",   "010223243545", "011335",     "01133545240223", "010213233545"};
    if (digit == '-') return "23";
    return digit >= '0' && digit <= '9' ? kStrokes[digit - '0'] : "";
}

constexpr double kDigitWidth = 0.5, kDigitAdvance = 0.8, kPointAdvance = 0.35;

double advance_of(char c) {
    return c == '.' ? kPointAdvance : kDigitAdvance;
}

}  // namespace

Rgb8 shade_of(double t) {
    constexpr std::array<Vec3d, 5> kStops = {{{0.80, 0.84, 0.90},
                                              {0.55, 0.77, 0.86},
                                              {0.20, 0.58, 0.74},
                                              {0.16, 0.33, 0.60},
                                              {0.22, 0.10, 0.36}}};
    const double at = std::clamp(t, 0.0, 1.0) * double(kStops.size() - 1);
    const auto n = std::min(std::size_t(at), kStops.size() - 2);
    const double f = at - double(n);
    const Vec3d c = (1 - f) * kStops[n] + f * kStops[n + 1];
    const auto byte = [](double v) { return std::uint8_t(std::lround(255 * v)); };
    return {byte(c.x), byte(c.y), byte(c.z)};
}

Plot::Plot(int width, int height, Point2 low, Point2 high, Rgb8 background)
    : m_image{width, height,
              std::vector<Rgb8>(std::size_t(width) * std::size_t(height), background)},
      m_low(low),
      m_scale{width / (high.x - low.x), height / (high.y - low.y)} {}

Point2 Plot::pixel_of(Point2 p) const {
    return {(p.x - m_low.x) * m_scale.x, (p.y - m_low.y) * m_scale.y};
}

Point2 Plot::point_of(Point2 pixel) const {
    return {m_low.x + pixel.x / m_scale.x, m_low.y + pixel.y / m_scale.y};
}

void Plot::dab(int x, int y, Rgb8 colour, double opacity) {
    if (x < 0 || y < 0 || x >= m_image.width || y >= m_image.height) return;
    Rgb8& p = m_image.pixels[std::size_t(y) * std::size_t(m_image.width) + std::size_t(x)];
    p = {mixed(p.r, colour.r, opacity), mixed(p.g, colour.g, opacity),
         mixed(p.b, colour.b, opacity)};
}

void Plot::line(Point2 from, Point2 to, const Ink& ink) {
    const Point2 a = pixel_of(from), b = pixel_of(to);
    const double reach = 0.5 * ink.width_px + 0.5;
    const int left = int(std::floor(std::max(std::min(a.x, b.x) - reach, 0.0)));
    const int right = int(std::ceil(std::min(std::max(a.x, b.x) + reach, m_image.width - 1.0)));
    const int top = int(std::floor(std::max(std::min(a.y, b.y) - reach, 0.0)));
    const int bottom = int(std::ceil(std::min(std::max(a.y, b.y) + reach, m_image.height - 1.0)));
    for (int y = top; y <= bottom; ++y)
        for (int x = left; x <= right; ++x) {
            const double away = distance_to_segment({x + 0.5, y + 0.5}, a, b);
            const double cover = std::min({reach - away, ink.width_px, 1.0});
            if (cover > 0) dab(x, y, ink.colour, cover * ink.opacity);
        }
}

void Plot::dashed_line(Point2 from, Point2 to, const Ink& ink, double dash_px) {
    const Point2 a = pixel_of(from), b = pixel_of(to);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const auto at = [&](double px) {
        const double t = std::min(px / length, 1.0);
        return Point2{from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
    };
    for (double px = 0; px < length; px += 2 * dash_px) line(at(px), at(px + dash_px), ink);
}

void Plot::polyline(std::span<const Point2> points, const Ink& ink, bool closed) {
    for (std::size_t n = 1; n < points.size(); ++n) line(points[n - 1], points[n], ink);
    if (closed && points.size() > 2) line(points.back(), points.front(), ink);
}

void Plot::dot(Point2 centre, double radius_px, Rgb8 colour, double opacity) {
    line(centre, centre, {colour, 2 * radius_px, opacity});
}

void Plot::polygon(std::span<const Point2> corners, Rgb8 colour) {
    std::vector<Point2> c;
    for (const Point2 corner : corners) c.push_back(pixel_of(corner));
    const auto lower = [](Point2 a, Point2 b) { return a.y < b.y; };
    const auto [top, bottom] = std::minmax_element(c.begin(), c.end(), lower);
    const int last = std::min(int(std::ceil(bottom->y)), m_image.height);
    for (int y = std::max(int(std::floor(top->y)), 0); y < last; ++y) {
        std::vector<double> crossings;
        const double middle = y + 0.5;
        for (std::size_t n = 0; n < c.size(); ++n) {
            const Point2 a = c[n], b = c[(n + 1) % c.size()];
            if ((a.y <= middle) == (b.y <= middle)) continue;
            crossings.push_back(a.x + (middle - a.y) / (b.y - a.y) * (b.x - a.x));
        }
        std::sort(crossings.begin(), crossings.end());
        for (std::size_t n = 0; n + 1 < crossings.size(); n += 2) {
            const double end = std::min(crossings[n + 1], double(m_image.width));
            const int first = int(std::ceil(std::max(crossings[n], 0.0) - 0.5));
            for (int x = first; x + 0.5 < end; ++x) dab(x, y, colour, 1);
        }
    }
}

void Plot::number(Point2 centre, std::string_view digits, double height_px, Rgb8 colour) {
    double width = kDigitWidth - kDigitAdvance;
    for (const char c : digits) width += advance_of(c);
    const Point2 middle = pixel_of(centre);
    double left = middle.x - 0.5 * width * height_px;
    const double top = middle.y - 0.5 * height_px;
    const Ink ink{colour, std::max(1.2, 0.14 * height_px), 1};
    const auto corner = [&](char frame) {
        const int n = frame - '0';
        return point_of(
            {left + (n & 1) * kDigitWidth * height_px, top + (n >> 1) * 0.5 * height_px});
    };
    for (const char c : digits) {
        const std::string_view strokes = strokes_of(c);
        for (std::size_t n = 0; n + 1 < strokes.size(); n += 2)
            line(corner(strokes[n]), corner(strokes[n + 1]), ink);
        if (c == '.') dot(corner('4'), 0.6 * ink.width_px, colour);
        left += advance_of(c) * height_px;
    }
}

Image row_of(std::span<const Image> pictures, int gap_px) {
    int width = -gap_px, height = 0;
    for (const Image& p : pictures) {
        width += p.width + gap_px;
        height = std::max(height, p.height);
    }
    Image row{width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height), kPaper)};
    std::ptrdiff_t left = 0;
    for (const Image& p : pictures) {
        for (int y = 0; y < p.height; ++y)
            std::copy_n(p.pixels.begin() + std::ptrdiff_t(y) * p.width, p.width,
                        row.pixels.begin() + std::ptrdiff_t(y) * width + left);
        left += p.width + gap_px;
    }
    return row;
}

}  // namespace pliant::results
