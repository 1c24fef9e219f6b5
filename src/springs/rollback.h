// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Takes back that nodes were held and moved, before a step was made: nodes keep the velocity that
// they had.

#pragma once

#include "springs/tissue_impl.h"

namespace pliant {

class SpringRollback {
  public:
    /// @param nodes  that are going to be held and moved
    SpringRollback(SpringTissue& tissue, std::span<const std::int32_t> nodes)
        : m_impl(*tissue.m_impl), m_nodes(nodes.begin(), nodes.end()) {
        const SpringState& state = m_impl.current();
        m_places.reserve(2 * nodes.size());
        for (const std::int32_t n : nodes) {
            m_places.push_back(state.place(n));
            m_places.push_back(state.place_before(n));
        }
    }
    /// @pre the nodes that were held before are held again
    void restore() noexcept {
        for (std::size_t k = 0; k < m_nodes.size(); ++k) {
            m_impl.state.put(m_nodes[k], m_places[2 * k]);
            m_impl.state.put_before(m_nodes[k], m_places[2 * k + 1]);
        }
    }

  private:
    SpringTissue::Impl& m_impl;
    std::vector<std::int32_t> m_nodes;
    std::vector<Vec3d> m_places;  ///< now and before
};

}  // namespace pliant
