// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/block_product.h"

namespace pliant {
namespace {

void multiply(const BlockMatrix& matrix, const double* v, double* out) {
    for (std::size_t n = 0; n + 1 < matrix.first.size(); ++n) {
        double sums[3][3] = {};  // [column][component]
        if (matrix.moves[n]) {
            for (int c = 0; c < 3; ++c)
                for (int r = 0; r < 3; ++r)
                    sums[c][r] = matrix.diagonal[12 * n + std::size_t(4 * c + r)] *
                                 v[4 * n + std::size_t(c)];
            for (std::int32_t k = matrix.first[n]; k < matrix.first[n + 1]; ++k) {
                const float* const block = matrix.blocks.data() + 9 * std::size_t(k);
                const double* const other = v + 4 * std::size_t(matrix.columns[std::size_t(k)]);
                for (int c = 0; c < 3; ++c)
                    for (int r = 0; r < 3; ++r) sums[c][r] += double(block[3 * c + r]) * other[c];
            }
        }
        for (int r = 0; r < 3; ++r)
            out[4 * n + std::size_t(r)] = sums[0][r] + sums[1][r] + sums[2][r];
        out[4 * n + 3] = 0;
    }
}

}  // namespace

BlockProduct plain_block_product() {
    return multiply;
}

}  // namespace pliant
