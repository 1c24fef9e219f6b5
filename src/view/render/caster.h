// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Casts one ray through the bricks: it traverses coarse bricks, fine bricks inside of those with
// the threshold, and cells inside of these. In cells whose corners straddle the threshold it
// computes the exact crossing.
//
// All three traversals compute the intersection of the ray and a plane by the same expression, so
// the parts of the ray join without gap or overlap. The ray's side of the threshold is carried
// along, through skipped bricks too, so no crossing is lost on a face between two cells.

#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "render/bricks.h"
#include "render/cubic.h"
#include "render/voxel_field.h"

namespace pliant::render {

/// A ray in voxel space; t counts millimetres in the world.
struct VoxelRay {
    Vec3d origin, direction, inverse;

    Vec3d at(double t) const { return origin + t * direction; }
    /// t at which the ray intersects the plane p[axis] = position; infinite if it is parallel.
    double meets(int axis, double position) const {
        if (direction[axis] == 0) return std::numeric_limits<double>::infinity();
        return (position - origin[axis]) * inverse[axis];
    }
};

inline VoxelRay make_voxel_ray(Vec3d origin, Vec3d direction) {
    return {origin, direction, {1 / direction.x, 1 / direction.y, 1 / direction.z}};
}

struct Span {
    double begin, end;
};

/// Part of the ray, t ≥ 0, between the outermost voxel centres.
inline std::optional<Span> clip(const VoxelRay& ray, Vec3i cells) {
    Span span{0, std::numeric_limits<double>::infinity()};
    for (int a = 0; a < 3; ++a) {
        if (ray.direction[a] == 0) {
            if (!(ray.origin[a] >= 0 && ray.origin[a] <= cells[a])) return std::nullopt;
            continue;
        }
        const double p = ray.meets(a, 0), q = ray.meets(a, cells[a]);
        span.begin = std::max(span.begin, std::min(p, q));
        span.end = std::min(span.end, std::max(p, q));
    }
    if (!(span.begin < span.end) || !std::isfinite(span.end)) return std::nullopt;
    return span;
}

/// Steps from block to block of `kSize` cells along a ray, inside a box of blocks.
template <int kSize>
class Walk {
  public:
    Walk(const VoxelRay& ray, double t, Vec3i begin, Vec3i end) : m_ray(ray) {
        const Vec3d p = ray.at(t);
        for (int a = 0; a < 3; ++a) {
            const auto i = std::size_t(a);
            const int block = int(std::floor(p[a] * (1.0 / kSize)));
            m_block[i] = std::clamp(block, begin[a], end[a] - 1);
            m_step[i] = ray.direction[a] < 0 ? -1 : 1;
            m_stop[i] = ray.direction[a] < 0 ? begin[a] - 1 : end[a];
            m_exit[i] = exit_of(a);
        }
    }

    Vec3i block() const { return {m_block[0], m_block[1], m_block[2]}; }
    /// t at which the ray leaves the block.
    double exit() const { return std::min({m_exit[0], m_exit[1], m_exit[2]}); }
    /// Advances to the next block. @returns false if it is outside of the box
    bool advance() {
        const int axis = m_exit[0] <= m_exit[1] ? (m_exit[0] <= m_exit[2] ? 0 : 2)
                                                : (m_exit[1] <= m_exit[2] ? 1 : 2);
        const auto i = std::size_t(axis);
        m_block[i] += m_step[i];
        if (m_block[i] == m_stop[i]) return false;
        m_exit[i] = exit_of(axis);
        return true;
    }

  private:
    double exit_of(int axis) const {
        const auto i = std::size_t(axis);
        return m_ray.meets(axis, double(kSize) * (m_block[i] + (m_step[i] > 0 ? 1 : 0)));
    }

    const VoxelRay& m_ray;
    std::array<int, 3> m_block, m_step, m_stop;
    std::array<double, 3> m_exit;
};

/// Cubic of a cell's values minus iso between two of its points, s = 0…1.
inline Cubic cubic_between(const CellCorners& corners, double iso, Vec3d a, Vec3d b) {
    const double* v = corners.v;
    const Vec3d d = b - a;
    const double xy = v[3] - v[2] - v[1] + v[0], yz = v[6] - v[4] - v[2] + v[0];
    const double zx = v[5] - v[4] - v[1] + v[0];
    const double xyz = (v[7] - v[6] - v[5] + v[4]) - xy;
    const double fx = v[1] - v[0] + xy * a.y + (zx + xyz * a.y) * a.z;
    const double fy = v[2] - v[0] + xy * a.x + (yz + xyz * a.x) * a.z;
    const double fz = v[4] - v[0] + zx * a.x + (yz + xyz * a.x) * a.y;
    return {
        interpolate(corners, a) - iso, fx * d.x + fy * d.y + fz * d.z,
        (xy + xyz * a.z) * d.x * d.y + (yz + xyz * a.x) * d.y * d.z + (zx + xyz * a.y) * d.z * d.x,
        xyz * d.x * d.y * d.z};
}

template <class T>
class Cast {
  public:
    /// @param rising  searches the crossing from below iso to ≥ iso, otherwise the reverse
    Cast(const VoxelField<T>& field, const Bricks<T>& bricks, const VoxelRay& ray, double iso,
         bool rising)
        : m_field(field), m_bricks(bricks), m_ray(ray), m_iso(iso), m_rising(rising) {}

