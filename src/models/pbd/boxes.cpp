// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tetrahedron belongs to a box if its bounding box intersects the expanded box. A particle is
// movable while all of its tetrahedra are active, so held particles surround the active part.

#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"

namespace pliant {
namespace {

template <class Body>
void for_each_box(Vec3i low, Vec3i high, const Body& body) {
    for (int k = low.z; k <= high.z; ++k)
        for (int j = low.y; j <= high.y; ++j)
            for (int i = low.x; i <= high.x; ++i) body(Vec3i{i, j, k});
}

Error wrong() {
    return invalid("state: expected one of these boxes");
}

}  // namespace

Vec3i PbdBoxes::box_at(Vec3d position) const {
    Vec3i box{};
    for (int c = 0; c < 3; ++c)
        box[c] = int(std::clamp(std::floor((position[c] - m_low[c]) / m_settings.side), 0.0,
                                double(m_counts[c] - 1)));
    return box;
}
std::int32_t PbdBoxes::linear_index(Vec3i box) const {
    return box.x + m_counts.x * (box.y + m_counts.y * box.z);
}
std::span<const std::int32_t> PbdBoxes::tetrahedra(std::int32_t box) const {
    const auto b = std::size_t(box);
    return std::span<const std::int32_t>(m_held).subspan(
        std::size_t(m_starts[b]), std::size_t(m_starts[b + 1] - m_starts[b]));
}
bool PbdBoxes::is_active(std::int32_t box) const {
    return m_is_active[std::size_t(box)] != 0;
}

Result<PbdBoxes> PbdBoxes::create(const TetMesh& mesh, const PbdBoxSettings& settings) {
    if (mesh.nodes_mm.empty()) return invalid("mesh: expected nodes, found none");
    if (const Status s = check_cells(mesh); !s.ok()) return invalid("mesh: " + s.error().message);
    if (const Status s = check(settings, pbd_box_rows()); !s.ok()) return s.error();
    PbdBoxes made;
    made.m_settings = settings;
    if (settings.span < 0) made.m_settings.span = settings.side / 3;
    made.m_rest = mesh.nodes_mm;
    made.m_cells = mesh.cells;
    Vec3d low = mesh.nodes_mm[0], high = low;
    for (const Vec3d& p : mesh.nodes_mm)
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], p[c]);
            high[c] = std::max(high[c], p[c]);
        }
    made.m_low = low;
    double all = 1;
    for (int c = 0; c < 3; ++c) {
        const double count = std::max(1.0, std::ceil((high[c] - low[c]) / settings.side));
        all *= count;
        if (!(all <= double(1 << 24)))
            return Error{ErrorCode::LimitExceeded,
                         "side: makes more than 16777216 boxes, expected fewer"};
        made.m_counts[c] = int(count);
    }
    const auto boxes = std::size_t(all);
    made.m_is_active.assign(boxes, 0);
    made.m_is_wanted.assign(boxes, 0);

    // Counting sort: the tetrahedra of a box are ascending.
    const Vec3d span{made.m_settings.span, made.m_settings.span, made.m_settings.span};
    const auto of_tetrahedron = [&](std::size_t t, const auto& body) {
        Vec3d from = mesh.nodes_mm[std::size_t(mesh.cells[t][0])], to = from;
        for (const std::int32_t n : mesh.cells[t])
            for (int c = 0; c < 3; ++c) {
                from[c] = std::min(from[c], mesh.nodes_mm[std::size_t(n)][c]);
                to[c] = std::max(to[c], mesh.nodes_mm[std::size_t(n)][c]);
            }
        for_each_box(made.box_at(from - span), made.box_at(to + span),
                     [&](Vec3i box) { body(std::size_t(made.linear_index(box))); });
    };
    const auto sum_up = [](std::vector<std::int32_t>& starts) {
        std::int32_t sum = 0;
        for (std::int32_t& start : starts) start = sum += start;
        return std::size_t(sum);
    };
    made.m_starts.assign(boxes + 1, 0);
    for (std::size_t t = 0; t < mesh.cells.size(); ++t)
        of_tetrahedron(t, [&](std::size_t box) { ++made.m_starts[box]; });
    made.m_held.resize(sum_up(made.m_starts));
    for (std::size_t t = mesh.cells.size(); t-- > 0;)
        of_tetrahedron(t, [&](std::size_t box) {
            made.m_held[std::size_t(--made.m_starts[box])] = std::int32_t(t);
        });

    made.m_active_of.assign(mesh.cells.size(), 0);
    made.m_asleep.assign(mesh.nodes_mm.size(), 0);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t n : cell) ++made.m_asleep[std::size_t(n)];
    made.m_blends.reserve(mesh.nodes_mm.size());
    made.m_kept_blends.reserve(mesh.nodes_mm.size());
    return made;
}

