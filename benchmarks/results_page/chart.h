// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Curves and histograms with numbered axes.

#pragma once

#include <span>
#include <vector>

#include "plot.h"

namespace pliant::results {

struct Axis {
    double low, high, step;  ///< step: between grid lines, each with its number
    int decimals = 0;
};

class Chart {
  public:
    Chart(int width, int height, const Axis& x, const Axis& y);

    void curve(std::span<const Point2> points, const Ink& ink);
    /// A dashed upright line over the whole height.
    void mark(double x, const Ink& ink);
    /// A bar from the lower end of the y axis.
    void bar(double x_begin, double x_end, double y, Rgb8 colour);
    const Image& image() const { return m_plot.image(); }

  private:
    Axis m_x, m_y;
    Plot m_plot;
};

/// Shares [%] of values in equally wide classes; those beyond the last are counted in it.
/// @param marked  a value that is marked in red
Image histogram(std::span<const double> values, const Axis& x, double class_width, double marked,
                int width, int height);

}  // namespace pliant::results
