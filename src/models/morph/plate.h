// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Thin plate spline of three dimensions [Duchon1977]: the smoothest field through constraints.
//
//   u(x) = a + B (x − o) − Σ |x − xⱼ| fⱼ
//
// minimises 1/(8π) ∫ |∇∇u|² + Σ (nⱼ · u(xⱼ) − gⱼ)² / λⱼ, fⱼ = cⱼ nⱼ. A known point has three
// constraints along the axes, a surface that slides has one along its normal. −r is conditionally
// positive definite [Micchelli1986], so that the system has a Cholesky factor on the complement of
// the affine trend, whatever the constraints are.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>

#include <span>
#include <vector>

namespace pliant::morph {

/// Constraint n · u(x) = gap, of a softness λ.
struct PlateRow {
    Vec3d x, n;       ///< [mm]; n is a unit vector
    double gap;       ///< [mm]
    double softness;  ///< [mm] above 0
};

/// Constraint u(x) = u, of a softness λ.
struct PlatePoint {
    Vec3d x, u;
    double softness;
};

struct Plate {
    Vec3d origin{0, 0, 0}, shift{0, 0, 0};
    Mat3d slope{};               ///< B
    std::vector<Vec3d> centres;  ///< xⱼ
    std::vector<Vec3d> forces;   ///< fⱼ

    Vec3d at(Vec3d x) const;
    /// ∂u/∂x; 0 of a kernel at its centre.
    Mat3d gradient(Vec3d x) const;
    /// a + B (x − o).
    Vec3d trend(Vec3d x) const { return shift + slope * (x - origin); }
    /// u of a row of points first, first + step, …, less the trend.
    /// @param[out] u  components apart
    void add_row(Vec3d first, Vec3d step, std::span<double> u_x, std::span<double> u_y,
                 std::span<double> u_z) const;
};

/// Fits constraints along directions. @pre they determine an affine map
Plate fit_rows(std::span<const PlateRow> rows);
/// Fits vectors, with one factor for the three components. If the points lie in a plane, or there
/// are less than four, the trend is a shift.
Plate fit_points(std::span<const PlatePoint> points);

/// Whether there are four points or more, and not all near one plane.
bool span_space(std::span<const Vec3d> points);

/// One plate with the kernels of two.
Plate sum_of(const Plate& a, const Plate& b);

}  // namespace pliant::morph
