// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "glyphs.h"
#include "page.h"

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

constexpr double kGlyphGap = 2;  ///< [units of the font]

/// Copies a picture into another one, with its top left corner at a pixel.
void paste(Image& into, const Image& part, int left, int top) {
    for (int y = 0; y < part.height; ++y)
        std::copy_n(part.pixels.begin() + std::ptrdiff_t(y) * part.width, part.width,
                    into.pixels.begin() + std::ptrdiff_t(y + top) * into.width + left);
}

Image blank(int width, int height) {
    return {width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height), kPaper)};
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

double text_width_px(std::string_view text, double height_px) {
    double units = text.empty() ? 0 : -kGlyphGap;
    while (!text.empty()) units += take_glyph(text).width + kGlyphGap;
    return units * height_px / kCapHeight;
}

Plot::Plot(int width, int height, Point2 low, Point2 high, Rgb8 background)
    : m_image{width, height,
              std::vector<Rgb8>(std::size_t(width) * std::size_t(height), background)},
      m_low(low),
      m_scale{width / (high.x - low.x), height / (high.y - low.y)} {}

Plot::Plot(Image picture) : m_image(std::move(picture)), m_low{0, 0}, m_scale{1, 1} {}

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

void Plot::arrow(Point2 from, Point2 to, const Ink& ink) {
    const Point2 a = pixel_of(from), b = pixel_of(to);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (length == 0) return;
    const double head = std::min(length, 6 + 3 * ink.width_px);
    const Point2 along{(b.x - a.x) / length, (b.y - a.y) / length};
    const auto behind = [&](double back, double aside) {
        return point_of(
            {b.x - back * along.x - aside * along.y, b.y - back * along.y + aside * along.x});
    };
    line(from, behind(0.8 * head, 0), ink);
    const std::array<Point2, 3> tip = {to, behind(head, 0.4 * head), behind(head, -0.4 * head)};
    polygon(tip, ink.colour);
}

void Plot::text(Point2 at, std::string_view text, double height_px, Rgb8 colour, Align align) {
    const double unit = height_px / kCapHeight, width = text_width_px(text, height_px);
    const Point2 p = pixel_of(at);
    double left = p.x - (align == Align::Left ? 0 : align == Align::Right ? width : 0.5 * width);
    const double top = p.y - 0.5 * height_px;
    const Ink ink{colour, std::max(1.2, 0.13 * height_px), 1};
    while (!text.empty()) {
        const Glyph glyph = take_glyph(text);
        const auto place = [&](GlyphStroke::Vertex v) {
            return point_of({left + v.x * unit, top + v.y * unit});
        };
        for (const GlyphStroke& stroke : glyph.strokes) {
            if (stroke.vertices.size() == 1)
                dot(place(stroke.vertices[0]), 0.7 * ink.width_px, colour);
            for (std::size_t n = 1; n < stroke.vertices.size(); ++n)
                line(place(stroke.vertices[n - 1]), place(stroke.vertices[n]), ink);
        }
        left += (glyph.width + kGlyphGap) * unit;
    }
}

void Plot::scale_bar(double length, std::string_view words, Rgb8 colour) {
    constexpr double kEdge_px = 12;
    const double left = kEdge_px, right = left + length * m_scale.x;
    const double y = m_image.height - kEdge_px;
    const auto stroke = [&](Point2 a, Point2 b) { line(point_of(a), point_of(b), {colour, 2, 1}); };
    stroke({left, y}, {right, y});
    for (const double end : {left, right}) stroke({end, y - 4}, {end, y + 4});
    text(point_of({left, y - 12}), words, kText_px, colour, Align::Left);
}

Image row_of(std::span<const Image> pictures, int gap_px) {
    int width = -gap_px, height = 0;
    for (const Image& p : pictures) {
        width += p.width + gap_px;
        height = std::max(height, p.height);
    }
    Image row = blank(width, height);
    int left = 0;
    for (const Image& p : pictures) {
        paste(row, p, left, 0);
        left += p.width + gap_px;
    }
    return row;
}

