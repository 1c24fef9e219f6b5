// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The trilinear map of one deformed cell, and its inverse by Newton's method.

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace pliant {

class TrilinearCell {
  public:
    /// @param corners  numbered as in cell_block.h
    explicit TrilinearCell(const std::array<Vec3d, 8>& p)
        : m_0(p[0]),
          m_x(p[1] - p[0]),
          m_y(p[2] - p[0]),
          m_z(p[4] - p[0]),
          m_xy(p[3] - p[1] - p[2] + p[0]),
          m_xz(p[5] - p[1] - p[4] + p[0]),
          m_yz(p[6] - p[2] - p[4] + p[0]),
          m_xyz(p[7] - p[6] - p[5] - p[3] + p[1] + p[2] + p[4] - p[0]) {
        const auto square = [](Vec3d v) { return dot(v, v); };
        m_is_affine = square(m_xy) + square(m_xz) + square(m_yz) + square(m_xyz) < kBent * kBent;
    }

    Vec3d at(Vec3d t) const {
        return m_0 + t.x * m_x + t.y * m_y + t.z * m_z + t.x * t.y * m_xy + t.x * t.z * m_xz +
               t.y * t.z * m_yz + t.x * t.y * t.z * m_xyz;
    }

    /// Cell coordinates of a point, each in 0…1.
    /// @param outside  a point this far outside counts as on the face [cell coordinates]
    /// @returns nothing if the point lies farther outside, or the cell is so steep or folded that
    ///          Newton's method from its middle doesn't converge in kMaxSteps
    std::optional<Vec3d> locate(Vec3d point, double outside = kOutside) const {
        Vec3d t{0.5, 0.5, 0.5};
        if (!solve(point, t)) return std::nullopt;
        return inside(t, outside);
    }
    /// As locate(), for steep cells: where Newton's method is lost, it begins again at each corner.
    std::optional<Vec3d> locate_from_corners(Vec3d point, double outside) const {
        Vec3d t{0.5, 0.5, 0.5};
        bool is_solved = solve(point, t);
        for (int c = 0; !is_solved && c < 8; ++c) {
            t = {double(c & 1), double(c >> 1 & 1), double(c >> 2)};
            is_solved = solve(point, t);
        }
        return is_solved ? inside(t, outside) : std::nullopt;
    }

  private:
    static constexpr double kBent = 1e-9;  ///< deviation from a parallelepiped [voxels]
    static constexpr int kMaxSteps = 16;
    static constexpr double kSettled = 1e-9;  ///< cell coordinates
    static constexpr double kOutside = 1e-7;  ///< cell coordinates
    static constexpr double kFarAway = 8;     ///< cell coordinates
    static constexpr double kFlat = 1e-9;     ///< volume of the cell [voxels]

    /// A step of Newton's method towards a point. @param[out] move  of t
    /// @returns false if the cell is flat at t
    bool newton_move(Vec3d point, Vec3d t, Vec3d& move) const {
        const Vec3d miss = point - at(t);
        const Vec3d dx = m_x + t.y * m_xy + t.z * m_xz + t.y * t.z * m_xyz;
        const Vec3d dy = m_y + t.x * m_xy + t.z * m_yz + t.x * t.z * m_xyz;
        const Vec3d dz = m_z + t.x * m_xz + t.y * m_yz + t.x * t.y * m_xyz;
        const Vec3d across = cross(dy, dz);
        const double det = dot(dx, across);
        if (!(det > kFlat)) return false;
        const Vec3d turned = cross(dx, miss);
        const double scale = 1 / det;
        move = {scale * dot(miss, across), scale * dot(dz, turned), -scale * dot(dy, turned)};
        return true;
    }

    /// Newton's method. @param[in,out] t  first guess. @returns whether it has settled
    bool solve(Vec3d point, Vec3d& t) const {
        for (int step = 0; step < kMaxSteps; ++step) {
            Vec3d move;
            if (!newton_move(point, t, move)) return false;
            t = t + move;
            // In a parallelepiped the first step is exact; elsewhere steps shrink quadratically.
            if (m_is_affine || dot(move, move) < kSettled * kSettled) return true;
            if (dot(t, t) > kFarAway * kFarAway) return false;
        }
        return false;
    }

    static std::optional<Vec3d> inside(Vec3d t, double outside) {
        for (int a = 0; a < 3; ++a) {
            if (t[a] < -outside || t[a] > 1 + outside) return std::nullopt;
            t[a] = t[a] < 0 ? 0 : t[a] > 1 ? 1 : t[a];
        }
        return t;
    }

    Vec3d m_0, m_x, m_y, m_z, m_xy, m_xz, m_yz, m_xyz;
    bool m_is_affine;
};

/// Three pairs of planes, parallel to a cell's faces on average, with the whole cell between them:
/// a trilinear cell lies in the convex hull of its corners. They reject most points of the box
/// around a slanted or flattened cell.
class CellPlanes {
  public:
    explicit CellPlanes(const std::array<Vec3d, 8>& p) {
        const auto mean_edge = [&](std::size_t step) {
            Vec3d sum{0, 0, 0};
            for (std::size_t c = 0; c < 8; ++c) sum = c & step ? sum + p[c] : sum - p[c];
            return sum;
        };
        const Vec3d x = mean_edge(1), y = mean_edge(2), z = mean_edge(4);
        m_normal = {cross(y, z), cross(z, x), cross(x, y)};
        for (std::size_t k = 0; k < 3; ++k) {
            m_low[k] = m_high[k] = dot(m_normal[k], p[0]);
            for (const Vec3d& corner : p) {
                m_low[k] = std::min(m_low[k], dot(m_normal[k], corner));
                m_high[k] = std::max(m_high[k], dot(m_normal[k], corner));
            }
            const double slack = kBeside * std::sqrt(dot(m_normal[k], m_normal[k]));
            m_low[k] -= slack, m_high[k] += slack;
        }
    }

    /// Whether a point may lie in the cell.
    bool may_hold(Vec3d point) const {
        for (std::size_t k = 0; k < 3; ++k) {
            const double position = dot(m_normal[k], point);
            if (position < m_low[k] || position > m_high[k]) return false;
        }
        return true;
    }

  private:
    static constexpr double kBeside = 1e-5;  ///< larger than the tolerance of any inverse [voxels]

    std::array<Vec3d, 3> m_normal;
    std::array<double, 3> m_low, m_high;
};

/// Trilinear interpolation of values at the corners.
inline double interpolate(const std::array<double, 8>& v, Vec3d t) {
    const auto mix = [](double a, double b, double s) { return (1 - s) * a + s * b; };
    const double y0 = mix(mix(v[0], v[1], t.x), mix(v[2], v[3], t.x), t.y);
    const double y1 = mix(mix(v[4], v[5], t.x), mix(v[6], v[7], t.x), t.y);
    return mix(y0, y1, t.z);
}

}  // namespace pliant