void PbdBoxes::mark_around(std::span<const Vec3d> positions, double reach) {
    std::fill(m_is_wanted.begin(), m_is_wanted.end(), std::uint8_t(0));
    const Vec3d around{reach, reach, reach};
    for (const Vec3d& p : positions)
        for_each_box(box_at(p - around), box_at(p + around),
                     [&](Vec3i box) { m_is_wanted[std::size_t(linear_index(box))] = 1; });
}

Status PbdBoxes::wake(std::size_t box, bool active, PbdBody& body) {
    m_is_active[box] = active;
    m_active_boxes += active ? 1 : -1;
    for (const std::int32_t t : tetrahedra(std::int32_t(box))) {
        std::int32_t& count = m_active_of[std::size_t(t)];
        const bool changes = active ? count++ == 0 : --count == 0;
        if (!changes) continue;
        m_active_tetrahedra += active ? 1 : -1;
        for (const std::int32_t n : m_cells[std::size_t(t)]) {
            std::int32_t& asleep = m_asleep[std::size_t(n)];
            if (active) {
                if (--asleep == 0) m_blends.push_back({n, 0});
            } else if (asleep++ == 0) {
                if (const Status s = body.set_inverse_mass(n, 0); !s.ok()) return s;
                std::erase_if(m_blends, [&](const Blend& b) { return b.particle == n; });
            }
        }
    }
    return Ok{};
}

bool PbdBoxes::is_settled(std::size_t box, const PbdBody& body) const {
    for (const std::int32_t t : tetrahedra(std::int32_t(box)))
        for (const std::int32_t n : m_cells[std::size_t(t)])
            if (norm(body.position(n) - m_rest[std::size_t(n)]) > m_settings.settled) return false;
    return true;
}

Status PbdBoxes::update(std::span<const Vec3d> positions, double reach, PbdBody& body) {
    if (std::size_t(body.particle_count()) != m_rest.size())
        return invalid("update: expected a body of " + std::to_string(m_rest.size()) +
                       " particles, found " + std::to_string(body.particle_count()));
    if (!(std::isfinite(reach) && reach >= 0)) return invalid("reach: expected 0 or more");
    for (const Vec3d& p : positions)
        if (!is_finite(p)) return invalid("update: expected positions of three numbers");
    const Status listed = attempt([&]() -> Status {
        m_blends.reserve(m_rest.size());
        mark_around(positions, reach);
        m_changed_count = 0;
        m_changed.clear();
        for (std::size_t box = 0; box < m_is_active.size(); ++box) {
            const bool wanted = m_is_wanted[box] != 0, active = m_is_active[box] != 0;
            if (wanted == active || (active && !is_settled(box, body))) continue;
            m_changed.push_back(std::int32_t(box));
        }
        return Ok{};
    });
    if (!listed.ok()) return listed;
    // No allocation from here on.
    if (!m_has_begun)
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            if (const Status s = body.set_inverse_mass(n, 0); !s.ok()) return s;
    m_has_begun = true;
    for (const std::int32_t box : m_changed) {
        ++m_changed_count;
        if (const Status s = wake(std::size_t(box), !is_active(box), body); !s.ok()) return s;
    }
    return blend_in(body);
}

Status PbdBoxes::blend_in(PbdBody& body) {
    for (Blend& blend : m_blends) {
        ++blend.age;
        const double share = double(blend.age) / m_settings.blend_steps;
        const double whole = body.parts().inverse_masses[std::size_t(blend.particle)];
        if (const Status s = body.set_inverse_mass(blend.particle, share * whole); !s.ok())
            return s;
    }
    std::erase_if(m_blends, [&](const Blend& b) { return b.age >= m_settings.blend_steps; });
    return Ok{};
}

void PbdBoxes::keep() noexcept {
    m_kept_begun = m_has_begun;
    m_kept_blends = m_blends;
    m_changed_count = 0;
}

void PbdBoxes::take_back() noexcept {
    while (m_changed_count > 0) {
        const std::int32_t box = m_changed[--m_changed_count];
        const bool active = !is_active(box);
        m_is_active[std::size_t(box)] = active;
        m_active_boxes += active ? 1 : -1;
        for (const std::int32_t t : tetrahedra(box)) {
            std::int32_t& count = m_active_of[std::size_t(t)];
            if (active ? count++ != 0 : --count != 0) continue;
            m_active_tetrahedra += active ? 1 : -1;
            for (const std::int32_t n : m_cells[std::size_t(t)])
                m_asleep[std::size_t(n)] += active ? -1 : 1;
        }
    }
    m_blends = m_kept_blends;
    m_has_begun = m_kept_begun;
}

// State of boxes as numbers: the number of active boxes, the boxes, then pairs of a particle in
// transition from held to movable and its age.

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
