// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vectorised product of blocks, compiled for each instruction set and dispatched at run time.
// The scalar version is block_plain.cpp; operations and their order are the same.

#include <cstddef>
#include <cstdint>

#include "springs/block_product.h"

#include "base/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "springs/block_vector.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pliant::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

BlockProduct block_product_of_target() {
    return plain_block_product();
}

#else

namespace hn = hwy::HWY_NAMESPACE;

/// x, y, z, 0 in one or two vectors.
using DRow = hn::CappedTag<double, 4>;
constexpr int kRowLanes = int(hn::MaxLanes(DRow()));
constexpr int kParts = 4 / kRowLanes;

void multiply(const BlockMatrix& matrix, const double* HWY_RESTRICT v, double* HWY_RESTRICT out) {
    const DRow d;
    const hn::Rebind<float, DRow> df;
    const std::int32_t* const columns = matrix.columns.data();
    const float* const blocks = matrix.blocks.data();
    const auto node_count = matrix.first.size() - 1;
    for (std::size_t n = 0; n < node_count; ++n) {
        hn::Vec<DRow> sums[3][kParts];
        for (int c = 0; c < 3; ++c)
            for (int p = 0; p < kParts; ++p) sums[c][p] = hn::Zero(d);
        if (matrix.moves[n]) {
            const double* const diagonal = matrix.diagonal.data() + 12 * n;
            for (int c = 0; c < 3; ++c)
                for (int p = 0; p < kParts; ++p)
                    sums[c][p] = hn::Mul(hn::Load(d, diagonal + 4 * c + p * kRowLanes),
                                         hn::Set(d, v[4 * n + std::size_t(c)]));
            const std::int32_t end = matrix.first[n + 1];
            for (std::int32_t k = matrix.first[n]; k < end; ++k) {
                const float* const block = blocks + 9 * std::size_t(k);
                const double* const other = v + 4 * std::size_t(columns[k]);
                for (int c = 0; c < 3; ++c)
                    for (int p = 0; p < kParts; ++p) {
                        // The fourth number belongs to the next column; it is discarded below.
                        const auto column =
                            hn::PromoteTo(d, hn::LoadU(df, block + 3 * c + p * kRowLanes));
                        sums[c][p] = hn::Add(sums[c][p], hn::Mul(column, hn::Set(d, other[c])));
                    }
            }
        }
        for (int p = 0; p < kParts; ++p)
            hn::Store(hn::Add(hn::Add(sums[0][p], sums[1][p]), sums[2][p]), d,
                      out + 4 * n + p * kRowLanes);
        out[4 * n + 3] = 0;
    }
}

BlockProduct block_product_of_target() {
    return multiply;
}

#endif  // HWY_SCALAR

}  // namespace
}  // namespace pliant::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pliant {
HWY_EXPORT(block_product_of_target);
BlockProduct vector_block_product() {
    return HWY_DYNAMIC_DISPATCH(block_product_of_target)();
}
}  // namespace pliant
#endif
