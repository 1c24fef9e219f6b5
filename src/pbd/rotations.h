// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What rods and wires need of rotations and 3 × 3 matrices. A small turn δ is applied from the
// left, q ← exp(δ) q, so derivatives with respect to turns are taken at δ = 0.

#pragma once

#include <pliant/pbd_rod.h>

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

/// a × v as a matrix of v.
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
/// m diag(d) mᵀ
inline Mat3d sandwich(const Mat3d& m, Vec3d d) {
    return m * transposed({{d.x * m.columns[0], d.y * m.columns[1], d.z * m.columns[2]}});
}

/// ∂ log(exp(δ) exp(r)) / ∂δ at δ = 0.
inline Mat3d log_derivative(Vec3d r) {
    const double angle = norm(r), a2 = angle * angle;
    const double second = angle < 1e-2
                              ? 1.0 / 12 + a2 / 720
                              : 1 / a2 - (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
    const Mat3d c = crossing(r);
    return sum(sum(kIdentity3, scaled(-0.5, c)), scaled(second, c * c));
}

}  // namespace pliant::pbd
