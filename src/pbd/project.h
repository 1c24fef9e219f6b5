// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loop: one iteration over a domain's packs, kind by kind. The formulas are in
// constraints.inc.

#pragma once

#include "pbd/plan.h"

namespace pliant::pbd {

/// Of one kind, [pack][…][lane].
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
    bool first;             ///< iteration of the sub-step: multipliers are 0, whatever is there
};

template <class Real>
using ProjectKernel = void (*)(const ProjectArrays<Real>& arrays, const Domain& domain);

template <class Real>
ProjectKernel<Real> plain_projection();
/// The best that this processor has.
ProjectKernel<float> vector_projection();

}  // namespace pliant::pbd
