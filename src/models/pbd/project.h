// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops: one iteration over a domain's packs, kind by kind, and the update between two
// sub-steps. The formulas are in constraints.inc.

#pragma once

#include <algorithm>
#include <cstddef>

#include "pbd/plan.h"

namespace pliant::pbd {

/// Arrays of one kind, [pack][…][lane].
template <class Real>
struct PackArrays {
    const std::uint32_t* corners;
    const Real* numbers;
    Real* multipliers;
};

inline constexpr int kWarm = 10;

template <class Real>
struct ProjectArrays {
    Real* particles;  ///< x, y, z, inverse mass
    PackArrays<Real> kinds[kKinds];
    Real compliance_scale;  ///< 1/h²
    Real square_step;       ///< h²
    bool compliant;         ///< PbdMethod
    bool first;             ///< first iteration of the sub-step: multipliers count as 0
    bool backward;          ///< opposite order of all constraints
    bool last;              ///< last iteration of the sub-step
    /// Of solids with warm starts; else null: [pack][kWarm][lane], the share of the forces on the
    /// last three corners with which the next sub-step begins, and that share.
    Real* forces;
    Real* moves;  ///< [particle][4]: displacements by these forces
    bool ogden;   ///< a solid isn't neo-Hookean
};

/// Update of particles [particle][4]; the fourth component is the inverse mass in x and 0 in v:
///
///   v ← (v + (x − before) · per_h) · keep + push,  x ← before ← x + h v
///
/// if the inverse mass isn't 0; otherwise v ← 0. Then x ← x + moves and moves ← 0,
/// unless they are null.
template <class Real>
struct MoveArrays {
    Real *x, *before, *v, *moves;
    Real h, per_h, keep;
    Real push[4];
};

template <class Real>
struct Kernels {
    void (*project)(const ProjectArrays<Real>& arrays, const Domain& domain);
    /// Particles begin…end, both multiples of four.
    void (*move)(const MoveArrays<Real>& arrays, std::int64_t begin, std::int64_t end);
    /// Sets the forces of the solids to those of the present shape.
    void (*recall)(const ProjectArrays<Real>& arrays, const Domain& domain);
};

/// Number of a solid that is its Ogden exponent, 0 if it is neo-Hookean.
inline constexpr int kExponent = 11;
/// Whether a pack of solids has one that isn't neo-Hookean.
template <class Real>
bool has_ogden(const ProjectArrays<Real>& arrays, std::int32_t pack) {
    const Real* const exponents =
        arrays.kinds[int(PbdKind::Solid)].numbers +
        (std::size_t(pack) * kNumbers[int(PbdKind::Solid)] + kExponent) * kPack;
    return std::any_of(exponents, exponents + kPack, [](Real alpha) { return alpha != 0; });
}
/// Projects the solids of a pack one by one, of either law; or recalls their forces.
void project_solid_pack(const ProjectArrays<float>& arrays, std::int32_t pack, bool recall);

template <class Real>
Kernels<Real> plain_kernels();
/// Kernels for the best instruction set of this processor.
Kernels<float> vector_kernels();

}  // namespace pliant::pbd
