// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of boxes as numbers: the number of active boxes, the boxes, then pairs of a particle in
// transition from held to movable and its age.

#include <pliant/models/pbd.h>

#include <utility>
#include <vector>

#include "base/errors.h"

namespace pliant {
namespace {

Error wrong() {
    return invalid("state: expected one of these boxes");
}

}  // namespace

std::vector<std::int32_t> PbdBoxes::state() const {
    std::vector<std::int32_t> state{m_active_boxes};
    for (std::size_t box = 0; box < m_is_active.size(); ++box)
        if (m_is_active[box]) state.push_back(std::int32_t(box));
    for (const Blend& blend : m_blends) {
        state.push_back(blend.particle);
        state.push_back(blend.age);
    }
    return state;
}

/// Checks that boxes are valid and ascending, and that all tetrahedra of each particle are in them.
Status PbdBoxes::check_state(std::span<const std::int32_t> boxes,
                             std::span<const std::int32_t> blends) const {
    for (std::size_t n = 0; n < boxes.size(); ++n)
        if (boxes[n] < 0 || std::size_t(boxes[n]) >= m_is_active.size() ||
            (n > 0 && boxes[n] <= boxes[n - 1]))
            return wrong();
    std::vector<std::uint8_t> is_active(m_cells.size(), 0), is_taken(m_rest.size(), 0);
    for (const std::int32_t box : boxes)
        for (const std::int32_t t : tetrahedra(box)) is_active[std::size_t(t)] = 1;
    for (std::size_t t = 0; t < m_cells.size(); ++t)
        for (const std::int32_t n : m_cells[t])
            if (!is_active[t]) is_taken[std::size_t(n)] = 1;
    for (std::size_t n = 0; n < blends.size(); n += 2) {
        if (blends[n] < 0 || std::size_t(blends[n]) >= m_rest.size() || blends[n + 1] < 0 ||
            blends[n + 1] >= m_settings.blend_steps)
            return wrong();
        if (std::exchange(is_taken[std::size_t(blends[n])], std::uint8_t(1))) return wrong();
    }
    return Ok{};
}

Status PbdBoxes::restore(std::span<const std::int32_t> state, PbdBody& body) {
    if (body.particle_count() != std::int32_t(m_rest.size())) return wrong();
    if (state.empty() || state[0] < 0 || std::size_t(state[0]) > state.size() - 1) return wrong();
    const auto boxes = state.subspan(1, std::size_t(state[0])),
               blends = state.subspan(1 + boxes.size());
    if (blends.size() % 2) return wrong();
    if (const Status s = check_state(boxes, blends); !s.ok()) return s;
    m_blends.reserve(m_rest.size());
    // The rest can't fail.
    m_changed_count = 0;
    for (std::int32_t n = 0; n < body.particle_count(); ++n)
        if (const Status s = body.set_inverse_mass(n, 0); !s.ok()) return s;
    m_has_begun = true;
    for (std::size_t box = 0; box < m_is_active.size(); ++box)
        if (m_is_active[box])
            if (const Status s = wake(box, false, body); !s.ok()) return s;
    for (const std::int32_t box : boxes)
        if (const Status s = wake(std::size_t(box), true, body); !s.ok()) return s;
    // All particles are in transition now; those that had completed it get their full mass.
    for (const Blend& blend : m_blends)
        if (const Status s = body.set_inverse_mass(
                blend.particle, body.parts().inverse_masses[std::size_t(blend.particle)]);
            !s.ok())
            return s;
    m_blends.clear();
    for (std::size_t n = 0; n < blends.size(); n += 2) {
        const auto particle = std::size_t(blends[n]);
        m_blends.push_back({blends[n], blends[n + 1]});
        const double share = double(blends[n + 1]) / m_settings.blend_steps;
        if (const Status s =
                body.set_inverse_mass(blends[n], share * body.parts().inverse_masses[particle]);
            !s.ok())
            return s;
    }
    return Ok{};
}

}  // namespace pliant
