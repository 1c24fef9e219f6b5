// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vectorised sweeps.inc, compiled for each instruction set and dispatched at run time.

#include <algorithm>
#include <array>
#include <cstddef>

#include "elastic/sweeps.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/sweeps_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#include "elastic/sweeps.inc"

struct RegisterOps {
    using D = hn::CappedTag<float, kSweepLanes>;
    using V = hn::Vec<D>;
    static constexpr std::size_t kLanes = hn::MaxLanes(D());

    static HWY_INLINE V load(const float* from) { return hn::LoadU(D(), from); }
    static HWY_INLINE void store(V v, float* to) { hn::StoreU(v, D(), to); }
    static HWY_INLINE V set(float v) { return hn::Set(D(), v); }
    static HWY_INLINE V add(V a, V b) { return hn::Add(a, b); }
    static HWY_INLINE V sub(V a, V b) { return hn::Sub(a, b); }
    static HWY_INLINE V mul(V a, V b) { return hn::Mul(a, b); }
    static HWY_INLINE V div(V a, V b) { return hn::Div(a, b); }
    static HWY_INLINE V sqrt(V a) { return hn::Sqrt(a); }
    static HWY_INLINE V abs(V a) { return hn::Abs(a); }
    static HWY_INLINE V max(V a, V b) { return hn::Max(a, b); }
    static HWY_INLINE bool any_positive(V a) {
        return !hn::AllFalse(D(), hn::Gt(a, hn::Zero(D())));
    }
    static HWY_INLINE V if_positive(V test, V value) {
        return hn::IfThenElseZero(hn::Gt(test, hn::Zero(D())), value);
    }
    /// 0 where all bits of the test are 0.
    static HWY_INLINE V unless_zero(V test, V value) {
        const hn::RebindToUnsigned<D> bits;
        const auto is_zero = hn::Eq(hn::BitCast(bits, test), hn::Zero(bits));
        return hn::IfThenZeroElse(hn::RebindMask(D(), is_zero), value);
    }
};

void sweep_planes_of_target(const LatticeSweep& sweep, int begin, int end, float* workspace) {
    sweep_with<RegisterOps>(sweep, begin, end, workspace);
}
void begin_smoothing_of_target(const NodeSweep& nodes, float alpha, const NodeRows& residual,
                               const NodeRows& out, const NodeRows& sum) {
    begin_smoothing_with<RegisterOps>(nodes, alpha, residual, out, sum);
}
void renew_direction_of_target(const NodeSweep& nodes, float beta, const NodeRows& step,
                               const NodeRows& direction) {
    renew_direction_with<RegisterOps>(nodes, beta, step, direction);
}
double advance_nodes_of_target(const NodeSweep& nodes, float alpha, const NodeRows& direction,
                               const NodeRows& product, const NodeRows& u,
                               const NodeRows& residual) {
    return advance_nodes_with<RegisterOps>(nodes, alpha, direction, product, u, residual);
}
double dot_nodes_of_target(const NodeSweep& nodes, const NodeRows& a, const NodeRows& b) {
    return dot_nodes_with<RegisterOps>(nodes, a, b);
}
void turn_planes_of_target(const LatticeSweep& sweep, const CellRotations& rotations, int steps,
                           int begin, int end) {
    turn_planes_with<RegisterOps>(sweep, rotations, steps, begin, end);
}

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(sweep_planes_of_target);
HWY_EXPORT(begin_smoothing_of_target);
HWY_EXPORT(renew_direction_of_target);
HWY_EXPORT(advance_nodes_of_target);
HWY_EXPORT(dot_nodes_of_target);
HWY_EXPORT(turn_planes_of_target);

void sweep_planes(const LatticeSweep& sweep, int begin, int end, float* workspace) {
    HWY_DYNAMIC_DISPATCH(sweep_planes_of_target)(sweep, begin, end, workspace);
}
void begin_smoothing(const NodeSweep& nodes, float alpha, const NodeRows& residual,
                     const NodeRows& out, const NodeRows& sum) {
    HWY_DYNAMIC_DISPATCH(begin_smoothing_of_target)(nodes, alpha, residual, out, sum);
}
void renew_direction(const NodeSweep& nodes, float beta, const NodeRows& step,
                     const NodeRows& direction) {
    HWY_DYNAMIC_DISPATCH(renew_direction_of_target)(nodes, beta, step, direction);
}
double advance_nodes(const NodeSweep& nodes, float alpha, const NodeRows& direction,
                     const NodeRows& product, const NodeRows& u, const NodeRows& residual) {
    return HWY_DYNAMIC_DISPATCH(advance_nodes_of_target)(nodes, alpha, direction, product, u,
                                                         residual);
}
double dot_nodes(const NodeSweep& nodes, const NodeRows& a, const NodeRows& b) {
    return HWY_DYNAMIC_DISPATCH(dot_nodes_of_target)(nodes, a, b);
}
void turn_planes(const LatticeSweep& sweep, const CellRotations& rotations, int steps, int begin,
                 int end) {
    HWY_DYNAMIC_DISPATCH(turn_planes_of_target)(sweep, rotations, steps, begin, end);
}
}  // namespace pliant
#endif
