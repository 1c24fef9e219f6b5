// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scene/spring_tissue.h"

#include <iterator>
#include <utility>
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
    Push still = place;
    still.push_mm = {0, 0, 0};
    auto report = m_model->push(tool, still);
    if (!report.ok()) return report.error();
    m_drag.reset();
    if (report->grabbed_elements > 0) m_drag = Drag{tool, still, {0, 0, 0}};
    return GrabReport{.grabbed_elements = report->grabbed_elements,
                      .pick_ms = report->solve_ms,
                      .message = std::move(report->message)};
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

void SpringScanTissue::let_go() noexcept {
    if (m_drag) m_model->let_go(m_drag->tool);
    m_drag.reset();
}

Result<Sweep> SpringScanTissue::sweep() {
    const Result<SpringMotion> motion = m_model->step(kStepsPerSweep);
    if (!motion.ok()) return motion.error();
    if (motion->active_nodes > 0) m_active_nodes = motion->active_nodes;
    return Sweep{motion->settled, motion->solve_ms};
}

void SpringScanTissue::begin_group(const std::string&) {
    Places now = m_model->places_mm();
    m_now.resize(now.size());  // of the group's end
    if (m_before.empty()) m_before.emplace_back();
    m_before.front().swap(now);
}

int SpringScanTissue::end_group() noexcept {
    if (m_before.empty()) return 0;
    m_model->places_mm(m_now);
    if (m_before.front() == m_now) {
        m_before.clear();
        return 0;
    }
    m_undone.clear();
    m_done.splice(m_done.end(), m_before);
    int forgotten = 0;
    const std::size_t bytes = m_done.back().size() * sizeof(Vec3d);
    while (m_done.size() > kMaxSteps || m_done.size() * bytes > kMaxBytes) {
        m_done.pop_front();
        ++forgotten;
    }
    return m_done.empty() ? -1 : forgotten;
}

/// Takes the last of some steps. @param to  those in the other direction
Status SpringScanTissue::go_back(std::list<Places>& from, std::list<Places>& to) {
    Places now = m_model->places_mm();
    if (const Status s = m_model->set_places(from.back()); !s.ok()) return s;
    from.back().swap(now);
    to.splice(to.end(), from, std::prev(from.end()));
    return Ok{};
}

Status SpringScanTissue::undo() {
    if (m_done.empty()) return Error{ErrorCode::NotFound, "undo: expected a step, found none"};
    return go_back(m_done, m_undone);
}

Status SpringScanTissue::redo() {
    if (m_undone.empty()) return Error{ErrorCode::NotFound, "redo: expected a step, found none"};
    return go_back(m_undone, m_done);
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
    if (const Status s = m_model->set_places(places); !s.ok()) return s;
    m_done.clear();
    m_undone.clear();
    return Ok{};
}

}  // namespace pliant
