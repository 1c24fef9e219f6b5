// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The product of an assembled matrix of 3×3 blocks and a vector, which is most of the work of
// AssembledEuler.
//
// Blocks beside the diagonal are single precision, nine numbers by columns, so that the matrix of
// 20,000 tetrahedra takes 2 MB and stays near the processor. Vectors are double precision, x, y, z,
// 0: a column times a component of the vector is one multiplication and one addition of four
// numbers. No operation is fused: vectors and scalars give the same bits.

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/aligned_array.h"

namespace pliant {

struct BlockMatrix {
    std::vector<std::int32_t> first;    ///< [node] of its blocks, and the total
    std::vector<std::int32_t> columns;  ///< [block] the other node
    AlignedVector<float> blocks;        ///< [9 · block], by columns; four more are read
    AlignedArray diagonal;              ///< [12 · node], by columns of x, y, z, 0
    std::vector<std::uint8_t> moves;    ///< [node]; images of the others are 0
};

/// Computes out = A·v. @param v, out  [4 · node] x, y, z, 0
using BlockProduct = void (*)(const BlockMatrix& matrix, const double* v, double* out);

BlockProduct plain_block_product();
/// Kernel for the best instruction set of this processor.
BlockProduct vector_block_product();

}  // namespace pliant
