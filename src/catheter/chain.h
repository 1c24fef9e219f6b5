// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A symmetric positive definite matrix of n × n blocks, each coupled to its neighbours only,
// factored from one end to the other [Deul2018]:
//
//   L₀L₀ᵀ = A₀,  Wᵢ = Lᵢ⁻¹ Uᵢ,  L_{i+1}L_{i+1}ᵀ = A_{i+1} − WᵢᵀWᵢ
//
// Beside pbd/block_chain.h this one has a count that changes, and works on 3 × 3 parts as they
// come. Loops have fixed lengths, so that compilers unroll them.

#pragma once

#include <pliant/vec.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace pliant::catheter {

template <std::size_t kSize>
struct ChainVector {
    double at[kSize];

    void add(std::size_t row, Vec3d v) {
        for (std::size_t c = 0; c < 3; ++c) at[row + c] += v[int(c)];
    }
    Vec3d part(std::size_t row) const { return {at[row], at[row + 1], at[row + 2]}; }
};
/// By rows.
template <std::size_t kSize>
struct ChainBlock {
    double at[kSize][kSize];

    /// += m in the part that begins at this row and column.
    void add(std::size_t row, std::size_t column, const Mat3d& m) {
        for (std::size_t c = 0; c < 3; ++c) {
            at[row][column + c] += m.columns[c].x;
            at[row + 1][column + c] += m.columns[c].y;
            at[row + 2][column + c] += m.columns[c].z;
        }
    }
};

template <std::size_t kSize>
class Chain {
  public:
    using Vector = ChainVector<kSize>;
    using Block = ChainBlock<kSize>;

    std::vector<Block> diagonal;  ///< of which the lower half is read
    std::vector<Block> upper;     ///< [i] couples i (rows) and i + 1 (columns)
    std::vector<Vector> right;    ///< becomes the solution

    void reset(std::size_t count) {
        diagonal.assign(count, Block{});
        upper.assign(count, Block{});
        right.assign(count, Vector{});
    }

    /// The matrix is used up. @pre positive definite
    void solve() {
        const std::size_t count = diagonal.size();
        for (std::size_t i = 0; i < count; ++i) {
            factor(diagonal[i]);
            forward(diagonal[i], right[i]);
            if (i + 1 == count) break;
            forward(diagonal[i], upper[i]);
            subtract(upper[i], right[i], diagonal[i + 1], right[i + 1]);
        }
        for (std::size_t i = count; i-- > 0;) {
            if (i + 1 < count)
                for (std::size_t r = 0; r < kSize; ++r)
                    for (std::size_t c = 0; c < kSize; ++c)
                        right[i].at[r] -= upper[i].at[r][c] * right[i + 1].at[c];
            backward(diagonal[i], right[i]);
        }
    }

  private:
    /// L in the lower half, 1/L_jj on the diagonal.
    static void factor(Block& a) {
        for (std::size_t j = 0; j < kSize; ++j) {
            double d = a.at[j][j];
            for (std::size_t k = 0; k < j; ++k) d -= a.at[j][k] * a.at[j][k];
            const double inverse = 1 / std::sqrt(d);
            a.at[j][j] = inverse;
            for (std::size_t i = j + 1; i < kSize; ++i) {
                double sum = a.at[i][j];
                for (std::size_t k = 0; k < j; ++k) sum -= a.at[i][k] * a.at[j][k];
                a.at[i][j] = sum * inverse;
            }
        }
    }
    static void forward(const Block& l, Vector& b) {
        for (std::size_t r = 0; r < kSize; ++r) {
            for (std::size_t k = 0; k < r; ++k) b.at[r] -= l.at[r][k] * b.at[k];
            b.at[r] *= l.at[r][r];
        }
    }
    static void forward(const Block& l, Block& b) {
        for (std::size_t r = 0; r < kSize; ++r) {
            for (std::size_t k = 0; k < r; ++k)
                for (std::size_t c = 0; c < kSize; ++c) b.at[r][c] -= l.at[r][k] * b.at[k][c];
            for (std::size_t c = 0; c < kSize; ++c) b.at[r][c] *= l.at[r][r];
        }
    }
    static void subtract(const Block& w, const Vector& b, Block& next, Vector& next_right) {
        for (std::size_t k = 0; k < kSize; ++k)
            for (std::size_t r = 0; r < kSize; ++r) {
                const double left = w.at[k][r];
                for (std::size_t c = 0; c < kSize; ++c) next.at[r][c] -= left * w.at[k][c];
                next_right.at[r] -= left * b.at[k];
            }
    }
    static void backward(const Block& l, Vector& b) {
        for (std::size_t r = kSize; r-- > 0;) {
            for (std::size_t k = r + 1; k < kSize; ++k) b.at[r] -= l.at[k][r] * b.at[k];
            b.at[r] *= l.at[r][r];
        }
    }
};

}  // namespace pliant::catheter
