// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One hexahedron: shape functions, stiffness, stress. Any consistent units apply; callers use mm
// and Pa, which gives stiffness in µN/mm.
//
// The incompatible element adds u ← u + Σ a_m (1 − ξ_m²) for m = r, s, t; the nine numbers a are
// condensed out in the element. The modes' gradients use the Jacobian and the weight at the centre
// [Taylor1976], so that the element passes the patch test on distorted meshes.

#pragma once

#include <pliant/fem.h>

#include <array>

namespace pliant {

struct LameParameters {
    double lambda, mu;
};
inline LameParameters lame_of(const ElasticMaterial& m) {
    const double e = m.young_modulus_pa, nu = m.poisson_ratio;
    return {e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
}

using HexCorners = std::array<Vec3d, 8>;

/// Signs of the corners' natural coordinates.
inline constexpr double kHexSigns[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                           {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/// 1/√3: the natural coordinates of the Gauss points are ± this.
inline constexpr double kGauss = 0.57735026918962576451;

/// Values of the element at a natural position.
struct HexPoint {
    double values[8];         ///< shape functions N_c
    Vec3d gradients[8];       ///< ∂N_c/∂x
    Vec3d mode_gradients[3];  ///< ∂(1 − ξ_m²)/∂x, with the centre's Jacobian
    double weight;            ///< determinant of the Jacobian; at Gauss points, the integration
                              ///< weight
};

/// @param natural  r, s, t in −1…1
HexPoint hex_point(const HexCorners& corners, Vec3d natural);
/// Natural coordinates of Gauss point g, r fastest.
inline Vec3d gauss_place(int g) {
    return {g & 1 ? kGauss : -kGauss, g & 2 ? kGauss : -kGauss, g & 4 ? kGauss : -kGauss};
}

/// 24 × 24, row-major; row 3c + a is component a of corner c. Symmetric to the last bit.
using HexStiffness = std::array<double, 24 * 24>;
HexStiffness hex_stiffness(const HexCorners& corners, const LameParameters& material,
                           HexElement element);

/// Amplitudes of the incompatible modes for the corners' displacements; zero for trilinear
/// elements.
std::array<Vec3d, 3> hex_modes(const HexCorners& corners, const LameParameters& material,
                               HexElement element, const std::array<Vec3d, 8>& displacement);

SymmetricTensor strain_at(const HexPoint& point, const std::array<Vec3d, 8>& displacement,
                          const std::array<Vec3d, 3>& modes);
SymmetricTensor stress_of(const LameParameters& material, const SymmetricTensor& strain);

}  // namespace pliant
