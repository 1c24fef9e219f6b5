// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit/symmetric_eigen.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {
namespace {

constexpr int kSweeps = 60;  // a handful suffices

/// Rotates rows and columns p and q such that a[p][q] becomes 0.
void rotate(SmallMatrix& a, SmallMatrix& vectors, std::size_t p, std::size_t q) {
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

}  // namespace

SymmetricEigen symmetric_eigen(SmallMatrix a) {
    const std::size_t size = a.size();
    SmallMatrix vectors(size, std::vector<double>(size, 0));
    for (std::size_t n = 0; n < size; ++n) vectors[n][n] = 1;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool done = true;
        for (std::size_t p = 0; p < size; ++p)
            for (std::size_t q = p + 1; q < size; ++q) {
                if (std::abs(a[p][q]) <= 1e-16 * std::sqrt(std::abs(a[p][p] * a[q][q]))) continue;
                rotate(a, vectors, p, q);
                done = false;
            }
        if (done) break;
    }
    std::vector<std::size_t> order(size);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
        return a[p][p] != a[q][q] ? a[p][p] < a[q][q] : p < q;
    });
    SymmetricEigen result;
    for (const std::size_t n : order) {
        result.values.push_back(a[n][n]);
        result.vectors.push_back(vectors[n]);
    }
    return result;
}

}  // namespace pliant
