// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Block tridiagonal symmetric positive definite system of n × n blocks with its right side,
// eliminated from one end to the other [Deul2018]:
//
//   A₀ U₀                 A_{i+1} ← A_{i+1} − Wᵢᵀ Dᵢ⁻¹ Wᵢ
//   U₀ᵀ A₁ U₁             where elimination within the rows of Aᵢ | Uᵢ has given
//       U₁ᵀ A₂            an upper triangle with the diagonal Dᵢ, and Wᵢ
//
// Unlike pbd/block_chain.h, this system has a variable number of blocks, and is assembled from 3 ×
// 3 parts. A row is padded to whole vectors. Its first spare column is the right side, so that row
// operations include it (chain_solve.inc).

#pragma once

#include <pliant/core/vec.h>

#include <cstddef>
#include <vector>

namespace pliant::catheter {

/// Doubles per row: columns, the right side, and padding to vectors of four.
template <std::size_t kSize>
inline constexpr std::size_t kChainRow = (kSize / 4 + 1) * 4;

/// Block in row-major order.
template <std::size_t kSize>
struct alignas(64) ChainBlock {
    double at[kSize][kChainRow<kSize>];

    /// Adds m to the part that begins at this row and column.
    void add(std::size_t row, std::size_t column, const Mat3d& m) {
        for (std::size_t c = 0; c < 3; ++c) {
            at[row][column + c] += m.columns[c].x;
            at[row + 1][column + c] += m.columns[c].y;
            at[row + 2][column + c] += m.columns[c].z;
        }
    }
    /// Adds s times the identity.
    void add_same(std::size_t row, std::size_t column, double s) {
        for (std::size_t c = 0; c < 3; ++c) at[row + c][column + c] += s;
    }
    /// Adds the matrix of v ↦ a × v.
    void add_crossing(std::size_t row, std::size_t column, Vec3d a) {
        at[row][column + 1] -= a.z;
        at[row][column + 2] += a.y;
        at[row + 1][column] += a.z;
        at[row + 1][column + 2] -= a.x;
        at[row + 2][column] -= a.y;
        at[row + 2][column + 1] += a.x;
    }
    /// Adds s v vᵀ.
    void add_outer(std::size_t row, std::size_t column, double s, Vec3d v) {
        const Vec3d sv = s * v;
        for (std::size_t r = 0; r < 3; ++r) {
            at[row + r][column] += sv[int(r)] * v.x;
            at[row + r][column + 1] += sv[int(r)] * v.y;
            at[row + r][column + 2] += sv[int(r)] * v.z;
        }
    }
};

/// Solves in place: [block][row][column]; the right side becomes the solution. @pre positive
/// definite
void solve_chain(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count);
/// Scalar version, with the same bits.
void solve_chain_plain(ChainBlock<6>* diagonal, ChainBlock<6>* upper, std::size_t count);

template <std::size_t kSize>
class Chain {
  public:
    using Block = ChainBlock<kSize>;

    std::vector<Block> diagonal;  ///< only its upper half is read
    std::vector<Block> upper;     ///< [i] couples i (rows) and i + 1 (columns)

    void reserve(std::size_t count) {
        diagonal.reserve(count);
        upper.reserve(count);
    }
    void reset(std::size_t count) {
        diagonal.resize(count);
        upper.resize(count);
        for (std::size_t i = 0; i < count; ++i) diagonal[i] = upper[i] = Block{};
    }
    /// Adds to the right side.
    void add_right(std::size_t block, std::size_t row, Vec3d v) {
        for (std::size_t c = 0; c < 3; ++c) diagonal[block].at[row + c][kSize] += v[int(c)];
    }

    /// Solves and destroys the matrix. @pre positive definite
    void solve() { solve_chain(diagonal.data(), upper.data(), diagonal.size()); }
    Vec3d solution(std::size_t block, std::size_t row) const {
        const auto& at = diagonal[block].at;
        return {at[row][kSize], at[row + 1][kSize], at[row + 2][kSize]};
    }
};

/// A chain that is rebuilt before each solution: copies start empty, and assignments change nothing
/// and don't allocate.
template <std::size_t kSize>
class ScratchChain : public Chain<kSize> {
  public:
    ScratchChain() = default;
    ScratchChain(const ScratchChain&) : Chain<kSize>() {}
    ScratchChain& operator=(const ScratchChain&) noexcept { return *this; }
};

}  // namespace pliant::catheter
