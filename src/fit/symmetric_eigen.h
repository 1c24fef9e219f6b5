// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Eigenvalues of small symmetric matrices, with one row and column per group.

#pragma once

#include <vector>

namespace pliant {

using SmallMatrix = std::vector<std::vector<double>>;  ///< [row][column]

struct SymmetricEigen {
    std::vector<double> values;  ///< ascending
    SmallMatrix vectors;         ///< [value][component], of length 1
};

/// Jacobi's method [Golub2013], which is accurate for small eigenvalues beside large ones.
SymmetricEigen symmetric_eigen(SmallMatrix matrix);

}  // namespace pliant
