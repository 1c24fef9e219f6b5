// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The fillet between tubes doesn't depend on their order: with m the least distance,
//   m − k/4 · Σ max(0, 1 − (dᵢ − m)/k)²   over the other tubes,
// which is the usual quadratic one for two. Within a tube the pieces are simply united, so a tube
// doesn't swell at its joints.

#include "volume/phantom_tubes.h"

#include "volume/phantom_noise.h"

namespace pliant::phantom {
namespace {

/// The nearest piece of a row.
struct Nearest {
    double distance_mm = 1e9;  ///< to the axis, less the radius
    double axis_mm = 0;        ///< to the axis
    double radius_mm = 1;
    double along_mm = 0;
    Vec3d out{0, 0, 0};   ///< from the axis to the point
    Vec3d axis{0, 0, 1};  ///< unit
};

Nearest nearest_piece(const Tube& tube, const std::vector<double>& starts, Vec3d p) {
    Nearest best;
    for (std::size_t n = 0; n + 1 < tube.points.size(); ++n) {
        const TubePoint& a = tube.points[n];
        const TubePoint& b = tube.points[n + 1];
        const Vec3d ab = b.x - a.x;
        const double length = starts[n + 1] - starts[n];
        const double t = clamp01(dot(p - a.x, ab) / (length * length));
        const Vec3d out = p - a.x - t * ab;
        const double radius = a.radius_mm + t * (b.radius_mm - a.radius_mm);
        const double axis = norm(out), distance = axis - radius;
        if (distance < best.distance_mm)
            best = {distance, axis, radius, starts[n] + t * length, out, (1 / length) * ab};
    }
    return best;
}

/// One tube's own surfaces at a point, the fillets left out.
TubePlace place_in(const Tube& tube, const Nearest& n, Vec3d p) {
    TubePlace place;
    const double out = std::max(n.axis_mm, 1e-6);
    place.back = dot(n.out, tube.back) / out;
    const double flat = tube.flatness * n.radius_mm * ramp(0.25, 0.95, place.back);
    place.smooth_mm = n.distance_mm + flat;
    place.outer_mm = place.smooth_mm - tube.wall_mm;
    place.lumen_mm = place.smooth_mm;
    if (tube.ring_mm <= 0) return place;
    const double uneven = 0.16 * value_noise(p * 0.11, 21);
    place.ring = wave(n.along_mm / tube.ring_mm + uneven);
    const double horseshoe = 1 - ramp(0.35, 0.75, place.back);
    const double ring = 0.5 * tube.ring_depth_mm * (1 + place.ring) * horseshoe;
    const Vec3d side = cross(tube.back, n.axis);
    const double fold = 0.45 * tube.ring_depth_mm * (1 - horseshoe) *
                        (1 + wave(dot(n.out, side) / (0.42 * n.radius_mm)));
    // Rings fade out in the middle of the lumen, where a direction has no meaning.
    place.lumen_mm += (ring + fold) * ramp(0.2, 0.6, n.axis_mm / n.radius_mm);
    return place;
}

/// The fillet's term for a tube that is `further_mm` away than the nearest.
double fillet(double further_mm, double k) {
    const double h = std::max(0.0, 1 - further_mm / k);
    return 0.25 * k * h * h;
}

}  // namespace

TubeTree::TubeTree(std::vector<Tube> tubes, double fillet_mm)
    : m_tubes(std::move(tubes)), m_fillet_mm(fillet_mm) {
    for (const Tube& tube : m_tubes) {
        std::vector<double> starts{0};
        for (std::size_t n = 0; n + 1 < tube.points.size(); ++n)
            starts.push_back(starts.back() + norm(tube.points[n + 1].x - tube.points[n].x));
        m_starts.push_back(std::move(starts));
    }
}

TubePlace TubeTree::find(Vec3d p) const {
    constexpr std::size_t kNear = 8;
    TubePlace near[kNear], best;
    std::size_t count = 0;
    for (std::size_t n = 0; n < m_tubes.size(); ++n) {
        const TubePlace place = place_in(m_tubes[n], nearest_piece(m_tubes[n], m_starts[n], p), p);
        const bool nearer = place.smooth_mm < best.smooth_mm;
        if (!nearer && place.smooth_mm > best.smooth_mm + 2 * m_fillet_mm) continue;
        if (nearer) best = place;
        std::size_t slot = count;
        if (count == kNear) {  // crowded: the farthest makes room
            slot = 0;
            for (std::size_t m = 1; m < kNear; ++m)
                if (near[m].smooth_mm > near[slot].smooth_mm) slot = m;
            if (near[slot].smooth_mm <= place.smooth_mm) continue;
        } else {
            ++count;
        }
        near[slot] = place;
    }
    TubePlace result = best;
    for (std::size_t m = 0; m < count; ++m) {
        result.lumen_mm = std::min(result.lumen_mm, near[m].lumen_mm);
        result.outer_mm = std::min(result.outer_mm, near[m].outer_mm);
    }
    double lumen = -fillet(0, m_fillet_mm), smooth = lumen,
           outer = lumen;  // less the nearest's own
    for (std::size_t m = 0; m < count; ++m) {
        lumen += fillet(near[m].lumen_mm - result.lumen_mm, m_fillet_mm);
        smooth += fillet(near[m].smooth_mm - result.smooth_mm, m_fillet_mm);
        outer += fillet(near[m].outer_mm - result.outer_mm, m_fillet_mm);
    }
    result.lumen_mm -= lumen;
    result.smooth_mm -= smooth;
    result.outer_mm -= outer;
    return result;
}

std::vector<TubePoint> smooth_row(const std::vector<TubePoint>& row, int pieces) {
    std::vector<TubePoint> out;
    const auto at = [&](std::ptrdiff_t n) {
        return row[std::size_t(std::clamp<std::ptrdiff_t>(n, 0, std::ptrdiff_t(row.size()) - 1))];
    };
    for (std::ptrdiff_t n = 0; n + 1 < std::ptrdiff_t(row.size()); ++n)
        for (int piece = 0; piece < pieces; ++piece) {
            const double t = double(piece) / pieces, t2 = t * t, t3 = t2 * t;
            const double w[4] = {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2),
                                 0.5 * (-3 * t3 + 4 * t2 + t), 0.5 * (t3 - t2)};
            TubePoint point{{0, 0, 0}, 0};
            for (int m = 0; m < 4; ++m) {
                const TubePoint q = at(n + m - 1);
                point.x = point.x + w[m] * q.x;
                point.radius_mm += w[m] * q.radius_mm;
            }
            out.push_back(point);
        }
    out.push_back(row.back());
    return out;
}

Field row_of_capsules(std::vector<TubePoint> row) {
    return [row = std::move(row)](Vec3d p) {
        double d = 1e9;
        for (std::size_t n = 0; n + 1 < row.size(); ++n)
            d = std::min(
                d, capsule(p, row[n].x, row[n + 1].x, row[n].radius_mm, row[n + 1].radius_mm));
        return d;
    };
}

}  // namespace pliant::phantom
