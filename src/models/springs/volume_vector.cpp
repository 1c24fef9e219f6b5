// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vectorised volume forces, compiled for each instruction set and dispatched at run time. The
// scalar version is volume_plain.cpp; operations and their order are the same.

#include <cstddef>
#include <cstdint>

#include "springs/cell_volume.h"
#include "springs/volume_sweep.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "springs/volume_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

VolumeKernel volume_kernel_of_target() {
    return plain_volume_sweep();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kPack>;
using V = hn::Vec<D>;
constexpr int kLanes = int(hn::MaxLanes(D()));

struct Vec3v {
    V x, y, z;
};
HWY_INLINE Vec3v operator-(const Vec3v& a, const Vec3v& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3v operator+(const Vec3v& a, const Vec3v& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3v operator*(V s, const Vec3v& a) {
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
HWY_INLINE Vec3v cross_of(const Vec3v& a, const Vec3v& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V dot_of(const Vec3v& a, const Vec3v& b) {
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

/// x, y, z, 0 of a node or a corner, in one or two vectors.
using DRow = hn::CappedTag<double, 4>;
constexpr int kRowLanes = int(hn::MaxLanes(DRow()));

/// Positions of some nodes. The copies are forwarded from the store buffer, which takes loads of
/// the size of the stores.
HWY_INLINE Vec3v positions_of(const double* seen, const std::int32_t* nodes) {
    const DRow d;
    alignas(64) double rows[4 * kLanes];
    for (int lane = 0; lane < kLanes; ++lane)
        for (int part = 0; part < 4; part += kRowLanes)
            hn::Store(hn::Load(d, seen + 4 * std::size_t(nodes[lane]) + part), d,
                      rows + 4 * lane + part);
    Vec3v at;
    V none;
    hn::LoadInterleaved4(D(), rows, at.x, at.y, at.z, none);
    return at;
}

template <int kCorners>
HWY_INLINE Vec3v gradient_of(const Vec3v (&at)[kCorners], int corner) {
    const D d;
    if constexpr (kCorners == 4) {
        const auto& face = kFaceOpposite[corner];
        const Vec3v a = at[face[0]];
        return hn::Set(d, 1.0 / 6) * cross_of(at[face[1]] - a, at[face[2]] - a);
    } else {
        const Vec3v here = at[corner];
        Vec3v sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (const auto& face : kFacesAt[corner]) {
            const Vec3v b = at[face[0]] - here, c = at[face[1]] - here, e = at[face[2]] - here;
            sum = sum + cross_of(b, c) + cross_of(c, e) + cross_of(b, e);
        }
        return hn::Set(d, 1.0 / 12) * sum;
    }
}

/// @param values  bulk, and kPack later the volume at rest
template <int kCorners>
HWY_INLINE void add_cells_of(const VolumeArrays& a, const std::int32_t* nodes, const double* values,
                             std::size_t first) {
    const D d;
    Vec3v at[kCorners], force[kCorners];
    for (int n = 0; n < kCorners; ++n) at[n] = positions_of(a.seen, nodes + kPack * n);
    V volume = hn::Zero(d);
    for (int n = 0; n < kCorners; ++n) {
        force[n] = gradient_of<kCorners>(at, n);
        volume = hn::Add(volume, dot_of(at[n] - at[0], force[n]));
    }
    const V swell = hn::Sub(hn::Div(hn::Div(volume, hn::Set(d, 3.0)), hn::Load(d, values + kPack)),
                            hn::Set(d, 1.0));
    const V push = hn::Neg(hn::Mul(hn::Load(d, values), swell));
    for (int n = 0; n < kCorners; ++n) {
        const Vec3v f = push * force[n];
        hn::StoreInterleaved4(f.x, f.y, f.z, hn::Zero(d), d,
                              a.corner_force + 4 * (first + std::size_t(kPack * n)));
    }
}

void add_cells(const SweepPlan& plan, const VolumeArrays& a, std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
        const CellPack pack = plan.cell_packs[std::size_t(p)];
        for (int lane = 0; lane < kPack; lane += kLanes) {
            const auto first = std::size_t(pack.first + lane);
            const std::int32_t* const nodes = plan.cell_nodes.data() + first;
            const double* const values = plan.cell_values.data() + 2 * kPack * p + lane;
            if (pack.node_count == 4)
                add_cells_of<4>(a, nodes, values, first);
            else
                add_cells_of<8>(a, nodes, values, first);
        }
    }
}

void add_nodes(const SweepPlan& plan, const VolumeArrays& a, std::int64_t begin, std::int64_t end) {
    const DRow d;
    constexpr int kParts = 4 / kRowLanes;
    for (std::int64_t l = begin; l < end; ++l) {
        alignas(32) double sums[4] = {a.load[0][l], a.load[1][l], a.load[2][l], 0};
        hn::Vec<DRow> sum[kParts];
        for (int p = 0; p < kParts; ++p) sum[p] = hn::Load(d, sums + p * kRowLanes);
        const std::int32_t last = plan.first_corner[std::size_t(l - kPack + 1)];
        for (std::int32_t k = plan.first_corner[std::size_t(l - kPack)]; k < last; ++k) {
            const double* const force =
                a.corner_force + 4 * std::size_t(plan.corners[std::size_t(k)]);
            for (int p = 0; p < kParts; ++p)
                sum[p] = hn::Add(sum[p], hn::Load(d, force + p * kRowLanes));
        }
        for (int p = 0; p < kParts; ++p) hn::Store(sum[p], d, sums + p * kRowLanes);
        for (int c = 0; c < 3; ++c) a.force[c][l] = sums[c];
    }
}

VolumeKernel volume_kernel_of_target() {
    return {add_cells, add_nodes};
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(volume_kernel_of_target);
VolumeKernel vector_volume_sweep() {
    return HWY_DYNAMIC_DISPATCH(volume_kernel_of_target)();
}
}  // namespace pliant
#endif
