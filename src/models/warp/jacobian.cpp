// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The smallest Jacobian of a warp. At a corner of a trilinear cell, the columns of ∂φ/∂X are the
// cell's three edges there. So the eight determinants at an element have its forward or backward
// differences along each axis.

#include <pliant/data/warp.h>

#include <algorithm>
#include <array>
#include <vector>

#include "field/fixed_point.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

/// Differences of one component at the elements of a row, to the elements at −1 and +1 along each
/// axis, as a fraction of the spacing there.
struct Slopes {
    std::array<std::vector<float>, 6> of;  ///< 2·axis + (forward)
};

/// Displacements with two layers of elements at rest around them.
class Padded {
  public:
    explicit Padded(const WarpState& state)
        : m_size(state.box.end - state.box.begin + Vec3i{4, 4, 4}), m_state(state) {}

    Vec3i size() const { return m_size; }
    /// The row of component a whose first element is at padded (0, y, z).
    void read_row(int a, int y, int z, std::vector<std::int32_t>& row) const {
        row.assign(std::size_t(m_size.x), 0);
        const Vec3i n = m_size - Vec3i{4, 4, 4};
        if (y < 2 || z < 2 || y >= n.y + 2 || z >= n.z + 2) return;
        const std::size_t first =
            std::size_t(a) * dense_count(n) + dense_index({0, y - 2, z - 2}, n);
        std::copy_n(m_state.units.begin() + std::ptrdiff_t(first), n.x, row.begin() + 2);
    }

  private:
    Vec3i m_size;
    const WarpState& m_state;
};

float smallest_in_row(const std::array<Slopes, 3>& slopes, std::size_t count) {
    float smallest = 1;
    for (unsigned side = 0; side < 8; ++side) {
        const auto column = [&](std::size_t a, std::size_t b) {
            return slopes[a].of[2 * b + (side >> b & 1)].data();
        };
        const float *xx = column(0, 0), *xy = column(0, 1), *xz = column(0, 2);
        const float *yx = column(1, 0), *yy = column(1, 1), *yz = column(1, 2);
        const float *zx = column(2, 0), *zy = column(2, 1), *zz = column(2, 2);
        for (std::size_t n = 0; n < count; ++n) {
            const float a = 1 + xx[n], e = 1 + yy[n], i = 1 + zz[n];
            const float d = a * (e * i - yz[n] * zy[n]) - xy[n] * (yx[n] * i - yz[n] * zx[n]) +
                            xz[n] * (yx[n] * zy[n] - e * zx[n]);
            smallest = d < smallest ? d : smallest;
        }
    }
    return smallest;
}

}  // namespace

double Warp::smallest_jacobian() const {
    if (is_empty(m_state.box)) return 1;
    const Padded padded(m_state);
    const Vec3i n = padded.size();
    const auto count = std::size_t(n.x - 2);  // rows without their first and last element
    std::array<Slopes, 3> slopes;
    for (Slopes& s : slopes)
        for (auto& values : s.of) values.resize(count);
    std::vector<std::int32_t> row, other;
    double smallest = 1;
    for (int z = 1; z < n.z - 1; ++z)
        for (int y = 1; y < n.y - 1; ++y) {
            for (int a = 0; a < 3; ++a) {
                padded.read_row(a, y, z, row);
                for (int b = 0; b < 3; ++b)
                    for (int forward = 0; forward < 2; ++forward) {
                        const int step = forward ? 1 : -1;
                        const int shift = b == 0 ? step : 0;
                        if (b == 0)
                            other = row;
                        else
                            padded.read_row(a, y + (b == 1 ? step : 0), z + (b == 2 ? step : 0),
                                            other);
                        // F = I + ∂u/∂X, with u_a in mm: det is the same in any units.
                        const auto scale = float(step / (grid().spacing_mm[b] * kUnitsPerMm));
                        float* const to =
                            slopes[std::size_t(a)].of[std::size_t(2 * b + forward)].data();
                        const std::int32_t* const at = row.data() + 1;
                        const std::int32_t* const beside = other.data() + 1 + shift;
                        for (std::size_t i = 0; i < count; ++i)
                            to[i] = scale * float(beside[i] - at[i]);
                    }
            }
            smallest = std::min(smallest, double(smallest_in_row(slopes, count)));
        }
    return smallest;
}

}  // namespace pliant
