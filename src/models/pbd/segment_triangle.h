// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nearest points of a segment and a triangle. Unless they intersect, one of the points is an end of
// the segment or lies on an edge of the triangle [Ericson2005, 5.1.9, 5.3.6].

#pragma once

#include <algorithm>

#include "mesh/triangle_distance.h"

namespace pliant::pbd {

struct NearestPair {
    double along;  ///< 0…1 from the segment's first end
    Vec3d on_segment, on_triangle;
    int feature;  ///< feature of the triangle, as in mesh::NearestOnTriangle
};

inline double distance2(const NearestPair& pair) {
    const Vec3d d = pair.on_segment - pair.on_triangle;
    return dot(d, d);
}

/// Nearest points of the segments p…p + u and q…q + v, 0…1 along each; u and v may be zero.
struct AlongBoth {
    double s, t;
};
inline AlongBoth nearest_of_segments(Vec3d p, Vec3d u, Vec3d q, Vec3d v) {
    const auto clamped = [](double x) { return std::clamp(x, 0.0, 1.0); };
    const Vec3d r = p - q;
    const double a = dot(u, u), e = dot(v, v), f = dot(v, r), c = dot(u, r), b = dot(u, v);
    if (!(a > 0)) return {0, e > 0 ? clamped(f / e) : 0};
    if (!(e > 0)) return {clamped(-c / a), 0};
    const double denominator = a * e - b * b;
    double s = denominator > 1e-14 * a * e ? clamped((b * f - c * e) / denominator) : 0;
    double t = (b * s + f) / e;
    if (t < 0) {
        t = 0;
        s = clamped(-c / a);
    } else if (t > 1) {
        t = 1;
        s = clamped((b - c) / a);
    }
    return {s, t};
}

/// Whether the segment intersects the triangle, and where.
inline bool goes_through(Vec3d p, Vec3d u, Vec3d a, Vec3d b, Vec3d c, double& along) {
    const Vec3d normal = cross(b - a, c - a);
    const double height = dot(p - a, normal), change = dot(u, normal);
    if (change == 0 || (height > 0) == (height + change > 0)) return false;
    along = std::clamp(-height / change, 0.0, 1.0);
    const Vec3d x = p + along * u;
    return dot(cross(b - a, x - a), normal) >= 0 && dot(cross(c - b, x - b), normal) >= 0 &&
           dot(cross(a - c, x - c), normal) >= 0;
}

inline NearestPair nearest_pair(Vec3d p, Vec3d end, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d u = end - p;
    double through = 0;
    if (goes_through(p, u, a, b, c, through)) {
        const Vec3d x = p + through * u;
        return {through, x, x, 6};
    }
    const auto first = mesh::nearest_on_triangle(p, a, b, c);
    NearestPair best{0, p, first.position, first.feature};
    const auto take = [&](const NearestPair& pair) {
        if (distance2(pair) < distance2(best)) best = pair;
    };
    const auto last = mesh::nearest_on_triangle(end, a, b, c);
    take({1, end, last.position, last.feature});
    const Vec3d corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        const Vec3d from = corners[k], edge = corners[(k + 1) % 3] - from;
        const auto [s, t] = nearest_of_segments(p, u, from, edge);
        const int feature = t == 0 ? k : t == 1 ? (k + 1) % 3 : 3 + k;
        take({s, p + s * u, from + t * edge, feature});
    }
    return best;
}

}  // namespace pliant::pbd
