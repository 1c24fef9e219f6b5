// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/wire.h"

#include <algorithm>
#include <cmath>

namespace pliant::catheter {

double WireContact::touch(Vec3d position, Vec3d slid) {
    force = {0, 0, 0};
    const double depth = least + dot(normal, yielded) - dot(normal, position);
    const double push = pushed + depth / compliance;
    if (!(push > 0)) return 0;
    slid = slid - dot(slid, normal) * normal;
    const double drag = friction * push / std::max(norm(slid), sticking_mm);
    // The wall has gone with the last friction, and goes with the difference to the new one.
    const double in_series = drag / (1 + drag * wall_compliance);
    force = push * normal - in_series * (slid - wall_compliance * dragged);
    return in_series;
}

Wire::Wire(const WireSettings& settings, double inserted_mm)
    : m_settings(settings), m_count(std::size_t(settings.segments)) {
    m_v.assign(m_count + 1, {0, 0, 0});
    feed(inserted_mm, 0);
    const Vec3d axis = rotated(settings.frame, {0, 0, 1});
    for (std::size_t n = 0; n <= m_count; ++n) m_x.push_back(settings.entry + fed_mm(n) * axis);
    m_old_x = m_x;
}

void Wire::feed(double inserted_mm, double turned_rad) {
    m_inserted = inserted_mm;
    m_turned = turned_rad;
    const double outside = double(m_count) - inserted_mm / m_settings.segment_mm;
    m_first = std::int32_t(std::clamp(std::floor(outside), 0.0, double(m_count)));
}

double Wire::guide_end() const {
    return double(m_count - std::size_t(m_first)) - m_inserted / m_settings.segment_mm;
}

void Wire::add_to(Hash64& hash) const {
    hash.add(std::span<const Vec3d>(m_x));
    hash.add(std::span<const Vec3d>(m_v));
}

void Wire::exchange(StateNumbers& state) {
    state.value(m_inserted);
    state.value(m_turned);
    state.positions(m_x);
    state.positions(m_v);
    feed(m_inserted, m_turned);
    m_old_x = m_x;
}

}  // namespace pliant::catheter
