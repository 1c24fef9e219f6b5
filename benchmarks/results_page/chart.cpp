// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "page.h"

namespace pliant::results {
namespace {

constexpr double kLeft_px = 52, kBottom_px = 34, kRim_px = 14, kDigit_px = 10;

/// The sheet's own corners, so that the axes leave room for their numbers.
Plot sheet(int width, int height, const Axis& x, const Axis& y) {
    const double x_scale = (x.high - x.low) / (width - kLeft_px - kRim_px);
    const double y_scale = (y.high - y.low) / (height - kBottom_px - kRim_px);
    return Plot(width, height, {x.low - kLeft_px * x_scale, y.high + kRim_px * y_scale},
                {x.high + kRim_px * x_scale, y.low - kBottom_px * y_scale});
}

}  // namespace

Chart::Chart(int width, int height, const Axis& x, const Axis& y)
    : m_x(x), m_y(y), m_plot(sheet(width, height, x, y)) {
    const Ink grid{kFaint, 1, 1}, zero{{140, 146, 156}, 1.2, 1};
    const auto number = [&](Point2 at, double dx_px, double dy_px, double value, int decimals) {
        const Point2 p = m_plot.pixel_of(at);
        m_plot.number(m_plot.point_of({p.x + dx_px, p.y + dy_px}), text_of(value, decimals),
                      kDigit_px, {90, 96, 106});
    };
    for (int n = 0; x.low + n * x.step <= x.high + 1e-9 * x.step; ++n) {
        const double at = x.low + n * x.step;
        m_plot.line({at, y.low}, {at, y.high}, std::abs(at) < 1e-9 ? zero : grid);
        number({at, y.low}, 0, 18, at, x.decimals);
    }
    for (int n = 0; y.low + n * y.step <= y.high + 1e-9 * y.step; ++n) {
        const double at = y.low + n * y.step;
        m_plot.line({x.low, at}, {x.high, at}, std::abs(at) < 1e-9 ? zero : grid);
        number({x.low, at}, -26, 0, at, y.decimals);
    }
}

void Chart::curve(std::span<const Point2> points, const Ink& ink) {
    m_plot.polyline(points, ink);
    for (const Point2 p : points) m_plot.dot(p, 1.6 * ink.width_px, ink.colour);
}

void Chart::mark(double x, const Ink& ink) {
    m_plot.dashed_line({x, m_y.low}, {x, m_y.high}, ink, 6);
}

void Chart::bar(double x_begin, double x_end, double y, Rgb8 colour) {
    const std::array<Point2, 4> corners = {
        {{x_begin, m_y.low}, {x_end, m_y.low}, {x_end, y}, {x_begin, y}}};
    m_plot.polygon(corners, colour);
}

Image histogram(std::span<const double> values, const Axis& x, double class_width, double marked,
                int width, int height) {
    const int classes = std::max(1, int(std::ceil((x.high - x.low) / class_width - 1e-9)));
    std::vector<double> shares(std::size_t(classes), 0.0);
    for (const double v : values) {
        const int n = std::clamp(int((v - x.low) / class_width), 0, classes - 1);
        shares[std::size_t(n)] += 100.0 / double(values.size());
    }
    const double most = *std::max_element(shares.begin(), shares.end());
    const double step = most > 50 ? 20 : most > 20 ? 10 : most > 10 ? 5 : 2;
    Chart chart(width, height, x, {0, step * std::ceil(most / step), step});
    for (int n = 0; n < classes; ++n) {
        const double begin = x.low + n * class_width;
        chart.bar(begin + 0.06 * class_width, begin + 0.94 * class_width, shares[std::size_t(n)],
                  begin >= marked ? kRed : kBlue);
    }
    chart.mark(marked, {kRed, 1.6, 1});
    return chart.image();
}

}  // namespace pliant::results
