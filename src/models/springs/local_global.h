// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Backward Euler by a matrix factored once [Liu2013]. For fixed directions n of the links, the
// energy is quadratic with a constant matrix. So steps alternate between directions (local) and
//
//   (M/h² + D/h + Σ k) x = M/h² (x_t + h v_t) + D/h x_t + F + Σ k l n      (global)

#pragma once

#include <memory>

#include "springs/state.h"

namespace pliant {

class LocalGlobal {
  public:
    LocalGlobal();
    ~LocalGlobal();
    LocalGlobal(LocalGlobal&&) noexcept;
    LocalGlobal& operator=(LocalGlobal&&) noexcept;

    /// Factors, unless the same nodes moved before. @returns LimitExceeded on failure
    Status prepare(const SpringNetwork& network, const SpringState& state, double time_step);
    void step(const SpringNetwork& network, SpringState& state, double time_step,
              std::int32_t iterations);
    /// Discards the factor after a cut.
    void forget();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
