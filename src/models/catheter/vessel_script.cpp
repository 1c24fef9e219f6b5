// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The acts of a scene file: commands, and the bounds at which they end.

#include <pliant/models/catheter.h>

#include <numbers>

#include "base/hypot.h"

namespace pliant {

VesselScript::VesselScript(const VesselFile& file, const std::vector<Vec3d>& way)
    : m_acts(file.acts),
      m_pilot(way, file.ahead_mm, file.gain, file.max_deg),
      m_has_way(way.size() > 1) {}

double VesselScript::way_mm(const CatheterScene& scene) const {
    return m_has_way ? m_pilot.progress_mm(scene.tip_mm()) : 0;
}

double VesselScript::progress() const {
    return m_acts.empty() ? 1 : double(m_act) / double(m_acts.size());
}

bool VesselScript::next(const CatheterScene& scene, CatheterCommand& command) {
    const CatheterMeasures now = scene.quick_measures();
    while (m_act < m_acts.size() && is_over(scene, now)) {
        ++m_act;
        m_began = now;
        m_began_way = way_mm(scene);
    }
    if (m_act == m_acts.size()) return false;
    const VesselAct& act = m_acts[m_act];
    if (act.follow) {
        command.insert_mm_s = act.command.insert_mm_s;
        command.rotate_deg_s = act.command.rotate_deg_s;
        m_pilot.steer(scene, command);
    } else {
        command = act.command;
    }
    return true;
}

bool VesselScript::is_over(const CatheterScene& scene, const CatheterMeasures& now) const {
    const VesselAct& act = m_acts[m_act];
    if (act.for_s && now.time_s - m_began.time_s >= *act.for_s - 1e-9) return true;
    const auto passed = [](double from, double at, double to) {
        return from <= to ? at >= to : at <= to;
    };
    if (act.until_inserted_mm &&
        passed(m_began.inserted_mm, now.inserted_mm, *act.until_inserted_mm))
        return true;
    return act.until_way_mm && passed(m_began_way, way_mm(scene), *act.until_way_mm);
}

// Bends the tip's rest shape about its two transverse axes by a share of the angle between the
// tip's direction and the path ahead. The bends integrate the remaining angle, within bounds
// (integral control).

WayPilot::WayPilot(std::vector<Vec3d> way_mm, double ahead_mm, double gain, double max_deg)
    : m_way(std::move(way_mm)), m_ahead(ahead_mm), m_gain(gain), m_most(max_deg) {
    double sum = 0;
    for (std::size_t n = 0; n < m_way.size(); ++n) {
        if (n > 0) sum += norm(m_way[n] - m_way[n - 1]);
        m_length.push_back(sum);
    }
}

Vec3d WayPilot::at(double length_mm) const {
    const auto after = std::upper_bound(m_length.begin(), m_length.end(), length_mm);
    if (after == m_length.begin()) return m_way.front();
    if (after == m_length.end()) {  // extrapolate
        const std::size_t n = m_way.size();
        if (n < 2) return m_way.back();
        return m_way[n - 1] +
               (length_mm - m_length[n - 1]) * normalized(m_way[n - 1] - m_way[n - 2]);
    }
    const auto n = std::size_t(after - m_length.begin());
    const double t = (length_mm - m_length[n - 1]) / (m_length[n] - m_length[n - 1]);
    return (1 - t) * m_way[n - 1] + t * m_way[n];
}

double WayPilot::progress_mm(Vec3d tip_mm) const {
    double least = 1e300, found = 0;
    for (std::size_t n = 1; n < m_way.size(); ++n) {
        const Vec3d a = m_way[n - 1], u = m_way[n] - a;
        const double t = std::clamp(dot(tip_mm - a, u) / std::max(1e-12, dot(u, u)), 0.0, 1.0);
        const double distance = norm(tip_mm - (a + t * u));
        if (!(distance < least)) continue;
        least = distance;
        found = m_length[n - 1] + t * (m_length[n] - m_length[n - 1]);
    }
    return found;
}

void WayPilot::steer(const CatheterScene& scene, CatheterCommand& command) {
    if (m_way.size() < 2) return;
    const Vec3d tip = scene.tip_mm();
    const Rotation q = scene.tip_frame();
    const Vec3d wish = at(progress_mm(tip) + m_ahead) - tip;
    const Vec3d local{dot(wish, rotated(q, {1, 0, 0})), dot(wish, rotated(q, {0, 1, 0})),
                      dot(wish, rotated(q, {0, 0, 1}))};
    const double across = hypot(local.x, local.y);
    if (!(across > 1e-9)) return;
    const double off = std::atan2(across, local.z) * 180 / std::numbers::pi;
    // Slow like a hand: the error is corrected over some tenths of a second.
    const double share = m_gain * off * scene.settings().time_step_s * 10;
    m_first += share * local.x / across;
    m_second += share * local.y / across;
    const double size = hypot(m_first, m_second);
    if (size > m_most) {
        m_first *= m_most / size;
        m_second *= m_most / size;
    }
    command.bend_first_deg = m_first;
    command.bend_second_deg = m_second;
}

}  // namespace pliant