Image column_of(std::span<const Image> pictures, int gap_px) {
    int width = 0, height = -gap_px;
    for (const Image& p : pictures) {
        width = std::max(width, p.width);
        height += p.height + gap_px;
    }
    Image column = blank(width, height);
    int top = 0;
    for (const Image& p : pictures) {
        paste(column, p, 0, top);
        top += p.height + gap_px;
    }
    return column;
}

Image captioned(const Image& picture, std::string_view text) {
    constexpr int kLine_px = 22;
    Plot line(blank(picture.width, kLine_px));
    line.text({2, 0.5 * kLine_px - 1}, text, kText_px, kDark, Align::Left);
    const Image parts[] = {line.image(), picture};
    return column_of(parts, 0);
}

Image legend_of(std::span<const LegendEntry> entries, int width) {
    constexpr double kLine_px = 20, kSwatch_px = 26, kGap_px = 22, kEdge_px = 8;
    struct Placed {
        Point2 at;
        const LegendEntry* entry;
    };
    std::vector<Placed> placed;
    Point2 at{kEdge_px, 0.5 * kLine_px};
    for (const LegendEntry& entry : entries) {
        const double needed = kSwatch_px + 6 + text_width_px(entry.text);
        if (at.x > kEdge_px && at.x + needed > width - kEdge_px) at = {kEdge_px, at.y + kLine_px};
        placed.push_back({at, &entry});
        at.x += needed + kGap_px;
    }
    Plot plot(blank(width, int(at.y + 0.5 * kLine_px + 4)));
    for (const auto& [p, entry] : placed) {
        const Point2 end{p.x + kSwatch_px, p.y}, middle{p.x + 0.5 * kSwatch_px, p.y};
        using enum LegendEntry::Mark;
        // In the middle of a row of pixels, and no thinner than two: thin dark lines look grey.
        const double row = std::floor(p.y) + 0.5;
        const Ink ink{entry->ink.colour, std::max(2.0, entry->ink.width_px), entry->ink.opacity};
        const Point2 from{p.x, row}, to{end.x, row};
        if (entry->mark == Line || entry->mark == LineAndDot) plot.line(from, to, ink);
        if (entry->mark == LineAndDot)
            plot.dot({middle.x, from.y}, 0.5 * ink.width_px + 2.2, ink.colour);
        if (entry->mark == Dashes) plot.dashed_line(from, to, ink, 6);
        if (entry->mark == Dot) plot.dot(middle, entry->ink.width_px, entry->ink.colour);
        if (entry->mark == Box)
            plot.line({p.x + 7, p.y}, {end.x - 7, p.y}, {entry->ink.colour, 12});
        plot.text({end.x + 6, p.y}, entry->text, kText_px, kDark, Align::Left);
    }
    return plot.image();
}

Image shade_bar(double darkest, int decimals, std::string_view name, double largest) {
    constexpr int kHeight_px = 26, kBar_px = 140;
    const std::string end = (largest > darkest ? "\u2265" : "") + fixed_text(darkest, decimals);
    const double texts_px = text_width_px(name) + text_width_px("0") + text_width_px(end);
    Plot plot(blank(int(texts_px) + kBar_px + 46, kHeight_px));
    const double y = 0.5 * kHeight_px;
    double x = 8;
    plot.text({x, y}, name, kText_px, kDark, Align::Left);
    x += text_width_px(name) + 14;
    plot.text({x, y}, "0", kText_px, kDark, Align::Left);
    x += text_width_px("0") + 7;
    for (int n = 0; n < kBar_px; ++n)
        for (int row = 6; row < kHeight_px - 6; ++row)
            plot.dab(int(x) + n, row, shade_of((n + 0.5) / kBar_px), 1);
    plot.text({x + kBar_px + 7, y}, end, kText_px, kDark, Align::Left);
    return plot.image();
}

}  // namespace pliant::results
