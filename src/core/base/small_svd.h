// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Singular values of 3×3 and 4×4 matrices in single precision by LINPACK's SSVDC [Dongarra1979]:
// Householder reflections to a bidiagonal matrix, then shifted QR steps [Golub1970]. Each operation
// is rounded as in the original, because nifti_placement.cpp replicates a decision that depends on
// the last bits.

#pragma once

#include <array>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Columns of an N×N matrix.
template <int N>
using SmallMatrix = std::array<std::array<float, N>, N>;

/// matrix = u · diag(values) · vᵀ, values descending.
template <int N>
struct SmallSvd {
    SmallMatrix<N> u{}, v{};
    std::array<float, N> values{};

    explicit SmallSvd(SmallMatrix<N> matrix);
    /// v · diag(1/values) · uᵀ; zero values count as infinite.
    SmallMatrix<N> inverse() const;
};

extern template struct SmallSvd<3>;
extern template struct SmallSvd<4>;

}  // namespace pliant
#pragma GCC visibility pop
