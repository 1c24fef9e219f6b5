// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Squared distance transform along one line: the lower envelope of parabolas at its cells
// [Felzenszwalb2012]. Passes along each axis give the exact distance in space.

#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace pliant {

class LineTransform {
  public:
    explicit LineTransform(int longest)
        : m_value(std::size_t(longest)),
          m_foot(std::size_t(longest)),
          m_from(std::size_t(longest) + 1) {}

    /// Replaces line[i·stride] by the minimum of line[j·stride] + ((i − j)·spacing)² over all j.
    void run(float* line, std::size_t stride, int count, double spacing) {
        const double kFar = std::numeric_limits<double>::infinity();
        int top = -1;
        for (int i = 0; i < count; ++i) {
            const double value = double(line[std::size_t(i) * stride]);
            m_value[std::size_t(i)] = value;
            if (std::isinf(value)) continue;
            double from = -kFar;
            while (top >= 0) {
                const int foot = m_foot[std::size_t(top)];
                const double a = foot * spacing, b = i * spacing;
                from = (value + b * b - m_value[std::size_t(foot)] - a * a) / (2 * (b - a));
                if (from > m_from[std::size_t(top)]) break;
                --top;
                from = -kFar;
            }
            ++top;
            m_foot[std::size_t(top)] = i;
            m_from[std::size_t(top)] = from;
        }
        for (int i = count - 1; i >= 0 && top >= 0; --i) {
            while (i * spacing < m_from[std::size_t(top)]) --top;
            const int foot = m_foot[std::size_t(top)];
            const double d = (i - foot) * spacing;
            line[std::size_t(i) * stride] = float(d * d + m_value[std::size_t(foot)]);
        }
    }

  private:
    std::vector<double> m_value;
    std::vector<int> m_foot;
    std::vector<double> m_from;
};

}  // namespace pliant
