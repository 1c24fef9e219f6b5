// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nearest point of a triangle, and the feature of the triangle that contains it: dot products
// divide the plane into seven regions [Ericson2005, 5.1.5].

#pragma once

#include <pliant/core/vec.h>

#include <array>

namespace pliant::mesh {

struct NearestOnTriangle {
    Vec3d position;
    /// 0, 1, 2: that corner; 3, 4, 5: the edge from corner 0, 1, 2 to the next; 6: inside.
    int feature;
};

inline NearestOnTriangle nearest_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, 0};
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, 1};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / (d1 - d3)) * ab, 3};
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, 2};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / (d2 - d6)) * ac, 5};
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6)
        return {b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 4};
    const double sum = va + vb + vc;
    return {a + (vb / sum) * ab + (vc / sum) * ac, 6};
}

/// Barycentric weights of a point in the triangle's plane; they sum to 1.
inline std::array<double, 3> weights_on_triangle(Vec3d x, Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d normal = cross(b - a, c - a);
    const double scale = 1 / dot(normal, normal);
    const double u = scale * dot(cross(x - a, c - a), normal),
                 v = scale * dot(cross(b - a, x - a), normal);
    return {1 - u - v, u, v};
}

}  // namespace pliant::mesh
