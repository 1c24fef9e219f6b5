// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scene/chainmail_tissue.h"

#include "core/errors.h"

namespace pliant {

Result<PushReport> ChainMailTissue::push(std::uint32_t tool, const Push& push) {
    auto held = m_model.elements_at(push);
    if (!held.ok()) return held.error();
    std::map<std::uint32_t, Contact> made;  // a node that is inserted without further memory
    made[tool];
    auto report = m_model.push_elements(*held, push.push_mm);
    if (!report.ok()) return report;
    const Vec3d end = push.point_mm + report->step_fraction * push.push_mm;
    made[tool] = {{end, end, push.sphere_radius_mm}, std::move(*held)};
    m_contacts.erase(tool);
    m_contacts.merge(made);
    return report;
}

Result<GrabReport> ChainMailTissue::grab(std::uint32_t tool, const Push& place, double reach_mm) {
    auto report = m_model.grab(place, reach_mm);
    if (report.ok()) m_contacts.erase(tool);
    return report;
}

Result<SlideReport> ChainMailTissue::slide(std::uint32_t tool, const Push& push,
                                           const TissueValues& shown) {
    std::map<std::uint32_t, Contact> made;
    made[tool];
    auto slid = slide_sphere(m_model, push, shown);
    if (!slid.ok()) return slid;
    made[tool] = {{slid->end_mm, slid->end_mm, push.sphere_radius_mm}, {}};
    m_contacts.erase(tool);
    m_contacts.merge(made);
    return slid;
}

void ChainMailTissue::place_eye(std::uint32_t tool, Vec3d place_mm, double radius_mm) {
    if (radius_mm > 0)
        m_eyes[tool] = {place_mm, place_mm, radius_mm};
    else
        m_eyes.erase(tool);
}

Result<Sweep> ChainMailTissue::sweep() {
    RelaxOptions options{.max_sweeps = 1};
    for (const auto& [tool, contact] : m_contacts) {
        if (contact.tool.radius_mm > 0) options.tools.push_back(contact.tool);
        options.held.insert(options.held.end(), contact.held.begin(), contact.held.end());
    }
    for (const auto& [tool, eye] : m_eyes) options.tools.push_back(eye);
    const auto report = m_model.relax(options);
    if (!report.ok() && is_out_of_memory(report.error())) return report.error();
    // Any other error would come again with each sweep.
    if (!report.ok()) return Sweep{};
    return Sweep{report->settled, report->relax_ms};
}

Status ChainMailTissue::reset() {
    m_model.reset();
    m_contacts.clear();
    return Ok{};
}

}  // namespace pliant
