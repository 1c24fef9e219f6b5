// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The acts of a scene file: commands, and the bounds at which they end.

#include <pliant/models/catheter.h>

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

}  // namespace pliant
