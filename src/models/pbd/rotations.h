// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rotations and 3 × 3 matrices for rods and wires. A small rotation δ is applied from the left, q ←
// exp(δ) q, so derivatives with respect to rotations are taken at δ = 0.

#pragma once

#include <pliant/models/pbd.h>

#include <cmath>

namespace pliant::pbd {

inline Rotation inverse_of(Rotation q) {
    return {q.w, -q.x, -q.y, -q.z};
}
inline Rotation unit(Rotation q) {
    const double s = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {s * q.w, s * q.x, s * q.y, s * q.z};
}
inline Mat3d matrix_of(Rotation q) {
    return {{rotated(q, {1, 0, 0}), rotated(q, {0, 1, 0}), rotated(q, {0, 0, 1})}};
}

/// Matrix of v ↦ a × v.
inline Mat3d crossing(Vec3d a) {
    return {{{0, a.z, -a.y}, {-a.z, 0, a.x}, {a.y, -a.x, 0}}};
}
inline Mat3d scaled(double s, const Mat3d& m) {
    return {{s * m.columns[0], s * m.columns[1], s * m.columns[2]}};
}
inline Mat3d sum(const Mat3d& a, const Mat3d& b) {
    return {
        {a.columns[0] + b.columns[0], a.columns[1] + b.columns[1], a.columns[2] + b.columns[2]}};
}
inline Mat3d outer(Vec3d a, Vec3d b) {
    return {{b.x * a, b.y * a, b.z * a}};
}

/// Limit of the squared sine of half a rotation up to which the series are as exact as the
/// functions: rotations of 0.2, typical of joints and steps [rad²].
inline constexpr double kSmallTurn2 = 0.01;

/// rotation_by, with a series for small rotations.
inline Rotation turn_by(Vec3d vector) {
    const double h2 = 0.25 * dot(vector, vector);
    if (h2 > kSmallTurn2) return rotation_by(vector);
    const double s =
        0.5 * (1 - h2 / 6 * (1 - h2 / 20 * (1 - h2 / 42 * (1 - h2 / 72 * (1 - h2 / 110)))));
    const double w = 1 - h2 / 2 * (1 - h2 / 12 * (1 - h2 / 30 * (1 - h2 / 56 * (1 - h2 / 90))));
    return {w, s * vector.x, s * vector.y, s * vector.z};
}
/// rotation_vector, with a series for small rotations: 2 arcsin(s)/s. @pre unit length
inline Vec3d turn_of(Rotation q) {
    const Vec3d u{q.x, q.y, q.z};
    const double s2 = dot(u, u);
    if (s2 > kSmallTurn2) return rotation_vector(q);
    constexpr double k[] = {1.0,         1.0 / 6,     3.0 / 40,      5.0 / 112,
                            35.0 / 1152, 63.0 / 2816, 231.0 / 13312, 143.0 / 10240};
    double half = k[7];
    for (int n = 6; n >= 0; --n) half = k[n] + s2 * half;
    return std::copysign(2 * half, q.w) * u;
}

/// (1 − (a/2) cot(a/2))/a² as a function of the angle's square.
inline double log_curvature(double a2) {
    const double x2 = 0.25 * a2;
    if (x2 > kSmallTurn2) {
        const double angle = std::sqrt(a2);
        return 1 / a2 - (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
    }
    constexpr double k[] = {1.0 / 12,    1.0 / 180,    1.0 / 1890,
                            1.0 / 18900, 2.0 / 374220, 1382.0 / 2554051500};
    double curvature = k[5];
    for (int n = 4; n >= 0; --n) curvature = k[n] + x2 * curvature;
    return curvature;
}
/// ∂ log(exp(δ) exp(r)) / ∂δ at δ = 0.
inline Mat3d log_derivative(Vec3d r) {
    const Mat3d c = crossing(r);
    return sum(sum(kIdentity3, scaled(-0.5, c)), scaled(log_curvature(dot(r, r)), c * c));
}
/// Product of the transpose with v: v + ½ r × v + s r × (r × v).
inline Vec3d log_transposed(Vec3d r, double curvature, Vec3d v) {
    const Vec3d rv = cross(r, v);
    return v + 0.5 * rv + curvature * cross(r, rv);
}

}  // namespace pliant::pbd
