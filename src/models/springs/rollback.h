// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rollback of all positions and velocities. Held nodes, loads and Maxwell branches are the
// caller's.

#pragma once

#include "springs/tissue_impl.h"

namespace pliant {

class SpringRollback {
  public:
    /// Allocates only in the first call.
    void keep(const SpringTissue& tissue) {
        const SpringState& state = tissue.m_impl->current();
        for (std::size_t c = 0; c < 3; ++c) {
            m_x[c] = state.x[c];
            m_before[c] = state.before[c];
        }
    }
    /// @pre keep() was called for a tissue with as many nodes
    void restore(SpringTissue& tissue) noexcept {
        SpringState& state = tissue.m_impl->edited();
        for (std::size_t c = 0; c < 3; ++c) {
            std::copy(m_x[c].begin(), m_x[c].end(), state.x[c].begin());
            std::copy(m_before[c].begin(), m_before[c].end(), state.before[c].begin());
        }
    }

  private:
    std::vector<double> m_x[3], m_before[3];
};

}  // namespace pliant
