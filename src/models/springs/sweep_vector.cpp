// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vectorised inner loop, compiled for each instruction set with fused multiply-add and
// dispatched at run time. The scalar version is sweep_plain.cpp.

#include <cstddef>
#include <cstdint>

#include "springs/sweep.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "springs/sweep_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || !HWY_NATIVE_FMA

SweepKernel kernel_of_target() {
    return plain_sweep();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kPack>;
using V = hn::Vec<D>;
constexpr int kLanes = int(hn::MaxLanes(D()));
constexpr int kParts = kPack / kLanes;

/// Computes 1/√q in place for q > 0; finite for 0. Several at once, as in all that follows: a
/// single dependency chain is latency-bound, so independent chains are interleaved.
template <int N>
HWY_INLINE void reciprocal_roots(V (&q)[N]) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const V one = hn::Set(d, 1.0);
    V y[N], e[N], t[N];
    for (int n = 0; n < N; ++n)
        y[n] = hn::BitCast(
            d, hn::Sub(hn::Set(du, kRootGuess), hn::ShiftRight<1>(hn::BitCast(du, q[n]))));
    for (int n = 0; n < N; ++n) e[n] = hn::Mul(q[n], y[n]);
    for (int n = 0; n < N; ++n) e[n] = hn::NegMulAdd(e[n], y[n], one);
    for (int n = 0; n < N; ++n) t[n] = hn::MulAdd(e[n], hn::Set(d, kRoot2), hn::Set(d, kRoot1));
    for (int n = 0; n < N; ++n) t[n] = hn::MulAdd(e[n], t[n], hn::Set(d, kRoot0));
    for (int n = 0; n < N; ++n) y[n] = hn::Mul(y[n], t[n]);
    for (int n = 0; n < N; ++n) e[n] = hn::Mul(q[n], y[n]);
    for (int n = 0; n < N; ++n) e[n] = hn::NegMulAdd(e[n], y[n], one);
    for (int n = 0; n < N; ++n) t[n] = hn::MulAdd(e[n], hn::Set(d, 0.3125), hn::Set(d, 0.375));
    for (int n = 0; n < N; ++n) t[n] = hn::MulAdd(e[n], t[n], hn::Set(d, 0.5));
    for (int n = 0; n < N; ++n) e[n] = hn::Mul(e[n], y[n]);
    for (int n = 0; n < N; ++n) q[n] = hn::MulAdd(e[n], t[n], y[n]);
}

/// Positions of some of the pack's nodes, and the accumulated force on them.
struct Lanes {
    V x, y, z;
    V from_x, from_y, from_z;  ///< x − x⁻, with damping only
    V sum_x, sum_y, sum_z;
};

/// Positions of the other ends.
struct Seen {
    const double *x, *y, *z;
    const double *before_x, *before_y, *before_z;
};

/// Other ends with consecutive numbers.
struct Row {
    std::int64_t from;
    HWY_INLINE V operator()(const double* values) const { return hn::LoadU(D(), values + from); }
};
/// Arbitrary other ends.
struct List {
    hn::Vec<hn::RebindToSigned<D> > at;
    HWY_INLINE V operator()(const double* values) const { return hn::GatherIndex(D(), values, at); }
};

/// Terms of a link: numbers of a lane in a block (SweepPlan::blocks).
constexpr int kElastic = 2, kDamped = 3, kBranched = 7;

/// States of the branches of a slot's lanes; those of the next slot follow kPack later.
struct Branches {
    const double* now;
    double* next;
};

template <int Terms>
HWY_INLINE Branches branches_at(const SweepArrays& a, std::size_t at) {
    if constexpr (Terms == kBranched) return {a.branch + at, a.next_branch + at};
    return {};
}

