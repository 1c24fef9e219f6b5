// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A certificate, from the limits alone, that the map can't fold.
//
// In a trilinear cell ∂u_a/∂x_b is a mean of the differences along the cell's four edges of axis b,
// each divided by h_b. With the largest limits of all links along b, everywhere
//
//   ∂u_b/∂x_b ≥ −compress_b,   |∂u_a/∂x_b| ≤ shear_b  (a ≠ b).
//
// So the comparison matrix of the Jacobian J of φ is bounded below by C = 1 − N, where N has
// compress_b on the diagonal and shear_b in the rest of column b. If N's spectral radius ρ is below
// 1, C is a nonsingular M-matrix and J an H-matrix with positive diagonal [Berman1994]: det J > 0.
// Means of such J are such matrices too, so φ(X) − φ(Y) = J̄·(X − Y) ≠ 0: φ is injective. Stretch
// doesn't matter. The bound is sharp: the affine displacement −N·x satisfies all limits, and for ρ
// ≥ 1 a multiple of it is singular.

#pragma once

#include <pliant/models/material.h>

#include "material/material.h"

namespace pliant {

/// @param exceeding  whether links may be outside of their limits: then there is no certificate
FoldCertificate fold_certificate(const MaterialTable& table, Vec3d spacing_mm, bool exceeding);

/// Upper bound of the spectral radius of N, sharp to about 1e-9. @pre both ≥ 0
double fold_number(Vec3d compress, Vec3d shear);

}  // namespace pliant
