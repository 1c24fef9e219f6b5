// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/client.h"

#include <utility>

namespace pliant::serve {

std::vector<Box3i> Delivery::take(std::int64_t max_voxels, std::uint32_t step,
                                  Clock::time_point now) {
    std::vector<Box3i> boxes = m_due.take(max_voxels);
    for (const Box3i& box : boxes) m_sent.mark(box);
    m_is_part = !m_due.empty();
    if (!m_is_part) std::swap(m_due, m_next);
    if (!is_due() && !boxes.empty()) {
        m_unseen.push_back({step, std::exchange(m_sent, DirtyBlocks(m_size)), now});
    }
    return boxes;
}

void Delivery::seen(std::uint32_t step) {
    for (std::size_t n = 0; n < m_unseen.size(); ++n) {
        if (m_unseen[n].step != step) continue;
        m_unseen.erase(m_unseen.begin(), m_unseen.begin() + std::ptrdiff_t(n) + 1);
        m_seen = step;
        return;
    }
}

bool Delivery::come_back(std::optional<std::uint32_t> step) {
    if (step && m_seen != step) seen(*step);
    const bool goes_on = step && m_seen == step;
    if (!goes_on) {
        m_seen.reset();
        m_due.mark_all();
    }
    for (const Unseen& unseen : m_unseen) m_due.mark(unseen.blocks);
    m_due.mark(m_sent);
    m_unseen.clear();
    m_sent.clear();
    return goes_on;
}

}  // namespace pliant::serve
