// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One term of the law of [Ogden1972] as a tetrahedron's constraints. With the principal stretches
// λᵢ, J their product, and Lamé's moduli λ and µ the energy per volume is
//
//   2µ/α² (λ₁^α + λ₂^α + λ₃^α − 3) − 2µ/α (J − 1) + (λ/2 + µ/α) (J − 1)².
//
// α = 2 is the neo-Hookean law of constraints.inc. With a negative exponent the law is stiffer in
// compression than in tension. The last term is split between the volume constraint H and
//
//   ψ = 2/α² (λ₁^α + λ₂^α + λ₃^α − 3) − 2/α (J − 1) + c (J − 1)²,
//
// per µ, such that ψ ≥ 0: c is 1/α for positive exponents, 0 for negative ones. So H has a
// stiffness of λ or of λ + 2µ/α. ψ has a tangent of 2 at rest in each direction of strain without
// a change of volume.
//
// The deformation gradient is F = U diag(λ) Vᵀ with two rotations. The last stretch of an inverted
// tetrahedron is negative [Irving2004]; one that is flat has some rotation. Where the tangent
// λ^(α−2) of a stretch is more than kStiffest times that at rest, or less than a kStiffest-th of it
// for α > 2, the power continues as a parabola: energy, force and tangent remain continuous, and
// all are defined for λ ≤ 0. With α = −18 that begins at λ = 0.79.
//
// All is computed in double precision, one tetrahedron at a time.

#pragma once

#include <pliant/core/vec.h>

#include "pbd/arithmetic.h"
#include "pbd/solver.h"

namespace pliant::pbd {

/// Largest tangent of a power of a stretch, over that at rest.
inline constexpr double kStiffest = 100;

/// F = U diag(values) Vᵀ with rotations U and V; values[0] ≥ values[1] ≥ |values[2]|.
struct Stretches {
    Mat3d u, v;
    Vec3d values;
};
Stretches stretches_of(const Mat3d& f);

/// A function of one stretch with its first and second derivative.
struct StretchTerm {
    double value, slope, curve;
};
/// 2/α² λ^α, continued as a parabola.
StretchTerm ogden_term(double alpha, double stretch);

/// ψ at a deformation gradient.
struct OgdenPoint {
    double alpha;
    Stretches stretches;
    double value;
    StretchTerm terms[3];
    Vec3d slope;          ///< ∂ψ/∂λ
    double volume_slope;  ///< ∂ψ/∂J at constant powers
    double volume_curve;  ///< 2c
};
/// Stiffness of H beside ψ. Both stiffnesses are over µ.
double ogden_volume_stiffness(double alpha, double lambda);
OgdenPoint ogden_point(double alpha, const Mat3d& f);
/// ∂ψ/∂F, the first Piola-Kirchhoff stress over µ.
Mat3d ogden_stress(const OgdenPoint& at);
/// Second derivative of ψ along dF, by the blocks of [Smith2019]: one of the stretches, and two for
/// each pair of axes, with divided differences of the slope. Equal stretches have their limit.
/// @param positive  omits the blocks in which dF has a negative part
double ogden_curve(const OgdenPoint& at, const Mat3d& df, bool positive);

/// Rest data of a tetrahedron.
struct OgdenSolid {
    double inverse[3][3];  ///< as in Solid
    double alpha;
};
OgdenSolid ogden_solid(const SolidNumbers& numbers);

/// H and E = √(2ψ) with their gradients, for project_both(). Where rounding dominates ψ, it is
/// computed from its gradient.
SolidGradients<double> ogden_constraints(const Corner<double> (&p)[4], const OgdenSolid& s);

/// Gradients of H and ψ for recall_along() and project_along().
struct OgdenGradients {
    WarmGradients<double> gradients;
    /// Stiffness along ∇ψ; at least the mean of all directions with the stiffest stretch's tangent.
    double shear;
    double share;  ///< factor of the forces with which the next sub-step begins
};
OgdenGradients ogden_gradients(const Corner<double> (&p)[4], const OgdenSolid& s,
                               double e_stiffness);

}  // namespace pliant::pbd
