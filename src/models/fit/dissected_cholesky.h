// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cholesky factors of large networks by nested dissection [George1973] and the multifrontal method
// [Duff1983].
//
//        left     │ s │    right          The nodes beside a plane are a separator s: it separates
//     ┌───────────┼───┼───────────┐       left from right. Both sides are eliminated first,
//     │   ──s──   │   │           │       recursively, and s last. Each small part and each
//     │           │   │   ──s──   │       separator is a block of the factor. Its front is a
//     └───────────┴───┴───────────┘       dense matrix over its own unknowns and the later
//                                         unknowns that it is coupled to.
//
// All arithmetic is in dense matrices, whose products are vectorised. For n nodes in three
// dimensions the work grows with n², which is optimal.

#pragma once

#define EIGEN_MPL2_ONLY
#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Dense>
#include <Eigen/SparseCore>

#include <pliant/core/vec.h>

#include <memory>
#include <span>
#include <vector>

namespace pliant {

class DissectedCholesky {
  public:
    /// Nodes of each element.
    using Joined = std::vector<std::vector<std::int32_t>>;

    /// @param positions  positions of all nodes
    /// @param joined  nodes of each link and cell
    /// @param free    [node]: whether the node has unknowns, three each
    DissectedCholesky(std::span<const Vec3d> positions, const Joined& joined,
                      std::span<const std::uint8_t> free);

    /// Position of each free node in the order of elimination; −1 for others. Unknowns are
    /// 3·position + axis.
    const std::vector<int>& order() const { return m_order; }

    using Matrix = Eigen::SparseMatrix<double>;
    /// Determines the fronts' unknowns from the pattern of the reordered lower triangle.
    void analyse(const Matrix& lower);

    using Factor = std::vector<Eigen::MatrixXd>;  ///< [block]: its columns of L
    /// @param least_pivot  relative to the diagonal
    /// @returns null if the matrix isn't positive definite. @pre analyse() of this pattern
    std::unique_ptr<Factor> factor(const Matrix& lower, double least_pivot) const;
    Eigen::VectorXd solve(const Factor& factor, Eigen::VectorXd right) const;

  private:
    struct Block {
        int begin, end;             ///< own unknowns
        std::vector<int> children;  ///< blocks eliminated before
        std::vector<int> rows;      ///< coupled later unknowns, ascending
    };
    struct Graph;
    int dissect(const Graph& graph, std::vector<std::int32_t> nodes, int& next);
    int add_block(std::span<const std::int32_t> nodes, std::vector<int> children, int& next);

    std::vector<int> m_order;
    std::vector<Block> m_blocks;  ///< children before parents
};

}  // namespace pliant
