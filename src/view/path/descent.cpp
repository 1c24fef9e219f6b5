// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "path/descent.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/voxel_field.h"

namespace pliant::render {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kStepVoxels = 0.5;  // of the smallest spacing
constexpr int kMaxHalvings = 6;      // of a line's piece that may touch the wall
constexpr double kOnPlane = 1e-9;    // tolerance of points on a plane of voxels
constexpr std::size_t kMaxPoints = 2'000'000;

Vec3d to_double(Vec3i v) {
    return {double(v.x), double(v.y), double(v.z)};
}
Vec3i cell_of(Vec3d p) {
    return {int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
}
Vec3i corner(Vec3i cell, int n) {
    return cell + Vec3i{n & 1, n >> 1 & 1, n >> 2 & 1};
}

/// Bernstein coefficients of the field along a line in one cell; they bound its values.
struct BernsteinCubic {
    double b[4];
};

/// Whether a cubic is in the lumen everywhere; false if undecided.
bool stays_inside(const BernsteinCubic& c, const LumenSide& lumen, int halvings) {
    if (!lumen.contains(c.b[0]) || !lumen.contains(c.b[3])) return false;
    if (lumen.contains(c.b[1]) && lumen.contains(c.b[2])) return true;
    if (halvings == 0) return false;
    const double p = 0.5 * (c.b[0] + c.b[1]), q = 0.5 * (c.b[1] + c.b[2]),
                 r = 0.5 * (c.b[2] + c.b[3]);
    const double pq = 0.5 * (p + q), qr = 0.5 * (q + r), middle = 0.5 * (pq + qr);
    return stays_inside({{c.b[0], p, pq, middle}}, lumen, halvings - 1) &&
           stays_inside({{middle, qr, r, c.b[3]}}, lumen, halvings - 1);
}

/// Descends the arrival times, interpolated continuously.
class Descent {
  public:
    explicit Descent(const LumenTiles& tiles)
        : m_tiles(tiles), m_spacing(tiles.volume().grid.spacing_mm) {}

    std::vector<Vec3d> run(Vec3d from, Vec3d to) {
        m_points.push_back(from);
        m_ends = clear_corners(m_tiles, to);
        while (m_points.size() < kMaxPoints) {
            if (arrives(to)) return std::move(m_points);
            if (!step_down() && !step_to_voxel()) break;
        }
        return {};
    }

  private:
    /// Whether the point is near enough for a final straight line.
    bool arrives(Vec3d to) {
        const Vec3d p = m_points.back(), d = to - p;
        const bool is_near = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <= 1;
        const bool at_end =
            std::any_of(m_ends.begin(), m_ends.end(), [&](Vec3i e) { return to_double(e) == p; });
        if (!at_end && !(is_near && is_clear(m_tiles, p, to))) return false;
        if (norm(d) > 0) m_points.push_back(to);
        return true;
    }

    /// Makes a midpoint step against the gradient.
    bool step_down() {
        if (m_voxels_only) return false;
        const Vec3d p = m_points.back();
        const double step = kStepVoxels * std::min({m_spacing.x, m_spacing.y, m_spacing.z});
        const auto half = along(p, p, 0.5 * step);
        const auto next = half ? along(p, *half, step) : std::nullopt;
        if (!next || !(arrival(*next) < arrival(p)) || !is_clear(m_tiles, p, *next)) return false;
        m_points.push_back(*next);
        return true;
    }

    /// @returns the position a step from p, against the gradient at another position
    std::optional<Vec3d> along(Vec3d p, Vec3d at, double step_mm) const {
        const Vec3d g = gradient(at);
        const double length = norm(g);
        if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
        Vec3d next;
        for (int a = 0; a < 3; ++a) {
            next[a] = p[a] - step_mm * g[a] / (length * m_spacing[a]);
            next[a] = std::clamp(next[a], 0.0, double(m_tiles.volume().grid.size[a] - 1));
        }
        return next;
    }

    /// Moves to the nearby voxel with the earliest arrival. If that is not a descent, only voxel
    /// steps follow, so that the descent terminates.
    bool step_to_voxel() {
        const Vec3d p = m_points.back();
        const Vec3i here = cell_of(p);
        std::vector<Vec3i> candidates;
        if (to_double(here) == p) {
            for (int side = 0; side < 6; ++side) {
                candidates.push_back(here);
                candidates.back()[side / 2] += side % 2 ? 1 : -1;
            }
        } else {
            candidates = clear_corners(m_tiles, p);
        }
        const double now = arrival(p);
        double least = kNever;
        Vec3i best{};
        for (const Vec3i& c : candidates) {
            const double t = m_tiles.arrival(c);
            if (!(t < least)) continue;
            least = t;
            best = c;
        }
        if (std::isinf(least)) return false;
        if (!(least < now)) {
            if (m_voxels_only && to_double(here) == p) return false;
            m_voxels_only = true;
        }
        m_points.push_back(to_double(best));
        return true;
    }

    /// Trilinear interpolation without corners that the front has not reached.
    template <class Value>
    auto blend(Vec3d p, const Value& value) const {
        const Vec3i cell = cell_of(p);
        const Vec3d f = p - to_double(cell);
        double weights = 0;
        decltype(value(cell)) sum{};
        for (int n = 0; n < 8; ++n) {
            const double weight =
                (n & 1 ? f.x : 1 - f.x) * (n & 2 ? f.y : 1 - f.y) * (n & 4 ? f.z : 1 - f.z);
            if (!(weight > 0)) continue;
            const Vec3i q = corner(cell, n);
            if (std::isinf(m_tiles.arrival(q))) continue;
            sum = sum + weight * value(q);
            weights += weight;
        }
        return (1 / weights) * sum;
    }
    double arrival(Vec3d p) const {
        return blend(p, [&](Vec3i q) { return m_tiles.arrival(q); });
    }
    Vec3d gradient(Vec3d p) const {
        return blend(p, [&](Vec3i q) { return voxel_gradient(q); });
    }

    /// Central differences, one-sided beside the wall [1/mm].
    Vec3d voxel_gradient(Vec3i q) const {
        const double here = m_tiles.arrival(q);
        Vec3d g{};
        for (int a = 0; a < 3; ++a) {
            Vec3i before = q, after = q;
            --before[a];
            ++after[a];
            const double b = m_tiles.arrival(before), c = m_tiles.arrival(after);
            const bool has_b = std::isfinite(b), has_c = std::isfinite(c);
            if (has_b && has_c)
                g[a] = (c - b) / (2 * m_spacing[a]);
            else if (has_b || has_c)
                g[a] = (has_c ? c - here : here - b) / m_spacing[a];
        }
        return g;
    }

    const LumenTiles& m_tiles;
    Vec3d m_spacing;
    std::vector<Vec3i> m_ends;
    std::vector<Vec3d> m_points;
    bool m_voxels_only = false;
};

}  // namespace

bool is_clear(const LumenTiles& tiles, Vec3d a, Vec3d b) {
    const LumenSide& lumen = tiles.lumen();
    return with_field(tiles.volume(), [&](const auto& field) {
        const auto value = [&](double t) { return field.sample(a + t * (b - a)); };
        if (!lumen.contains(value(0)) || !lumen.contains(value(1))) return false;
        // One piece for each cell that the line crosses.
        for (double begin = 0; begin < 1;) {
            double end = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const double d = b[axis] - a[axis], here = a[axis] + begin * d;
                if (d == 0) continue;
                const double next =
                    d > 0 ? std::floor(here + kOnPlane) + 1 : std::ceil(here - kOnPlane) - 1;
                end = std::min(end, (next - a[axis]) / d);
            }
            const double third = (end - begin) / 3;
            const double p = value(begin), q = value(begin + third), r = value(end - third),
                         s = value(end);
            const BernsteinCubic cubic{{p, (-5 * p + 18 * q - 9 * r + 2 * s) / 6,
                                        (2 * p - 9 * q + 18 * r - 5 * s) / 6, s}};
            if (!stays_inside(cubic, lumen, kMaxHalvings)) return false;
            begin = end;
        }
        return true;
    });
}

std::vector<Vec3i> clear_corners(const LumenTiles& tiles, Vec3d position) {
    std::vector<Vec3i> corners;
    for (int n = 0; n < 8; ++n) {
        const Vec3i voxel = corner(cell_of(position), n);
        const Vec3d d = to_double(voxel) - position;
        if (std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) < 1 && tiles.is_inside(voxel) &&
            is_clear(tiles, position, to_double(voxel)))
            corners.push_back(voxel);
    }
    return corners;
}

std::vector<Vec3d> descend(const LumenTiles& tiles, Vec3d from, Vec3d to) {
    return Descent(tiles).run(from, to);
}

void smooth_inside(const LumenTiles& tiles, int rounds, std::vector<Vec3d>& points) {
    for (int round = 0; round < rounds; ++round)
        for (std::size_t n = 1; n + 1 < points.size(); ++n) {
            const Vec3d middle = 0.5 * (points[n - 1] + points[n + 1]);
            const Vec3d moved = 0.5 * (points[n] + middle);
            if (is_clear(tiles, points[n - 1], moved) && is_clear(tiles, moved, points[n + 1]))
                points[n] = moved;
        }
}

}  // namespace pliant::render