template <int Terms, int N, class Position>
HWY_INLINE void add_links(Lanes& own, const Seen& seen, const Position (&positions)[N],
                          const double* const (&blocks)[N], const Branches& branches) {
    const D d;
    V dx[N], dy[N], dz[N], y[N];
    for (int n = 0; n < N; ++n) dx[n] = hn::Sub(own.x, positions[n](seen.x));
    for (int n = 0; n < N; ++n) dy[n] = hn::Sub(own.y, positions[n](seen.y));
    for (int n = 0; n < N; ++n) dz[n] = hn::Sub(own.z, positions[n](seen.z));
    for (int n = 0; n < N; ++n) y[n] = hn::Mul(dx[n], dx[n]);
    for (int n = 0; n < N; ++n) y[n] = hn::MulAdd(dy[n], dy[n], y[n]);
    for (int n = 0; n < N; ++n) y[n] = hn::MulAdd(dz[n], dz[n], y[n]);
    V squares[N];
    for (int n = 0; n < N; ++n) squares[n] = y[n];
    reciprocal_roots(y);
    V f[N];
    for (int n = 0; n < N; ++n)
        f[n] = hn::MulSub(hn::Load(d, blocks[n] + kPack), y[n], hn::Load(d, blocks[n]));
    if constexpr (Terms >= kDamped)
        for (int n = 0; n < N; ++n) {
            const auto moved = [&](V from, const double* now, const double* before) HWY_ATTR {
                return hn::Sub(from, hn::Sub(positions[n](now), positions[n](before)));
            };
            V along = hn::Mul(dx[n], moved(own.from_x, seen.x, seen.before_x));
            along = hn::MulAdd(dy[n], moved(own.from_y, seen.y, seen.before_y), along);
            along = hn::MulAdd(dz[n], moved(own.from_z, seen.z, seen.before_z), along);
            // Not 1/r², which is NaN between equal positions, in lanes without a link.
            const V drag = hn::Mul(hn::Mul(hn::Load(d, blocks[n] + 2 * kPack), along), y[n]);
            f[n] = hn::NegMulAdd(drag, y[n], f[n]);
        }
    if constexpr (Terms == kBranched)
        for (int n = 0; n < N; ++n) {
            const auto term = [&](int t) HWY_ATTR { return hn::Load(d, blocks[n] + t * kPack); };
            const V state = hn::Load(d, branches.now + n * kPack);
            const V stretch = hn::MulSub(squares[n], y[n], term(3));
            const V pull = hn::MulSub(term(4), stretch, state);
            f[n] = hn::NegMulAdd(pull, y[n], f[n]);
            hn::Store(hn::MulAdd(term(5), state, hn::Mul(term(6), stretch)), d,
                      branches.next + n * kPack);
        }
    for (int n = 0; n < N; ++n) {
        own.sum_x = hn::MulAdd(f[n], dx[n], own.sum_x);
        own.sum_y = hn::MulAdd(f[n], dy[n], own.sum_y);
        own.sum_z = hn::MulAdd(f[n], dz[n], own.sum_z);
    }
}

/// The slots of a plan, relative to some lanes of one pack.
template <int Terms>
struct Slots {
    const SweepSlot* slots;
    const double* blocks;
    const std::int32_t* others;
    std::int64_t i;     ///< local number of the first lane
    Branches branches;  ///< of slot 0

    HWY_INLINE const double* block_of(std::uint32_t s) const {
        return blocks + slots[s].block * std::size_t(Terms * kPack);
    }
    HWY_INLINE Row row_of(std::uint32_t s) const { return {i + slots[s].other}; }
    HWY_INLINE Branches branches_of(std::uint32_t s) const {
        if constexpr (Terms == kBranched)
            return {branches.now + std::size_t(s) * kPack, branches.next + std::size_t(s) * kPack};
        return branches;
    }
    HWY_INLINE List list_of(std::uint32_t s) const {
        const hn::Rebind<std::int32_t, D> di;
        return {hn::PromoteTo(hn::RebindToSigned<D>(), hn::LoadU(di, others + slots[s].other))};
    }
};

template <int Terms>
HWY_INLINE void add_rows(Lanes& own, const Seen& seen, const Slots<Terms>& of, std::uint32_t s,
                         std::uint32_t end) {
    for (; s + 3 <= end; s += 3)
        add_links<Terms, 3, Row>(own, seen, {of.row_of(s), of.row_of(s + 1), of.row_of(s + 2)},
                                 {of.block_of(s), of.block_of(s + 1), of.block_of(s + 2)},
                                 of.branches_of(s));
    for (; s < end; ++s)
        add_links<Terms, 1, Row>(own, seen, {of.row_of(s)}, {of.block_of(s)}, of.branches_of(s));
}

