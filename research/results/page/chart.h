// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Curves and histograms with named and numbered axes and a legend.

#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plot.h"

namespace pliant::results {

struct Axis {
    std::string name;        ///< with its unit, such as "depth [mm]"
    double low, high, step;  ///< step: between numbered grid lines
    int decimals = 0;
    /// low, high and step are powers of ten, and values below the lowest one are drawn at it.
    bool is_logarithmic = false;
};

class Chart {
  public:
    Chart(int width, int height, const Axis& x, const Axis& y);

    /// A line, with dots at distant points; clipped at the axes.
    /// @param name  in the legend; empty: no entry
    void curve(std::span<const Point2> points, const Ink& ink, std::string_view name = "");
    void dots(std::span<const Point2> points, const Ink& ink, std::string_view name = "");
    /// A dashed vertical line over the whole height.
    void mark(double x, const Ink& ink, std::string_view name = "");
    /// A bar from the lower end of the y axis.
    void bar(double x_begin, double x_end, double y, Rgb8 colour);
    /// The chart with its legend below it.
    Image image() const;

  private:
    /// Position on the sheet, whose logarithmic axes have powers of ten.
    Point2 placed(Point2 p) const;
    void enter(std::string_view name, const Ink& ink, LegendEntry::Mark mark);

    Axis m_x, m_y;
    Plot m_plot;
    std::vector<LegendEntry> m_legend;
};

/// Shares [%] of values in classes of equal width; larger values count in the last class.
/// @param marked  a value that is marked in red. @param mark_name  in the legend
Image histogram(std::span<const double> values, const Axis& x, double class_width, double marked,
                std::string_view mark_name, int width, int height);

}  // namespace pliant::results
