// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops: one iteration over a domain's packs, kind by kind, and the update between two
// sub-steps. The formulas are in constraints.inc.

#pragma once

#include "pbd/plan.h"

namespace pliant::pbd {

/// Arrays of one kind, [pack][…][lane].
template <class Real>
struct PackArrays {
    const std::uint32_t* corners;
    const Real* numbers;
    Real* multipliers;
};

template <class Real>
struct ProjectArrays {
    Real* particles;  ///< x, y, z, inverse mass
    PackArrays<Real> kinds[kKinds];
    Real compliance_scale;  ///< 1/h²
    bool compliant;         ///< PbdMethod
    bool first;             ///< first iteration of the sub-step: multipliers count as 0
    bool backward;          ///< opposite order of all constraints
    bool warm = false;      ///< those of solids don't: they are the last sub-step's
    Real* moves = nullptr;  ///< [particle][4], of Kernels::warm
};

/// Update of particles [particle][4]; the fourth component is the inverse mass in x and 0 in v:
///
///   v ← (v + (x − before) · per_h) · keep + push,  x ← before ← x + h v
///
/// if the inverse mass isn't 0; otherwise v ← 0.
template <class Real>
struct MoveArrays {
    Real *x, *before, *v;
    Real h, per_h, keep;
    Real push[4];
};

template <class Real>
struct Kernels {
    void (*project)(const ProjectArrays<Real>& arrays, const Domain& domain);
    /// Particles begin…end, both multiples of four.
    void (*move)(const MoveArrays<Real>& arrays, std::int64_t begin, std::int64_t end);
    /// Multipliers of the solids' present forces.
    void (*recall)(const ProjectArrays<Real>& arrays, const Domain& domain);
    /// Adds the displacements by the solids' multipliers to `moves`.
    void (*warm)(const ProjectArrays<Real>& arrays, const Domain& domain);
};

template <class Real>
Kernels<Real> plain_kernels();
/// Kernels for the best instruction set of this processor.
Kernels<float> vector_kernels();

}  // namespace pliant::pbd
