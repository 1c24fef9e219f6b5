// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The spline against a dense solution of the same system by another factor, and its identities.

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <random>
#include <string>
#include <vector>

#include "morph/plate.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using morph::fit_points;
using morph::fit_rows;
using morph::Plate;
using morph::PlatePoint;
using morph::PlateRow;

Vec3d unit(Random& random) {
    for (;;)
        if (const Vec3d v = random.vector(1); norm(v) > 0.1) return normalized(v);
}

std::vector<PlateRow> random_rows(Random& random, int count) {
    std::vector<PlateRow> rows;
    for (int n = 0; n < count; ++n)
        rows.push_back(
            {random.vector(80), unit(random), random.real(-9, 9), random.ratio(0.01, 1000)});
    return rows;
}

/// n · u(x) by the saddle-point system with pivoting, all unknowns at once.
Vec3d by_full_pivots(const std::vector<PlateRow>& rows, Vec3d x) {
    const auto n = Eigen::Index(rows.size());
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n + 12, n + 12);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n + 12);
    const auto of = [&](Eigen::Index i) { return rows[std::size_t(i)]; };
    for (Eigen::Index i = 0; i < n; ++i) {
        for (Eigen::Index j = 0; j < n; ++j)
            m(i, j) = -norm(of(i).x - of(j).x) * dot(of(i).n, of(j).n);
        m(i, i) += of(i).softness;
        for (int a = 0; a < 3; ++a) {
            m(i, n + a) = m(n + a, i) = of(i).n[a];
            for (int b = 0; b < 3; ++b)
                m(i, n + 3 + 3 * b + a) = m(n + 3 + 3 * b + a, i) = of(i).n[a] * of(i).x[b];
        }
        g[i] = of(i).gap;
    }
    const Eigen::VectorXd s = m.fullPivLu().solve(g);
    Vec3d u{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        u[a] = s[n + a];
        for (int b = 0; b < 3; ++b) u[a] += s[n + 3 + 3 * b + a] * x[b];
    }
    for (Eigen::Index i = 0; i < n; ++i) u = u - (norm(x - of(i).x) * s[i]) * of(i).n;
    return u;
}

TEST(Plate, Constraints_along_normals_give_the_solution_of_the_whole_system) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    for (int n = 0; n < 6; ++n) {
        const auto rows = random_rows(random, random.whole(30, 70));
        const Plate plate = fit_rows(rows);
        for (int m = 0; m < 8; ++m) {
            const Vec3d x = random.vector(150);
            EXPECT_LT(norm(plate.at(x) - by_full_pivots(rows, x)), 1e-6);
        }
    }
}

TEST(Plate, Known_points_are_three_constraints_each) {
    Random random(5);
    std::vector<PlatePoint> points;
    std::vector<PlateRow> rows;
    for (int n = 0; n < 40; ++n) {
        points.push_back({random.vector(80), random.vector(10), random.ratio(0.01, 10)});
        for (int a = 0; a < 3; ++a) {
            Vec3d axis{0, 0, 0};
            axis[a] = 1;
            rows.push_back({points.back().x, axis, points.back().u[a], points.back().softness});
        }
    }
    const Plate a = fit_points(points), b = fit_rows(rows);
    EXPECT_EQ(b.centres.size(), points.size());
    for (int n = 0; n < 20; ++n) {
        const Vec3d x = random.vector(150);
        EXPECT_LT(norm(a.at(x) - b.at(x)), 1e-7);
    }
}

TEST(Plate, Meets_hard_points_and_has_their_softness_as_residual_over_force) {
    Random random(6);
    std::vector<PlatePoint> points;
    for (int n = 0; n < 50; ++n)
        points.push_back({random.vector(80), random.vector(10), n % 2 ? 1e-9 : 3.0});
    const Plate plate = fit_points(points);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Vec3d off = points[n].u - plate.at(points[n].x);
        EXPECT_LT(norm(off - points[n].softness * plate.forces[n]), 1e-7);
        EXPECT_TRUE(n % 2 == 0 || norm(off) < 1e-6);
    }
}

TEST(Plate, Affine_motions_are_exact) {
    Random random(7);
    const Mat3d slope{{random.vector(0.3), random.vector(0.3), random.vector(0.3)}};
    const Vec3d shift = random.vector(20);
    std::vector<PlatePoint> points;
    std::vector<PlateRow> rows;
    for (int n = 0; n < 30; ++n) {
        const Vec3d x = random.vector(80), u = shift + slope * x, normal = unit(random);
        points.push_back({x, u, 1});
        rows.push_back({x, normal, dot(normal, u), 30});
    }
    for (const Plate& plate : {fit_points(points), fit_rows(rows)})
        for (int n = 0; n < 10; ++n) {
            const Vec3d x = random.vector(500);
            EXPECT_LT(norm(plate.at(x) - (shift + slope * x)), 1e-7);
        }
}

TEST(Plate, Points_in_a_plane_or_few_points_have_a_shift_as_trend) {
    Random random(8);
    for (const int count : {1, 2, 3, 20}) {
        std::vector<PlatePoint> points;
        for (int n = 0; n < count; ++n) {
            Vec3d x = random.vector(80);
            x.z = 4;
            points.push_back({x, random.vector(10), 1e-9});
        }
        const Plate plate = fit_points(points);
        EXPECT_EQ(plate.slope, Mat3d{}) << count;
        for (const PlatePoint& p : points) EXPECT_LT(norm(plate.at(p.x) - p.u), 1e-6) << count;
    }
}

TEST(Plate, Gradients_are_differences_and_rows_are_points) {
    Random random(9);
    const Plate a = fit_rows(random_rows(random, 40)), b = fit_rows(random_rows(random, 30));
    const Plate plate = morph::sum_of(a, b);
    for (int n = 0; n < 10; ++n) {
        const Vec3d x = random.vector(100);
        EXPECT_LT(norm(plate.at(x) - a.at(x) - b.at(x)), 1e-9);
        const Mat3d g = plate.gradient(x);
        for (int axis = 0; axis < 3; ++axis) {
            constexpr double h = 1e-4;
            Vec3d step{0, 0, 0};
            step[axis] = h;
            const Vec3d slope = (0.5 / h) * (plate.at(x + step) - plate.at(x - step));
            EXPECT_LT(norm(slope - g.columns[axis]), 1e-5);
        }
    }
    const Vec3d first = random.vector(50), step = random.vector(5);
    std::vector<double> u[3] = {std::vector<double>(9, 0), std::vector<double>(9, 0),
                                std::vector<double>(9, 0)};
    plate.add_row(first, step, u[0], u[1], u[2]);
    for (std::size_t n = 0; n < 9; ++n) {
        const Vec3d x = first + double(n) * step;
        EXPECT_LT(norm(plate.trend(x) + Vec3d{u[0][n], u[1][n], u[2][n]} - plate.at(x)), 1e-9);
    }
}

}  // namespace
}  // namespace pliant::test
