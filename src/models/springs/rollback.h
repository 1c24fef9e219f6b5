// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rollback of holding and moving nodes before a step: nodes keep their previous velocity.

#pragma once

#include "springs/tissue_impl.h"

namespace pliant {

class SpringRollback {
  public:
    /// @param nodes  to be held and moved
    SpringRollback(SpringTissue& tissue, std::span<const std::int32_t> nodes)
        : m_impl(*tissue.m_impl), m_nodes(nodes.begin(), nodes.end()) {
        const SpringState& state = m_impl.current();
        m_positions.reserve(2 * nodes.size());
        for (const std::int32_t n : nodes) {
            m_positions.push_back(state.place(n));
            m_positions.push_back(state.place_before(n));
        }
    }
    /// @pre the previously held nodes are held again
    void restore() noexcept {
        for (std::size_t k = 0; k < m_nodes.size(); ++k) {
            m_impl.state.put(m_nodes[k], m_positions[2 * k]);
            m_impl.state.put_before(m_nodes[k], m_positions[2 * k + 1]);
        }
    }

  private:
    SpringTissue::Impl& m_impl;
    std::vector<std::int32_t> m_nodes;
    std::vector<Vec3d> m_positions;  ///< current and previous positions
};

}  // namespace pliant
