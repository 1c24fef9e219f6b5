// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/published_ordering.h"

#include <algorithm>

#include "chains/graph_limits.h"

namespace pliant {

PublishedOrdering::PublishedOrdering(std::vector<Bounds> bounds)
    : m_u(bounds.size(), Vec3d{0, 0, 0}), m_moved(bounds.size(), 0), m_bounds(std::move(bounds)) {}

void PublishedOrdering::reset() {
    std::fill(m_u.begin(), m_u.end(), Vec3d{0, 0, 0});
}

bool PublishedOrdering::move(std::int32_t element, Vec3d to) {
    const auto e = std::size_t(element);
    if (!m_moved[e]) {
        m_moved[e] = 1;
        m_previous.push_back({element, m_u[e]});
    }
    m_u[e] = to;
    return !m_bounds[e].fixed && norm(to) <= double(m_bounds[e].max_movement_mm);
}

bool PublishedOrdering::count_candidate() {
    return ++m_candidates < m_max_candidates;
}

bool PublishedOrdering::attempt(std::span<const std::int32_t> elements, Vec3d step_mm) {
    for (const std::int32_t element : elements) {
        if (is_initial(element)) continue;  // a duplicate
        if (!move(element, u(element) + step_mm)) return false;
        m_moved[std::size_t(element)] = kInitial;
    }
    return propagate(elements);
}

void PublishedOrdering::go_back() {
    for (const Previous& previous : m_previous) m_u[std::size_t(previous.element)] = previous.u;
}

OrderingReport PublishedOrdering::push(std::span<const std::int32_t> elements, Vec3d push_mm) {
    OrderingReport report;
    const auto is_there = [&](std::int32_t e) { return e >= 0 && std::size_t(e) < m_u.size(); };
    if (!is_finite(push_mm) || norm(push_mm) > kMaxMovementMm ||
        !std::all_of(elements.begin(), elements.end(), is_there))
        return report;
    m_candidates = 0;
    m_max_candidates = kMaxTakingsPerElement * std::int64_t(m_u.size());
    double fraction = 1;
    for (int halvings = 0; halvings <= kMaxHalvings; ++halvings, fraction /= 2) {
        const bool permitted = attempt(elements, mm_from_units(units_from_mm(fraction * push_mm)));
        report.stopped_early = m_candidates >= m_max_candidates;
        const bool done = permitted || report.stopped_early;
        if (!done) go_back();
        for (const Previous& previous : m_previous) m_moved[std::size_t(previous.element)] = 0;
        if (done) {
            report.status = halvings == 0 ? PushStatus::Applied : PushStatus::Limited;
            report.step_fraction = fraction;
            report.moved_elements = std::int64_t(m_previous.size());
        }
        m_previous.clear();
        if (done) break;
    }
    report.candidates = m_candidates;
    return report;
}

}  // namespace pliant
