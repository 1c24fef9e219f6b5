// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One hexahedron: shape functions, stiffness, stress. Any consistent units apply; callers use mm
// and Pa, which gives stiffness in µN/mm.
//
// The incompatible element adds u ← u + Σ a_m (1 − ξ_m²) for m = r, s, t; the nine numbers a are
// condensed out in the element. The modes' gradients use the Jacobian and the weight at the centre
// [Taylor1976], so that the element passes the patch test on distorted meshes.

#pragma once

#include <pliant/models/fem.h>

#include <array>

namespace pliant {

struct LameParameters {
    double lambda, mu;
};
inline LameParameters lame_of(const ElasticMaterial& m) {
    const double e = m.young_modulus_pa, nu = m.poisson_ratio;
    return {e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
}

/// C_ijkl of a transversely isotropic material (ElasticMaterial).
struct HookeTensor {
    double c[3][3][3][3];
};
/// With a along the fibres, b and c across, and n = E/E_a, m = 1 − ν − 2 n ν_a² [Ting1996],
///
///   C_bbcc = λ = E (ν + n ν_a²)/((1 + ν) m)    C_bcbc = μ = E/(2 (1 + ν))
///   C_aabb = E ν_a/m    C_aaaa = E_a (1 − ν)/m    C_abab = G_a
///
/// which is in any axes, with α = C_aabb − λ, β = C_aaaa − λ − 2α + 2μ − 4G_a, γ = G_a − μ,
///
///   C_ijkl = λ δ_ij δ_kl + μ (δ_ik δ_jl + δ_il δ_jk) + α (δ_ij a_k a_l + a_i a_j δ_kl)
///          + β a_i a_j a_k a_l + γ (δ_ik a_j a_l + δ_il a_j a_k + δ_jk a_i a_l + δ_jl a_i a_k)
HookeTensor hooke_of(const ElasticMaterial& material);

inline bool has_fibres(const ElasticMaterial& material) {
    return norm(material.fibre) != 0;
}
/// Calls `use` with the LameParameters or the HookeTensor of a material.
template <class Use>
auto with_law(const ElasticMaterial& material, Use&& use) {
    return has_fibres(material) ? use(hooke_of(material)) : use(lame_of(material));
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
inline Vec3d gauss_point(int g) {
    return {g & 1 ? kGauss : -kGauss, g & 2 ? kGauss : -kGauss, g & 4 ? kGauss : -kGauss};
}

/// 24 × 24, row-major; row 3c + a is component a of corner c. Symmetric to the last bit.
using HexStiffness = std::array<double, 24 * 24>;
HexStiffness hex_stiffness(const HexCorners& corners, const LameParameters& material,
                           HexElement element);
HexStiffness hex_stiffness(const HexCorners& corners, const HookeTensor& material,
                           HexElement element);

/// Amplitudes of the incompatible modes for the corners' displacements; zero for trilinear
/// elements.
std::array<Vec3d, 3> hex_modes(const HexCorners& corners, const LameParameters& material,
                               HexElement element, const std::array<Vec3d, 8>& displacement);
std::array<Vec3d, 3> hex_modes(const HexCorners& corners, const HookeTensor& material,
                               HexElement element, const std::array<Vec3d, 8>& displacement);

SymmetricTensor strain_at(const HexPoint& point, const std::array<Vec3d, 8>& displacement,
                          const std::array<Vec3d, 3>& modes);
SymmetricTensor stress_of(const LameParameters& material, const SymmetricTensor& strain);
SymmetricTensor stress_of(const HookeTensor& material, const SymmetricTensor& strain);

}  // namespace pliant
