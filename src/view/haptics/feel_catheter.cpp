// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/view/haptics.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace pliant {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
// Dead zone: smaller motions don't move the base. The threshold to start is larger, so that a
// vibrating wire doesn't wake a base at rest.
constexpr double kStill_mm = 0.02, kWakes_mm = 0.06;
constexpr double kLearnt_mm = 0.05;  ///< minimum way for an estimate of the stiffness
constexpr double kStiffest_n_mm = 10;
constexpr double kForgets = 0.8;  ///< decay of an estimate that isn't confirmed, per update
constexpr double kStill_deg = 0.05;

Error bad_feel(const std::string& what) {
    return {ErrorCode::InvalidArgument, "catheter feel: " + what};
}

}  // namespace

Result<CatheterFeel> CatheterFeel::create(const CatheterFeelSettings& settings) {
    CatheterFeelSettings s = settings;
    const double length = norm(s.forward);
    if (!is_finite(s.forward) || !(length > 1e-6)) return bad_feel("forward: expected a direction");
    s.forward = (1 / length) * s.forward;
    const struct {
        const char* name;
        double value, most;
    } numbers[] = {{"coupling_n_m", s.coupling_n_m, 1e5},
                   {"length_mm", s.length_mm, 1e5},
                   {"max_mm_s", s.max_mm_s, 1000},
                   {"max_deg_s", s.max_deg_s, 1e5},
                   {"follow_s", s.follow_s, 1}};
    for (const auto& n : numbers)
        if (!(n.value > 0 && n.value <= n.most))
            return bad_feel(std::string(n.name) + ": expected above 0, at most " +
                            std::to_string(n.most) + ", found " + std::to_string(n.value));
    return CatheterFeel(s);
}

void CatheterFeel::take_hold(Vec3d tool_mm, double roll_rad, const CatheterMeasures& now) {
    m_holds = true;
    m_first_mm = tool_mm;
    m_start_mm = m_known_mm = now.inserted_mm;
    m_start_deg = now.rotated_deg;
    m_roll_deg = kDegrees * roll_rad;
    m_turned_deg = 0;
    m_time_s = now.time_s;
    m_span_s = m_settings.follow_s;
    m_known_n = now.force_n;
    m_wire_n_mm = 0;
    m_moves = false;
}

/// Estimates k_w from the way of the base and the change of its force. A stiffer value is used at
/// once, a softer one gradually, so that the base never overshoots.
void CatheterFeel::learn(const CatheterMeasures& now) {
    const double way = now.inserted_mm - m_known_mm;
    if (std::abs(way) < kLearnt_mm) return;
    const double found = std::clamp((now.force_n - m_known_n) / way, 0.0, kStiffest_n_mm);
    m_wire_n_mm = std::max(found, kForgets * m_wire_n_mm);
    m_known_mm = now.inserted_mm;
    m_known_n = now.force_n;
}

double CatheterFeel::ahead_mm(Vec3d tool_mm, const CatheterMeasures& now) const {
    return m_start_mm + dot(tool_mm - m_first_mm, m_settings.forward) - now.inserted_mm;
}

CatheterFeel::Pull CatheterFeel::pull(Vec3d tool_mm, const CatheterMeasures& now) const {
    const CatheterFeelSettings& c = m_settings;
    const double ahead = ahead_mm(tool_mm, now), reach = c.max_mm_s * m_span_s;
    const double low = std::max(-now.inserted_mm, -reach);
    const double high = std::min(c.length_mm - now.inserted_mm, reach);
    const double coupling = 1e-3 * c.coupling_n_m, both = coupling + m_wire_n_mm;
    const double wanted = (coupling * ahead - now.force_n) / both;
    if (std::abs(wanted) < (m_moves ? kStill_mm : kWakes_mm))
        return {0, now.force_n, coupling * m_wire_n_mm / both};
    // Beyond the base's limits of speed or length, the hand feels the coupling alone; otherwise
    // this is F + k_w (s* − s).
    Pull pull;
    pull.way_mm = std::clamp(wanted, low, high);
    pull.felt_n = coupling * (ahead - pull.way_mm);
    pull.stiffness_n_mm = pull.way_mm == wanted ? coupling * m_wire_n_mm / both : coupling;
    return pull;
}

CatheterFeel::Motion CatheterFeel::follow(Vec3d tool_mm, double roll_rad,
                                          const CatheterMeasures& now) {
    learn(now);
    // The motion until the next call must not exceed the way to go.
    m_span_s = std::max(m_settings.follow_s, 2 * (now.time_s - m_time_s));
    m_time_s = now.time_s;
    const double roll_deg = kDegrees * roll_rad;
    m_turned_deg += std::remainder(roll_deg - m_roll_deg, 360);
    m_roll_deg = roll_deg;
    double turn = m_start_deg + m_turned_deg - now.rotated_deg;
    if (std::abs(turn) < kStill_deg) turn = 0;
    const double most = m_settings.max_deg_s;
    const double way = pull(tool_mm, now).way_mm;
    m_moves = way != 0;
    return {way / m_span_s, std::clamp(turn / m_span_s, -most, most)};
}

HapticModel CatheterFeel::model(Vec3d tool_mm, const CatheterMeasures& now) const {
    HapticModel model;
    if (!m_holds) return model;
    const Vec3d f = m_settings.forward;
    const Pull felt = pull(tool_mm, now);
    model.held = true;
    model.depth_mm = -ahead_mm(tool_mm, now) * f;
    model.anchor_mm = tool_mm + model.depth_mm;
    model.force_n = -felt.felt_n * f;
    const double k = 1000 * felt.stiffness_n_mm;
    for (int a = 0; a < 3; ++a) model.stiffness_n_m.columns[a] = (k * f[a]) * f;
    return model;
}

}  // namespace pliant
