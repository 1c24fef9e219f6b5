// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loop with vector instructions, once for each instruction set that fuses multiplication
// and addition; the program chooses at run time. The plain twin is sweep_plain.cpp.

#include <cstddef>
#include <cstdint>

#include "springs/sweep.h"

// Vectors of a size known only at run time can't be kept in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
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

/// 1/√q for q > 0; finite for 0.
HWY_INLINE V reciprocal_root(V q) {
    const hn::RebindToUnsigned<D> du;
    const V half = hn::Set(D(), 0.5), one = hn::Set(D(), 1.0), third = hn::Set(D(), 0.375);
    V y = hn::BitCast(
        D(), hn::Sub(hn::Set(du, 0x5FE6EB50C7B537A9ULL), hn::ShiftRight<1>(hn::BitCast(du, q))));
    for (int n = 0; n < 2; ++n) {
        const V e = hn::NegMulAdd(hn::Mul(q, y), y, one);
        y = hn::MulAdd(y, hn::Mul(hn::MulAdd(e, third, half), e), y);
    }
    return hn::MulAdd(y, hn::Mul(hn::NegMulAdd(hn::Mul(q, y), y, one), half), y);
}

/// Places of some of the pack's nodes, and the force on them so far.
struct Lanes {
    V x, y, z;
    V from_x, from_y, from_z;  ///< x − x⁻, where there is damping
    V sum_x, sum_y, sum_z;
};

template <bool Damped>
HWY_INLINE void add_links(Lanes& own, V x, V y, V z, V moved_x, V moved_y, V moved_z,
                          const double* block) {
    const V dx = hn::Sub(own.x, x), dy = hn::Sub(own.y, y), dz = hn::Sub(own.z, z);
    const V inverse = reciprocal_root(hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx))));
    V f = hn::MulSub(hn::Load(D(), block + kPack), inverse, hn::Load(D(), block));
    if constexpr (Damped) {
        const V ax = hn::Sub(own.from_x, moved_x), ay = hn::Sub(own.from_y, moved_y),
                az = hn::Sub(own.from_z, moved_z);
        const V along = hn::MulAdd(dz, az, hn::MulAdd(dy, ay, hn::Mul(dx, ax)));
        // Not inverse²: between equal places, in lanes without a link, that is no number.
        const V drag = hn::Mul(hn::Mul(hn::Load(D(), block + 2 * kPack), along), inverse);
        f = hn::NegMulAdd(drag, inverse, f);
    }
    own.sum_x = hn::MulAdd(f, dx, own.sum_x);
    own.sum_y = hn::MulAdd(f, dy, own.sum_y);
    own.sum_z = hn::MulAdd(f, dz, own.sum_z);
}

template <bool Damped>
bool sweep(const SweepPlan& plan, const SweepArrays& a, std::int64_t begin, std::int64_t end,
           double farthest2) {
    const D d;
    const hn::Rebind<std::int32_t, D> di;
    const double *const xs = a.x[0], *const ys = a.x[1], *const zs = a.x[2];
    const double *const bx = a.before[0], *const by = a.before[1], *const bz = a.before[2];
    const double* const blocks = plan.blocks.data();
    constexpr std::size_t kBlock = Damped ? 3 * kPack : 2 * kPack;
    const V farthest = hn::Set(d, farthest2), zero = hn::Zero(d);
    auto far_lanes = hn::Lt(zero, zero);
    for (std::int64_t pack = begin; pack < end; ++pack) {
        const PackSlots slots = plan.packs[std::size_t(pack)];
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
            std::uint32_t s = slots.begin;
            for (; s < slots.rows_end; ++s) {
                const SweepSlot slot = plan.slots[s];
                const std::int64_t j = i + slot.other;
                const double* block = blocks + slot.block * kBlock + part * kLanes;
                const V x = hn::LoadU(d, xs + j), y = hn::LoadU(d, ys + j),
                        z = hn::LoadU(d, zs + j);
                if constexpr (Damped)
                    add_links<Damped>(own, x, y, z, hn::Sub(x, hn::LoadU(d, bx + j)),
                                      hn::Sub(y, hn::LoadU(d, by + j)),
                                      hn::Sub(z, hn::LoadU(d, bz + j)), block);
                else
                    add_links<Damped>(own, x, y, z, zero, zero, zero, block);
            }
            for (; s < slots.end; ++s) {
                const SweepSlot slot = plan.slots[s];
                const double* block = blocks + slot.block * kBlock + part * kLanes;
                const auto j =
                    hn::PromoteTo(hn::RebindToSigned<D>(),
                                  hn::LoadU(di, plan.others.data() + slot.other + part * kLanes));
                const V x = hn::GatherIndex(d, xs, j), y = hn::GatherIndex(d, ys, j),
                        z = hn::GatherIndex(d, zs, j);
                if constexpr (Damped)
                    add_links<Damped>(own, x, y, z, hn::Sub(x, hn::GatherIndex(d, bx, j)),
                                      hn::Sub(y, hn::GatherIndex(d, by, j)),
                                      hn::Sub(z, hn::GatherIndex(d, bz, j)), block);
                else
                    add_links<Damped>(own, x, y, z, zero, zero, zero, block);
            }
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
    return plan.damped ? sweep<true>(plan, arrays, begin, end, farthest2)
                       : sweep<false>(plan, arrays, begin, end, farthest2);
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
