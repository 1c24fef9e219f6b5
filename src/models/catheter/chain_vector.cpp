// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vectorised chain_solve.inc, compiled for each instruction set and dispatched at run time.

#include <cstddef>

#include "catheter/chain.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "catheter/chain_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::catheter::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

void solve_six(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count) {
    solve_chain_plain(diagonal, upper, count);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

#include "catheter/chain_solve.inc"

struct VectorChainOps {
    using D = hn::CappedTag<double, 4>;
    using V = hn::Vec<D>;
    static constexpr int kLanes = int(hn::MaxLanes(D()));

    static HWY_INLINE V load(const double* from) { return hn::Load(D(), from); }
    static HWY_INLINE void store(V v, double* to) { hn::Store(v, D(), to); }
    static HWY_INLINE V set(double v) { return hn::Set(D(), v); }
    static HWY_INLINE V sub(V a, V b) { return hn::Sub(a, b); }
    static HWY_INLINE V mul(V a, V b) { return hn::Mul(a, b); }
};

void solve_six(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count) {
    solve_chain_of<VectorChainOps>(diagonal, upper, count);
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::catheter::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant::catheter {
HWY_EXPORT(solve_six);
void solve_chain(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count) {
    HWY_DYNAMIC_DISPATCH(solve_six)(diagonal, upper, count);
}
}  // namespace pliant::catheter
#endif
