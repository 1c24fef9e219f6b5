// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Eigenvalues of small symmetric matrices, one row and column for each group.

#pragma once

#include <vector>

namespace pliant {

using SmallMatrix = std::vector<std::vector<double>>;  ///< [row][column]

struct SymmetricEigen {
    std::vector<double> values;  ///< ascending
    SmallMatrix vectors;         ///< [value][component], of length 1
};

/// By Jacobi's rotations [Golub2013], which find small eigenvalues beside large ones.
SymmetricEigen symmetric_eigen(SmallMatrix matrix);

}  // namespace pliant
