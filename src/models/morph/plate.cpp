// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/plate.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/small_matrix.h"

namespace pliant::morph {
namespace {

using Matrix = Eigen::MatrixXd;

constexpr double kScaleMm = 100;  ///< of the trend's columns, so that they are near 1
/// Points whose spread across their plane is a smaller share of that along it have no affine trend.
constexpr double kFlat = 1e-3;

/// Solves [K + Λ, P; Pᵀ, 0] [c; d] = [g; 0]. @param kernel  K + Λ; overwritten
struct Saddle {
    Matrix c, d;

    Saddle(Matrix& kernel, const Matrix& p, const Matrix& g) {
        const Eigen::Index n = p.rows(), q = p.cols(), rest = n - q;
        const Eigen::HouseholderQR<Matrix> qr(p);
        Matrix turned = kernel;
        turned.applyOnTheLeft(qr.householderQ().adjoint());
        turned.applyOnTheRight(qr.householderQ());
        const Matrix right = qr.householderQ().adjoint() * g;
        Matrix z = Matrix::Zero(n, g.cols());
        if (rest > 0) {
            const Matrix inner = turned.bottomRightCorner(rest, rest);
            z.bottomRows(rest) = inner.llt().solve(right.bottomRows(rest));
        }
        // Rows of the trend: R d = Q₁ᵀ (g − (K + Λ) c).
        d = right.topRows(q) - turned.topRightCorner(q, rest) * z.bottomRows(rest);
        qr.matrixQR().topRows(q).triangularView<Eigen::Upper>().solveInPlace(d);
        c = qr.householderQ() * z;
    }
};

Vec3d mean_of(std::span<const Vec3d> points) {
    Vec3d sum{0, 0, 0};
    for (const Vec3d& p : points) sum = sum + p;
    return (1 / double(points.size())) * sum;
}

Eigen::Index at(std::size_t n) {
    return Eigen::Index(n);
}

/// Adds the forces at equal centres.
void merge(Plate& plate) {
    std::vector<std::size_t> order(plate.centres.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    const auto key = [&](std::size_t n) {
        const Vec3d& x = plate.centres[n];
        return std::tuple(x.x, x.y, x.z);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
    std::vector<Vec3d> centres, forces;
    for (const std::size_t n : order) {
        if (centres.empty() || !(centres.back() == plate.centres[n])) {
            centres.push_back(plate.centres[n]);
            forces.push_back({0, 0, 0});
        }
        forces.back() = forces.back() + plate.forces[n];
    }
    plate.centres = std::move(centres);
    plate.forces = std::move(forces);
}

}  // namespace

bool span_space(std::span<const Vec3d> points) {
    if (points.size() < 4) return false;
    const Vec3d mean = mean_of(points);
    Matrix3 spread{};
    for (const Vec3d& p : points)
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                spread[std::size_t(a)][std::size_t(b)] += (p[a] - mean[a]) * (p[b] - mean[b]);
    const auto values = symmetric_eigen(spread).values;
    return values[0] > kFlat * kFlat * values[2];
}

Vec3d Plate::at(Vec3d x) const {
    Vec3d u = trend(x);
    for (std::size_t n = 0; n < centres.size(); ++n) u = u - norm(x - centres[n]) * forces[n];
    return u;
}

Mat3d Plate::gradient(Vec3d x) const {
    Mat3d g = slope;
    for (std::size_t n = 0; n < centres.size(); ++n) {
        const Vec3d d = x - centres[n];
        const double r = norm(d);
        if (r == 0) continue;
        for (int a = 0; a < 3; ++a) g.columns[a] = g.columns[a] - (d[a] / r) * forces[n];
    }
    return g;
}

void Plate::add_row(Vec3d first, Vec3d step, std::span<double> u_x, std::span<double> u_y,
                    std::span<double> u_z) const {
    const std::size_t count = u_x.size();
    double* const x = u_x.data();
    double* const y = u_y.data();
    double* const z = u_z.data();
    // |x − c|² along the row is a quadratic function of the index. The loop over it is vectorised.
    for (std::size_t n = 0; n < centres.size(); ++n) {
        const Vec3d d = first - centres[n], f = forces[n];
        for (std::size_t i = 0; i < count; ++i) {
            const auto t = double(std::int32_t(i));
            const double a = d.x + t * step.x, b = d.y + t * step.y, c = d.z + t * step.z;
            const double r = std::sqrt(a * a + b * b + c * c);
            x[i] -= r * f.x;
            y[i] -= r * f.y;
            z[i] -= r * f.z;
        }
    }
}

Plate fit_rows(std::span<const PlateRow> rows) {
    const std::size_t n = rows.size();
    Plate plate;
    for (const PlateRow& row : rows) plate.centres.push_back(row.x);
    plate.origin = mean_of(plate.centres);
    Matrix kernel(n, n), p(n, 12), g(n, 1);
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i)
            kernel(at(i), at(j)) = -norm(rows[i].x - rows[j].x) * dot(rows[i].n, rows[j].n);
        kernel(at(j), at(j)) = rows[j].softness;
        const Vec3d x = (1 / kScaleMm) * (rows[j].x - plate.origin);
        for (int a = 0; a < 3; ++a) {
            p(at(j), a) = rows[j].n[a];
            for (int b = 0; b < 3; ++b) p(at(j), 3 + 3 * b + a) = x[b] * rows[j].n[a];
        }
        g(at(j), 0) = rows[j].gap;
    }
    const Saddle solved(kernel, p, g);
    for (int a = 0; a < 3; ++a) {
        plate.shift[a] = solved.d(a, 0);
        for (int b = 0; b < 3; ++b)
            plate.slope.columns[b][a] = solved.d(3 + 3 * b + a, 0) / kScaleMm;
    }
    for (std::size_t j = 0; j < n; ++j) plate.forces.push_back(solved.c(at(j), 0) * rows[j].n);
    merge(plate);
    return plate;
}

Plate fit_points(std::span<const PlatePoint> points) {
    const std::size_t n = points.size();
    Plate plate;
    for (const PlatePoint& point : points) plate.centres.push_back(point.x);
    plate.origin = mean_of(plate.centres);
    const int columns = span_space(plate.centres) ? 4 : 1;
    Matrix kernel(n, n), p(n, columns), g(n, 3);
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) kernel(at(i), at(j)) = -norm(points[i].x - points[j].x);
        kernel(at(j), at(j)) = points[j].softness;
        p(at(j), 0) = 1;
        for (int a = 0; a < 3; ++a) {
            if (columns == 4) p(at(j), 1 + a) = (points[j].x[a] - plate.origin[a]) / kScaleMm;
            g(at(j), a) = points[j].u[a];
        }
    }
    const Saddle solved(kernel, p, g);
    for (int a = 0; a < 3; ++a) {
        plate.shift[a] = solved.d(0, a);
        for (int b = 0; columns == 4 && b < 3; ++b)
            plate.slope.columns[b][a] = solved.d(1 + b, a) / kScaleMm;
    }
    for (std::size_t j = 0; j < n; ++j)
        plate.forces.push_back({solved.c(at(j), 0), solved.c(at(j), 1), solved.c(at(j), 2)});
    return plate;
}

Plate sum_of(const Plate& a, const Plate& b) {
    Plate sum = a;
    sum.shift = a.trend(a.origin) + b.trend(a.origin);
    for (int c = 0; c < 3; ++c) sum.slope.columns[c] = a.slope.columns[c] + b.slope.columns[c];
    sum.centres.insert(sum.centres.end(), b.centres.begin(), b.centres.end());
    sum.forces.insert(sum.forces.end(), b.forces.begin(), b.forces.end());
    merge(sum);
    return sum;
}

}  // namespace pliant::morph
