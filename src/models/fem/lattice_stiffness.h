// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Matrix-free stiffness of a regular lattice.
//
// On a box, the trilinear element is a tensor product of three one-dimensional elements. Convert
// the values at the two ends of each to their sum s and difference d (three times two additions for
// eight corners). Then u = s/2 + d·(ξ − ½) on 0 ≤ ξ ≤ 1, and with length h
//
//   ∫ v u = h (v_s u_s / 4 + v_d u_d / 12),   ∫ v′ u′ = v_d u_d / h,   ∫ v′ u = v_d u_s / 2:
//
// which is nearly diagonal. Of the element's 576 numbers 21 + 24 remain, each λ or μ times a number
// of the lattice, and a cell costs 256 operations instead of 1152. Each cell may have a separate λ
// and μ. The result is exact up to rounding, like 2×2×2 Gauss points on a box.
//
// Cells of a row are adjacent in vector registers. A task owns some planes of nodes and computes
// all cells at them, so writes never conflict, and each node sums its cells in the same order for
// every partition. There are no fused multiplications, so the bits are equal on every instruction
// set.

#pragma once

#include <pliant/models/fem.h>

#include <vector>

#include "fem/stiffness.h"

namespace pliant {

/// Constants of a kernel for one box.
struct LatticeFactors {
    double mode[8];  ///< factor of μ: Σ of `along` over the axes
    double along[3][8];  ///< factor of λ + μ: ∫ ∂_a v ∂_a u for mode m = (d along x) + 2 (y) + 4
                         ///< (z)
    double across[3][2];  ///< factor of λ and μ: a quarter of ∫ v u along axis c for s and d
};
LatticeFactors lattice_factors(Vec3d spacing);

class LatticeStiffness : public Stiffness {
  public:
    /// @pre the solid has been checked
    explicit LatticeStiffness(const ElasticLattice& solid);
    /// @param lambda, mu  [cell]
    LatticeStiffness(const HexLattice& lattice, std::vector<double> lambda, std::vector<double> mu);

    void multiply(const NodeVector& displacement, NodeVector& force,
                  const TaskArena& arena) const override;
    Block3 diagonal_block(std::int32_t node) const override;
    std::int64_t bytes() const override;

    const HexLattice& lattice() const { return m_lattice; }
    /// Stiffness of layers of cells, those between the planes of a lattice.
    /// @param low  its first plane
    LatticeStiffness slab(const HexLattice& part, int low) const;
    /// λ and μ of the first cells.
    std::vector<double> lambdas(std::int64_t cells) const { return first_of(m_lambda, cells); }
    std::vector<double> mus(std::int64_t cells) const { return first_of(m_mu, cells); }

  private:
    void find_corner_blocks();
    std::vector<double> first_of(const std::vector<double>& values, std::int64_t cells) const {
        if (m_uniform) return std::vector<double>(std::size_t(cells), values[0]);
        return {values.begin(), values.begin() + cells};
    }
    void add_layer(const NodeVector& u, NodeVector& f, int k, int begin, int end,
                   double* workspace) const;

    HexLattice m_lattice;
    LatticeFactors m_factors;
    bool m_uniform;
    std::vector<double> m_lambda, m_mu;  ///< [cell], or one row of cells for uniform materials
    Block3 m_corner_lambda[8], m_corner_mu[8];  ///< diagonal blocks of a cell for λ = 1, μ = 1
};

/// One row of cells, and the four rows of nodes around it.
struct LatticeRow {
    const double* displacement[3][4];  ///< [component][node row: +1 along y, +2 along z]
    double* force[3][4];               ///< accumulated; null: not wanted
    const double *lambda, *mu;         ///< [cell]
    int cells;
    double* workspace;  ///< lattice_row_workspace(cells) numbers
};
constexpr std::size_t lattice_row_room(int cells) {
    return std::size_t(cells) + 2 * 8 + 1;
}
constexpr std::size_t lattice_row_workspace(int cells) {
    return 2 * lattice_row_room(cells) * 12;
}

void add_lattice_row(const LatticeFactors& factors, const LatticeRow& row);
/// Scalar version.
void add_lattice_row_plain(const LatticeFactors& factors, const LatticeRow& row);

}  // namespace pliant
