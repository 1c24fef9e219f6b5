// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shapes of phantoms as signed distances [mm]: negative inside, positive outside, with a slope of
// at most 1 mm per mm unless noted. So |distance| > r means that no surface is nearer than r.
// Ellipsoids and similar shapes have smaller slopes in places; the sampler measures the slope where
// it matters.
//
// The shapes use only +, −, ×, ÷, square root and floor, so the results are identical on every
// machine.

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace pliant::phantom {

/// A number at each world point [mm, LPS]: a signed distance [mm], or a value [HU].
using ScalarField = std::function<double(Vec3d)>;

inline double clamp01(double t) {
    return std::clamp(t, 0.0, 1.0);
}
/// Smooth step: 0 up to a, 1 from b on; b may be less than a.
inline double ramp(double a, double b, double t) {
    const double u = clamp01((t - a) / (b - a));
    return u * u * (3 - 2 * u);
}
/// Approximation of a sine with period 1 (within 0.2 %) by multiplications.
inline double wave(double t) {
    const double x = t - std::floor(t + 0.5);
    const double y = 8 * x * (1 - 2 * std::abs(x));
    return y * (0.775 + 0.225 * std::abs(y));
}
/// A bump: 1 at 0, ½ at ±width, decaying to zero.
inline double bump(double t, double width) {
    const double u = t / width;
    return 1 / (1 + u * u);
}

inline Vec3d scaled(Vec3d p, Vec3d by) {
    return {p.x * by.x, p.y * by.y, p.z * by.z};
}
inline Vec3d mirrored_x(Vec3d p) {
    return {std::abs(p.x), p.y, p.z};
}

inline double sphere(Vec3d p, Vec3d centre, double radius) {
    return norm(p - centre) - radius;
}
inline double ellipsoid(Vec3d p, Vec3d centre, Vec3d radii) {
    const Vec3d q = p - centre;
    const double least = std::min({radii.x, radii.y, radii.z});
    return (norm({q.x / radii.x, q.y / radii.y, q.z / radii.z}) - 1) * least;
}
inline double box(Vec3d p, Vec3d centre, Vec3d half, double rounding = 0) {
    const Vec3d q = p - centre;
    const Vec3d d{std::abs(q.x) - half.x + rounding, std::abs(q.y) - half.y + rounding,
                  std::abs(q.z) - half.z + rounding};
    const Vec3d outside{std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)};
    return norm(outside) + std::min(std::max({d.x, d.y, d.z}), 0.0) - rounding;
}
/// Capsule a…b with radius ra at a and rb at b.
inline double capsule(Vec3d p, Vec3d a, Vec3d b, double ra, double rb) {
    const Vec3d ab = b - a;
    const double t = clamp01(dot(p - a, ab) / dot(ab, ab));
    return norm(p - a - t * ab) - (ra + t * (rb - ra));
}
/// Infinite cylinder along z with a stadium as its section: a segment of half-length half_x and a
/// radius.
inline double stadium(double x, double y, double half_x, double radius) {
    const double qx = std::max(std::abs(x) - half_x, 0.0);
    return std::sqrt(qx * qx + y * y) - radius;
}
/// Torus in the plane z = centre.z.
inline double torus(Vec3d p, Vec3d centre, double ring_radius, double radius) {
    const Vec3d q = p - centre;
    const double out = std::sqrt(q.x * q.x + q.y * q.y) - ring_radius;
    return std::sqrt(out * out + q.z * q.z) - radius;
}

/// Union with a fillet of about k [mm].
inline double smooth_union(double a, double b, double k) {
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * k / 4;
}
/// Intersection with a rounded edge of about k [mm].
inline double smooth_intersection(double a, double b, double k) {
    return -smooth_union(-a, -b, k);
}
/// Difference: a without b.
inline double cut(double a, double b) {
    return std::max(a, -b);
}

}  // namespace pliant::phantom
