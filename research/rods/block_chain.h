// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Block tridiagonal symmetric positive definite matrix of 6 × 6 blocks: factored once from one end
// to the other, without fill-in.
//
//   S₀ = A₀₀,  S_{i+1} = A_{i+1,i+1} − Uᵀ S_i⁻¹ U,  U = A_{i,i+1}

#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace pliant::pbd {

inline constexpr std::size_t kBlock = 6;
using Block = std::array<double, kBlock * kBlock>;  ///< by rows
using BlockVector = std::array<double, kBlock>;

class BlockChain {
  public:
    explicit BlockChain(std::size_t count) : diagonal(count), upper(count) {}

    std::vector<Block> diagonal;
    std::vector<Block> upper;  ///< [i] couples i and i + 1

    /// Replaces b by the solution; destroys the matrix. @pre positive definite
    void solve(std::vector<BlockVector>& b) {
        const std::size_t count = diagonal.size();
        for (std::size_t i = 0; i < count; ++i) {
            factor(diagonal[i]);
            if (i + 1 == count) break;
            Block& u = upper[i];
            Block w = u;  // S⁻¹ U
            for (std::size_t c = 0; c < kBlock; ++c) {
                BlockVector column;
                for (std::size_t r = 0; r < kBlock; ++r) column[r] = u[r * kBlock + c];
                substitute(diagonal[i], column);
                for (std::size_t r = 0; r < kBlock; ++r) w[r * kBlock + c] = column[r];
            }
            for (std::size_t r = 0; r < kBlock; ++r)
                for (std::size_t c = 0; c < kBlock; ++c) {
                    double sum = 0;
                    for (std::size_t k = 0; k < kBlock; ++k)
                        sum += u[k * kBlock + r] * w[k * kBlock + c];
                    diagonal[i + 1][r * kBlock + c] -= sum;
                }
            for (std::size_t r = 0; r < kBlock; ++r) {
                double sum = 0;
                for (std::size_t k = 0; k < kBlock; ++k) sum += w[k * kBlock + r] * b[i][k];
                b[i + 1][r] -= sum;
            }
        }
        for (std::size_t i = count; i-- > 0;) {
            if (i + 1 < count)
                for (std::size_t r = 0; r < kBlock; ++r)
                    for (std::size_t k = 0; k < kBlock; ++k)
                        b[i][r] -= upper[i][r * kBlock + k] * b[i + 1][k];
            substitute(diagonal[i], b[i]);
        }
    }

  private:
    /// LDLᵀ in place: L below the diagonal, 1/D on it.
    static void factor(Block& a) {
        for (std::size_t j = 0; j < kBlock; ++j) {
            double d = a[j * kBlock + j];
            double scaled[kBlock];
            for (std::size_t k = 0; k < j; ++k) {
                scaled[k] = a[j * kBlock + k] / a[k * kBlock + k];
                d -= a[j * kBlock + k] * scaled[k];
            }
            const double inverse = 1 / d;
            for (std::size_t i = j + 1; i < kBlock; ++i) {
                double sum = a[i * kBlock + j];
                for (std::size_t k = 0; k < j; ++k) sum -= a[i * kBlock + k] * scaled[k];
                a[i * kBlock + j] = sum * inverse;
            }
            a[j * kBlock + j] = inverse;
        }
    }
    static void substitute(const Block& a, BlockVector& b) {
        for (std::size_t i = 0; i < kBlock; ++i)
            for (std::size_t k = 0; k < i; ++k) b[i] -= a[i * kBlock + k] * b[k];
        for (std::size_t i = 0; i < kBlock; ++i) b[i] *= a[i * kBlock + i];
        for (std::size_t i = kBlock; i-- > 0;)
            for (std::size_t k = i + 1; k < kBlock; ++k) b[i] -= a[k * kBlock + i] * b[k];
    }
};

}  // namespace pliant::pbd
