// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Factor of the free part of a stiffness matrix. Its source is the only user of Eigen.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <memory>

#include "fem/block_matrix.h"
#include "fem/held_nodes.h"

namespace pliant {

class CholeskyFactor {
  public:
    /// @returns InvalidArgument if the matrix is singular, LimitExceeded if memory is short
    static Result<CholeskyFactor> create(const BlockMatrix& matrix, const HeldNodes& held);
    ~CholeskyFactor();
    CholeskyFactor(CholeskyFactor&&) noexcept;
    CholeskyFactor& operator=(CholeskyFactor&&) noexcept;

    /// Solves; zero in held components.
    NodeVector solve(const NodeVector& force) const;
    std::int64_t bytes() const;

  private:
    struct Impl;
    explicit CholeskyFactor(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
