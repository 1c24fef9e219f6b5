// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A box-shaped hexahedron in sums and differences along its axes.
//
//   w_a[m] = Σ_c s_c(m) u_a(c)      m: 3 bits, one for each axis; s_c(m) = Π ±1 over the bits of m
//   u_a(ξ) = 1/8 Σ_m w_a[m] ξ^m     ξ in −1…1
//
// In these coordinates 45 of the 576 numbers of the stiffness are not zero. The element is B-bar
// [Hughes1980]: the deviatoric part is integrated exactly, the volume's change is the cell's mean,
// so that it doesn't lock near ν = ½.

#pragma once

#include <pliant/core/vec.h>

#include <array>

namespace pliant {

/// Factors of forces in sums and differences, for λ and μ in the same units; forces are then in
/// that unit times mm². With k_a = 1/(4 h_a) and V the cell's volume:
struct CellFactors {
    float diagonal[3][8];  ///< μ: of component a and mode m with itself
    float shear[3][2];  ///< μ: of ∂_b u_a with ∂_a u_b; axis across, and whether the mode has it
    float stretch[3];   ///< μ: of ∂_a u_a with ∂_b u_b in the modes that have the axis across
    float pressure[3];  ///< λ: √V k_a
    float gradient[3];  ///< k_a: mean ∂u/∂x_a = k_a w[1 << a]
    float rest[3];      ///< 4 h_a: w_a[1 << a] of the positions at rest
};

CellFactors cell_factors(Vec3d spacing_mm);

/// Diagonal 3 × 3 blocks of a cell's corners for λ = 1 and for μ = 1: xx, xy, xz, yy, yz, zz.
struct CornerBlocks {
    std::array<std::array<float, 6>, 8> lambda, mu;
};
CornerBlocks corner_blocks(const CellFactors& factors);

/// Slight overestimate of the largest eigenvalue of D⁻¹K of one cell, D its corners' blocks. It
/// bounds that of every lattice of such cells with λ/μ up to the given ratio.
double cell_spectrum(const CellFactors& factors, double lambda_per_mu);

}  // namespace pliant