template <int Terms>
HWY_INLINE void add_lists(Lanes& own, const Seen& seen, const Slots<Terms>& of, std::uint32_t s,
                          std::uint32_t end) {
    for (; s + 2 <= end; s += 2)
        add_links<Terms, 2, List>(own, seen, {of.list_of(s), of.list_of(s + 1)},
                                  {of.block_of(s), of.block_of(s + 1)}, of.branches_of(s));
    for (; s < end; ++s)
        add_links<Terms, 1, List>(own, seen, {of.list_of(s)}, {of.block_of(s)}, of.branches_of(s));
}

template <int Terms>
bool sweep(const SweepPlan& plan, const SweepArrays& a, std::int64_t begin, std::int64_t end,
           double farthest2) {
    const D d;
    const double *const xs = a.x[0], *const ys = a.x[1], *const zs = a.x[2];
    const double *const bx = a.before[0], *const by = a.before[1], *const bz = a.before[2];
    const Seen seen{xs, ys, zs, bx, by, bz};
    const V farthest = hn::Set(d, farthest2), zero = hn::Zero(d);
    auto far_lanes = hn::Lt(zero, zero);
    for (std::int64_t pack = begin; pack < end; ++pack) {
        const PackSlots of = plan.packs[std::size_t(pack)];
        for (int part = 0; part < kParts; ++part) {
            const std::int64_t i = (pack + 1) * kPack + part * kLanes;
            Lanes own;
            own.x = hn::Load(d, xs + i);
            own.y = hn::Load(d, ys + i);
            own.z = hn::Load(d, zs + i);
            own.from_x = hn::Sub(own.x, hn::Load(d, bx + i));
            own.from_y = hn::Sub(own.y, hn::Load(d, by + i));
            own.from_z = hn::Sub(own.z, hn::Load(d, bz + i));
            own.sum_x = hn::Load(d, a.force[0] + i);
            own.sum_y = hn::Load(d, a.force[1] + i);
            own.sum_z = hn::Load(d, a.force[2] + i);
            const Slots<Terms> slots{plan.slots.data(), plan.blocks.data() + part * kLanes,
                                     plan.others.data() + part * kLanes, i,
                                     branches_at<Terms>(a, part * kLanes)};
            add_rows(own, seen, slots, of.begin, of.rows_end);
            add_lists(own, seen, slots, of.rows_end, of.end);
            const V keep = hn::Load(d, a.keep + i), push = hn::Load(d, a.push + i);
            const V mx = hn::MulAdd(push, own.sum_x, hn::Mul(keep, own.from_x));
            const V my = hn::MulAdd(push, own.sum_y, hn::Mul(keep, own.from_y));
            const V mz = hn::MulAdd(push, own.sum_z, hn::Mul(keep, own.from_z));
            hn::Store(hn::Add(own.x, mx), d, a.next[0] + i);
            hn::Store(hn::Add(own.y, my), d, a.next[1] + i);
            hn::Store(hn::Add(own.z, mz), d, a.next[2] + i);
            const V far = hn::MulAdd(mz, mz, hn::MulAdd(my, my, hn::Mul(mx, mx)));
            far_lanes = hn::Or(far_lanes, hn::Not(hn::Le(far, farthest)));
        }
    }
    return hn::AllFalse(d, far_lanes);
}

bool sweep_either(const SweepPlan& plan, const SweepArrays& arrays, std::int64_t begin,
                  std::int64_t end, double farthest2) {
    const auto sweep_terms = plan.branched ? sweep<kBranched>
                             : plan.damped ? sweep<kDamped>
                                           : sweep<kElastic>;
    return sweep_terms(plan, arrays, begin, end, farthest2);
}

SweepKernel kernel_of_target() {
    return sweep_either;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(kernel_of_target);
SweepKernel vector_sweep() {
    return HWY_DYNAMIC_DISPATCH(kernel_of_target)();
}
}  // namespace pliant
#endif
