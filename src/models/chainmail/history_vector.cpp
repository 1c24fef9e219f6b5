// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The inner loops of packing a change with vector instructions, for bricks of 8³, once for each
// instruction set; the program chooses at run time. The plain twin is history_plain.cpp.

#include <cstddef>
#include <cstdint>

#include "chainmail/history_kernel.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "chainmail/history_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

const ChangeKernels& kernels_of_target() {
    return plain_change_kernels();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSize = 8, kSlice = 64, kBrick = 512;

using D = hn::CappedTag<std::uint32_t, kSize>;
using V = hn::Vec<D>;
constexpr int kLanes = int(hn::MaxLanes(D()));

/// Predicts along y and z. Columns are as wide as a vector; each is processed slice by slice.
/// @returns bitwise or of all residuals
HWY_INLINE V predict_yz(const std::uint32_t* before, const std::uint32_t* after,
                        std::uint32_t* out) {
    V any = hn::Zero(D());
    for (int x = 0; x < kSize; x += kLanes) {
        V below[kSize];  // the previous slice, predicted along y
        for (V& row : below) row = hn::Zero(D());
        for (int z = 0; z < kSize; ++z) {
            V last = hn::Zero(D());
            for (int y = 0; y < kSize; ++y) {
                const int n = x + kSize * y + kSlice * z;
                const V change = hn::Sub(hn::LoadU(D(), after + n), hn::LoadU(D(), before + n));
                const V along_y = hn::Sub(change, last);
                const V left = hn::Sub(along_y, below[y]);
                last = change;
                below[y] = along_y;
                any = hn::Or(any, left);
                hn::Store(left, D(), out + n);
            }
        }
    }
    return any;
}

/// Predicts along x, and folds signs. @param from  from[−1] may have any value
HWY_INLINE V predict_x(const std::uint32_t* from, std::uint32_t* out) {
    const hn::RebindToSigned<D> signed_d;
    const auto first = hn::FirstN(D(), 1);
    V any = hn::Zero(D());
    for (int row = 0; row < kBrick; row += kSize)
        for (int x = 0; x < kSize; x += kLanes) {
            V before = hn::LoadU(D(), from + row + x - 1);
            if (x == 0) before = hn::IfThenZeroElse(first, before);
            const V left = hn::Sub(hn::Load(D(), from + row + x), before);
            const V sign = hn::BitCast(D(), hn::ShiftRight<31>(hn::BitCast(signed_d, left)));
            const V folded = hn::Xor(hn::ShiftLeft<1>(left), sign);
            any = hn::Or(any, folded);
            hn::StoreU(folded, D(), out + row + x);
        }
    return any;
}

std::uint32_t or_of_lanes(V v) {
    HWY_ALIGN std::uint32_t lanes[kLanes];
    hn::Store(v, D(), lanes);
    std::uint32_t any = 0;
    for (const std::uint32_t lane : lanes) any |= lane;
    return any;
}

std::uint32_t predict(const Fixed* before, const Fixed* after, int, std::uint32_t* values) {
    // The value before the first element is read, and not used.
    HWY_ALIGN std::uint32_t memory[kLanes + kBrick];
    memory[kLanes - 1] = 0;
    std::uint32_t* const partly = memory + kLanes;
    const V any = predict_yz(reinterpret_cast<const std::uint32_t*>(before),
                             reinterpret_cast<const std::uint32_t*>(after), partly);
    if (or_of_lanes(any) == 0) return 0;
    return or_of_lanes(predict_x(partly, values));
}

template <int kPlane>
HWY_INLINE void copy_this_plane(const std::uint32_t* values, int count, std::uint8_t* out) {
    const hn::Rebind<std::uint8_t, D> bytes;
    for (int n = 0; n < count; n += kLanes)
        hn::StoreU(hn::TruncateTo(bytes, hn::ShiftRight<8 * kPlane>(hn::LoadU(D(), values + n))),
                   bytes, out + n);
}

void copy_plane(const std::uint32_t* values, int count, int plane, std::byte* out) {
    auto* const to = reinterpret_cast<std::uint8_t*>(out);
    if (plane == 0) copy_this_plane<0>(values, count, to);
    if (plane == 1) copy_this_plane<1>(values, count, to);
    if (plane == 2) copy_this_plane<2>(values, count, to);
    if (plane == 3) copy_this_plane<3>(values, count, to);
}

const ChangeKernels& kernels_of_target() {
    static constexpr ChangeKernels kernels{predict, copy_plane};
    return kernels;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(kernels_of_target);
const ChangeKernels& vector_change_kernels() {
    return HWY_DYNAMIC_DISPATCH(kernels_of_target)();
}
}  // namespace pliant
#endif