    /// @returns t of the first crossing
    std::optional<double> first_hit() {
        const auto span = clip(m_ray, m_bricks.cells);
        if (!span) return std::nullopt;
        m_above = m_field.sample(m_ray.at(span->begin)) >= m_iso;
        Walk<kCoarseCells> walk(m_ray, span->begin, {0, 0, 0}, m_bricks.coarse.size);
        double t = span->begin;
        do {
            const double exit = std::min(walk.exit(), span->end);
            const Vec3i b = walk.block();
            if (enter(m_bricks.coarse.at(b), t, [&] { return through_fine(b, t, exit); }))
                return m_hit;
            t = exit;
        } while (t < span->end && walk.advance());
        return std::nullopt;
    }

  private:
    static constexpr int kFinePerCoarse = kCoarseCells / kFineCells;

    /// Skips a brick on one side of iso, otherwise enters it. @returns whether there was a hit
    template <class Inside>
    bool enter(const Range<T>& range, double t, const Inside& inside) {
        const bool above = double(range.min) >= m_iso;
        if (!above && double(range.max) >= m_iso) return inside();
        const bool turned = above != m_above && above == m_rising;
        m_above = above;
        m_hit = t;
        return turned;
    }

    static Vec3i block_end(Vec3i block, int step, Vec3i limit) {
        return {std::min((block.x + 1) * step, limit.x), std::min((block.y + 1) * step, limit.y),
                std::min((block.z + 1) * step, limit.z)};
    }

    bool through_fine(Vec3i coarse, double t, double t_end) {
        const Vec3i begin = coarse * kFinePerCoarse;
        Walk<kFineCells> walk(m_ray, t, begin,
                              block_end(coarse, kFinePerCoarse, m_bricks.fine.size));
        do {
            const double exit = std::min(walk.exit(), t_end);
            const Vec3i b = walk.block();
            if (enter(m_bricks.fine.at(b), t, [&] { return through_cells(b, t, exit); }))
                return true;
            t = exit;
        } while (t < t_end && walk.advance());
        return false;
    }

    bool through_cells(Vec3i fine, double t, double t_end) {
        Walk<1> walk(m_ray, t, fine * kFineCells, block_end(fine, kFineCells, m_bricks.cells));
        do {
            const double exit = std::min(walk.exit(), t_end);
            if (in_cell(walk.block(), t, exit)) return true;
            t = exit;
        } while (t < t_end && walk.advance());
        return false;
    }

    Range<T> range_of_cell(Vec3i cell) const {
        const T* p = m_field.at(cell);
        const std::ptrdiff_t row = m_field.row();
        const T* q = p + m_field.slice();
        const auto [low, high] =
            std::minmax({p[0], p[1], p[row], p[row + 1], q[0], q[1], q[row], q[row + 1]});
        return {low, high};
    }

    bool in_cell(Vec3i cell, double t, double t_end) {
        return enter(range_of_cell(cell), t, [&] {
            const Vec3d corner{double(cell.x), double(cell.y), double(cell.z)};
            const auto local = [&](double at) {
                const Vec3d p = m_ray.at(at) - corner;
                return Vec3d{std::clamp(p.x, 0.0, 1.0), std::clamp(p.y, 0.0, 1.0),
                             std::clamp(p.z, 0.0, 1.0)};
            };
            const Cubic cubic = cubic_between(m_field.corners(cell), m_iso, local(t), local(t_end));
            const auto s = first_turn(cubic, m_rising, m_above);
            if (s) m_hit = t + *s * (t_end - t);
            return s.has_value();
        });
    }

    const VoxelField<T>& m_field;
    const Bricks<T>& m_bricks;
    const VoxelRay& m_ray;
    double m_iso;
    bool m_rising;
    bool m_above = false;
    double m_hit = 0;
};

}  // namespace pliant::render
