// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "page.h"

namespace pliant::results {
namespace {

constexpr double kLeft_px = 52, kBottom_px = 52, kRight_px = 20, kTop_px = 32;
constexpr double kFarApart_px = 8;  ///< mean distance of points above which they get dots
constexpr Rgb8 kGreyText{90, 96, 106};

/// Corners of the sheet, with margins for the axes' numbers.
Plot sheet(int width, int height, const Axis& x, const Axis& y) {
    const double x_scale = (x.high - x.low) / (width - kLeft_px - kRight_px);
    const double y_scale = (y.high - y.low) / (height - kBottom_px - kTop_px);
    return Plot(width, height, {x.low - kLeft_px * x_scale, y.high + kTop_px * y_scale},
                {x.high + kRight_px * x_scale, y.low - kBottom_px * y_scale});
}

double placed_on(const Axis& axis, double value) {
    if (!axis.is_logarithmic) return value;
    return value > 0 ? std::max(std::log10(value), axis.low) : axis.low;
}

double dot_radius_px(const Ink& ink) {
    return std::min(1.6 * ink.width_px, 0.5 * ink.width_px + 2.2);
}

/// Number at a grid line.
std::string number_at(const Axis& axis, double at) {
    if (!axis.is_logarithmic) return fixed_text(at, axis.decimals);
    return fixed_text(std::pow(10, at), std::max(0, int(std::ceil(-at - 1e-9))));
}

/// Clips a segment to the axes. @returns false if it is outside
bool clip(Point2& a, Point2& b, const Axis& x, const Axis& y) {
    double begin = 0, end = 1;
    const auto within = [&](double from, double to, double low, double high) {
        const double way = to - from;
        if (way == 0) return from >= low && from <= high;
        const double s = (low - from) / way, t = (high - from) / way;
        begin = std::max(begin, std::min(s, t));
        end = std::min(end, std::max(s, t));
        return begin <= end;
    };
    if (!within(a.x, b.x, x.low, x.high) || !within(a.y, b.y, y.low, y.high)) return false;
    const auto at = [from = a, to = b](double t) {
        return Point2{from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
    };
    a = at(begin);
    b = at(end);
    return true;
}

}  // namespace

Chart::Chart(int width, int height, const Axis& x, const Axis& y)
    : m_x(x), m_y(y), m_plot(sheet(width, height, x, y)) {
    const Ink grid{kFaint, 1, 1}, zero{{140, 146, 156}, 1.2, 1};
    const auto words = [&](Point2 at, double dx_px, double dy_px, std::string_view text,
                           Align align) {
        const Point2 p = m_plot.pixel_of(at);
        m_plot.text(m_plot.point_of({p.x + dx_px, p.y + dy_px}), text, kText_px, kGreyText, align);
    };
    for (int n = 0; x.low + n * x.step <= x.high + 1e-9 * x.step; ++n) {
        const double at = x.low + n * x.step;
        m_plot.line({at, y.low}, {at, y.high},
                    std::abs(at) < 1e-9 && !x.is_logarithmic ? zero : grid);
        words({at, y.low}, 0, 16, number_at(x, at), Align::Middle);
    }
    for (int n = 0; y.low + n * y.step <= y.high + 1e-9 * y.step; ++n) {
        const double at = y.low + n * y.step;
        m_plot.line({x.low, at}, {x.high, at},
                    std::abs(at) < 1e-9 && !y.is_logarithmic ? zero : grid);
        words({x.low, at}, -8, 0, number_at(y, at), Align::Right);
    }
    words({x.high, y.low}, 0, 38, x.name, Align::Right);
    words({x.low, y.high}, 8 - kLeft_px, -19, y.name, Align::Left);
}

Point2 Chart::placed(Point2 p) const {
    return {placed_on(m_x, p.x), placed_on(m_y, p.y)};
}

void Chart::enter(std::string_view name, const Ink& ink, LegendEntry::Mark mark) {
    if (!name.empty()) m_legend.push_back({std::string(name), ink, mark});
}

void Chart::curve(std::span<const Point2> points, const Ink& ink, std::string_view name) {
    double length_px = 0;
    for (std::size_t n = 1; n < points.size(); ++n) {
        Point2 a = placed(points[n - 1]), b = placed(points[n]);
        if (!clip(a, b, m_x, m_y)) continue;
        m_plot.line(a, b, ink);
        const Point2 p = m_plot.pixel_of(a), q = m_plot.pixel_of(b);
        length_px += std::hypot(q.x - p.x, q.y - p.y);
    }
    const bool has_dots = length_px > kFarApart_px * double(points.size());
    if (has_dots) dots(points, {ink.colour, dot_radius_px(ink)});
    enter(name, ink, has_dots ? LegendEntry::Mark::LineAndDot : LegendEntry::Mark::Line);
}

void Chart::dots(std::span<const Point2> points, const Ink& ink, std::string_view name) {
    for (const Point2 point : points) {
        Point2 p = placed(point), q = p;
        if (clip(p, q, m_x, m_y)) m_plot.dot(p, ink.width_px, ink.colour);
    }
    enter(name, ink, LegendEntry::Mark::Dot);
}

void Chart::mark(double x, const Ink& ink, std::string_view name) {
    m_plot.dashed_line({x, m_y.low}, {x, m_y.high}, ink, 6);
    enter(name, ink, LegendEntry::Mark::Dashes);
}

Image Chart::image() const {
    if (m_legend.empty()) return m_plot.image();
    const Image parts[] = {m_plot.image(), legend_of(m_legend, m_plot.image().width)};
    return column_of(parts, 0);
}

void Chart::bar(double x_begin, double x_end, double y, Rgb8 colour) {
    const std::array<Point2, 4> corners = {
        {{x_begin, m_y.low}, {x_end, m_y.low}, {x_end, y}, {x_begin, y}}};
    m_plot.polygon(corners, colour);
}

Image histogram(std::span<const double> values, const Axis& x, double class_width, double marked,
                std::string_view mark_name, int width, int height) {
    const int classes = std::max(1, int(std::ceil((x.high - x.low) / class_width - 1e-9)));
    std::vector<double> shares(std::size_t(classes), 0.0);
    for (const double v : values) {
        const int n = std::clamp(int((v - x.low) / class_width), 0, classes - 1);
        shares[std::size_t(n)] += 100.0 / double(values.size());
    }
    const double most = *std::max_element(shares.begin(), shares.end());
    const double step = most > 50 ? 20 : most > 20 ? 10 : most > 10 ? 5 : 2;
    Chart chart(width, height, x, {"share [%]", 0, step * std::ceil(most / step), step});
    for (int n = 0; n < classes; ++n) {
        const double begin = x.low + n * class_width;
        chart.bar(begin + 0.06 * class_width, begin + 0.94 * class_width, shares[std::size_t(n)],
                  begin >= marked ? kRed : kBlue);
    }
    chart.mark(marked, {kRed, 1.6, 1}, mark_name);
    return chart.image();
}

}  // namespace pliant::results
