// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vectorised lattice_row.inc, compiled for each instruction set and dispatched at run time.

#include <cstddef>

#include "fem/lattice_stiffness.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/lattice_row_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#include "fem/lattice_row.inc"

struct VectorOps {
    using D = hn::CappedTag<double, NodeVector::kRoom>;
    using V = hn::Vec<D>;
    static constexpr int kLanes = int(hn::MaxLanes(D()));

    static HWY_INLINE V load(const double* from) { return hn::LoadU(D(), from); }
    static HWY_INLINE void store(V v, double* to) { hn::StoreU(v, D(), to); }
    static HWY_INLINE V set(double v) { return hn::Set(D(), v); }
    static HWY_INLINE V add(V a, V b) { return hn::Add(a, b); }
    static HWY_INLINE V sub(V a, V b) { return hn::Sub(a, b); }
    static HWY_INLINE V mul(V a, V b) { return hn::Mul(a, b); }
};

void add_row_of_target(const LatticeFactors& factors, const LatticeRow& row) {
#if HWY_TARGET == HWY_SCALAR
    add_lattice_row_plain(factors, row);
#else
    add_row<VectorOps>(factors, row);
#endif
}

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(add_row_of_target);
void add_lattice_row(const LatticeFactors& factors, const LatticeRow& row) {
    HWY_DYNAMIC_DISPATCH(add_row_of_target)(factors, row);
}
}  // namespace pliant
#endif
