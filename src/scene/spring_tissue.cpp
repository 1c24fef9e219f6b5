// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scene/spring_tissue.h"

#include <vector>

#include "core/errors.h"
#include "scene/number_file.h"

namespace pliant {
namespace {

constexpr std::size_t kMaxSteps = 200, kMaxBytes = 256'000'000;
constexpr std::uint64_t kMagic = 0x31'70'73'6c'70'00'00'0a;  ///< of a file with a state

}  // namespace

Result<PushReport> SpringScanTissue::push(std::uint32_t tool, const Push& push) {
    return m_model->push(tool, push);
}

Result<GrabReport> SpringScanTissue::grab(std::uint32_t tool, const Push& place, double) {
    m_drag.reset();
    Push still = place;
    still.push_mm = {0, 0, 0};
    const auto report = m_model->push(tool, still);
    if (!report.ok()) return report.error();
    if (report->grabbed_elements > 0) m_drag = Drag{tool, still, {0, 0, 0}};
    return GrabReport{.grabbed_elements = report->grabbed_elements,
                      .pick_ms = report->solve_ms,
                      .message = report->message};
}

Result<PushReport> SpringScanTissue::drag_to(Vec3d offset_mm) {
    if (!m_drag) return Error{ErrorCode::InvalidArgument, "drag: expected a grab before it"};
    Push push = m_drag->place;
    push.point_mm = push.point_mm + m_drag->done_mm;
    push.push_mm = offset_mm - m_drag->done_mm;
    auto report = m_model->push(m_drag->tool, push);
    if (report.ok()) m_drag->done_mm = m_drag->done_mm + report->step_fraction * push.push_mm;
    return report;
}

void SpringScanTissue::let_go() {
    if (m_drag) m_model->let_go(m_drag->tool);
    m_drag.reset();
}

Sweep SpringScanTissue::sweep() {
    const SpringMotion motion = m_model->step(kStepsPerSweep);
    if (motion.active_nodes > 0) m_active_nodes = motion.active_nodes;
    return {motion.settled, motion.solve_ms};
}

void SpringScanTissue::begin_group(const std::string&) {
    m_before = m_model->places_mm();
}

int SpringScanTissue::end_group() {
    if (!m_before || *m_before == m_model->places_mm()) return 0;
    m_undone.clear();
    m_done.push_back(std::move(*m_before));
    m_before.reset();
    int forgotten = 0;
    const std::size_t bytes = m_done.back().size() * sizeof(Vec3d);
    while (m_done.size() > kMaxSteps || m_done.size() * bytes > kMaxBytes) {
        m_done.pop_front();
        ++forgotten;
    }
    return m_done.empty() ? -1 : forgotten;
}

Status SpringScanTissue::undo() {
    if (m_done.empty()) return Error{ErrorCode::NotFound, "undo: expected a step, found none"};
    m_undone.push_back(m_model->places_mm());
    const Places places = std::move(m_done.back());
    m_done.pop_back();
    return m_model->set_places(places);
}

Status SpringScanTissue::redo() {
    if (m_undone.empty()) return Error{ErrorCode::NotFound, "redo: expected a step, found none"};
    m_done.push_back(m_model->places_mm());
    const Places places = std::move(m_undone.back());
    m_undone.pop_back();
    return m_model->set_places(places);
}

Status SpringScanTissue::save_state(const std::filesystem::path& path) const {
    std::vector<double> numbers;
    for (const Vec3d p : m_model->places_mm()) numbers.insert(numbers.end(), {p.x, p.y, p.z});
    return save_numbers(path, kMagic, numbers);
}

Status SpringScanTissue::load_state(const std::filesystem::path& path) {
    const auto numbers = load_numbers(path, kMagic);
    if (!numbers.ok()) return numbers.error();
    const auto count = std::size_t(m_model->control().node_count());
    if (numbers->size() != 3 * count)
        return unreadable(path.filename(), "expected the places of as many control nodes");
    Places places;
    for (std::size_t n = 0; n < numbers->size(); n += 3)
        places.push_back({(*numbers)[n], (*numbers)[n + 1], (*numbers)[n + 2]});
    m_done.clear();
    m_undone.clear();
    return m_model->set_places(places);
}

}  // namespace pliant
