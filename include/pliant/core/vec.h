// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small vectors and 3×3 matrices: aggregates without constructors.

#pragma once

#include <cmath>
#include <cstdint>

#pragma GCC visibility push(default)
namespace pliant {

template <class T>
struct Vec3 {
    T x, y, z;

    constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr const T& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

using Vec3d = Vec3<double>;
using Vec3f = Vec3<float>;
using Vec3i = Vec3<std::int32_t>;

template <class T>
constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a) {
    return {-a.x, -a.y, -a.z};
}
template <class T>
constexpr Vec3<T> operator*(T s, Vec3<T> a) {
    return {s * a.x, s * a.y, s * a.z};
}
template <class T>
constexpr Vec3<T> operator*(Vec3<T> a, T s) {
    return s * a;
}
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec3d a) {
    return std::sqrt(dot(a, a));
}
/// @pre norm(a) > 0
inline Vec3d normalized(Vec3d a) {
    return (1.0 / norm(a)) * a;
}
inline bool is_finite(Vec3d a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Matrix by columns: columns[c] is the image of the c-th unit vector.
struct Mat3d {
    Vec3d columns[3];

    friend constexpr bool operator==(const Mat3d&, const Mat3d&) = default;
};

inline constexpr Mat3d kIdentity3 = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

constexpr Vec3d operator*(const Mat3d& m, Vec3d v) {
    return v.x * m.columns[0] + v.y * m.columns[1] + v.z * m.columns[2];
}
constexpr Mat3d operator*(const Mat3d& a, const Mat3d& b) {
    return {{a * b.columns[0], a * b.columns[1], a * b.columns[2]}};
}
constexpr double determinant(const Mat3d& m) {
    return dot(m.columns[0], cross(m.columns[1], m.columns[2]));
}
constexpr Mat3d transposed(const Mat3d& m) {
    const auto& c = m.columns;
    return {{{c[0].x, c[1].x, c[2].x}, {c[0].y, c[1].y, c[2].y}, {c[0].z, c[1].z, c[2].z}}};
}
/// @pre determinant(m) != 0
constexpr Mat3d inverse(const Mat3d& m) {
    const auto& c = m.columns;
    const double s = 1.0 / determinant(m);
    return transposed({{s * cross(c[1], c[2]), s * cross(c[2], c[0]), s * cross(c[0], c[1])}});
}

}  // namespace pliant
#pragma GCC visibility pop
