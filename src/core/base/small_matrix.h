// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Eigenvalues of small symmetric matrices: 3×3, or with a row and column for each group of a fit.

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace pliant {

using Matrix3 = std::array<std::array<double, 3>, 3>;   ///< [row][column]
using SquareMatrix = std::vector<std::vector<double>>;  ///< [row][column], any size

template <class Matrix>
struct SymmetricEigen {
    typename Matrix::value_type values;  ///< ascending
    Matrix vectors;                      ///< [value][component], of length 1
};

/// Rotates rows and columns p and q so that a[p][q] becomes 0.
template <class Matrix>
void rotate_to_zero(Matrix& a, Matrix& vectors, std::size_t p, std::size_t q) {
    const double apart = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (apart < 0 ? -1 : 1) / (std::abs(apart) + std::sqrt(1 + apart * apart));
    const double c = 1 / std::sqrt(1 + t * t), s = t * c;
    const auto mix = [&](double& x, double& y) {
        const double before = x;
        x = c * before - s * y;
        y = s * before + c * y;
    };
    for (auto& row : a) mix(row[p], row[q]);
    for (std::size_t n = 0; n < a.size(); ++n) mix(a[p][n], a[q][n]);
    for (std::size_t n = 0; n < a.size(); ++n) mix(vectors[p][n], vectors[q][n]);
}

/// Eigenvalues and vectors by Jacobi's rotations [Golub2013], which find small eigenvalues beside
/// large ones.
template <class Matrix>
SymmetricEigen<Matrix> symmetric_eigen(Matrix a) {
    constexpr int kSweeps = 60;  // a handful is enough
    const std::size_t size = a.size();
    Matrix vectors = a;
    for (std::size_t p = 0; p < size; ++p)
        for (std::size_t q = 0; q < size; ++q) vectors[p][q] = p == q;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool done = true;
        for (std::size_t p = 0; p < size; ++p)
            for (std::size_t q = p + 1; q < size; ++q) {
                if (std::abs(a[p][q]) <= 1e-16 * std::sqrt(std::abs(a[p][p] * a[q][q]))) continue;
                rotate_to_zero(a, vectors, p, q);
                done = false;
            }
        if (done) break;
    }
    std::vector<std::size_t> order(size);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
        return a[p][p] != a[q][q] ? a[p][p] < a[q][q] : p < q;
    });
    SymmetricEigen<Matrix> result{a.empty() ? typename Matrix::value_type{} : a[0], a};
    for (std::size_t n = 0; n < size; ++n) {
        result.values[n] = a[order[n]][order[n]];
        result.vectors[n] = vectors[order[n]];
    }
    return result;
}

/// How a matrix is divided by a number. The two differ in the last bit, and recorded results have
/// either.
enum class Scaling {
    Quotients,   ///< each element divided
    Reciprocal,  ///< each element times the reciprocal
};

/// Largest eigenvalue of a symmetric matrix, by the invariants of its deviator [Smith1961].
inline double largest_eigenvalue(const Mat3d& m, Scaling scaling) {
    const auto& c = m.columns;
    const double mean = (c[0].x + c[1].y + c[2].z) / 3;
    const double off = c[0].y * c[0].y + c[0].z * c[0].z + c[1].z * c[1].z;
    const Vec3d d{c[0].x - mean, c[1].y - mean, c[2].z - mean};
    const double p = std::sqrt((dot(d, d) + 2 * off) / 6);
    if (p == 0) return mean;
    Mat3d shape = m;
    for (int a = 0; a < 3; ++a) shape.columns[a][a] = d[a];
    for (Vec3d& v : shape.columns)
        v = scaling == Scaling::Quotients ? Vec3d{v.x / p, v.y / p, v.z / p} : (1 / p) * v;
    const double r = std::clamp(determinant(shape) / 2, -1.0, 1.0);
    return mean + 2 * p * std::cos(std::acos(r) / 3);
}

}  // namespace pliant
