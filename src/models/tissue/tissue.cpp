// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/tissue.h>

#include <utility>

#include "base/errors.h"

namespace pliant {
namespace {

Error not_supported(std::string_view command, const Tissue& tissue) {
    return {ErrorCode::Unsupported, std::string(command) + ": expected another tissue than " +
                                        std::string(tissue.traits().model)};
}

}  // namespace

Result<GrabReport> Tissue::grab(std::uint32_t tool, const Push& position, double) noexcept {
    return attempt([&]() -> Result<GrabReport> {
        Push still = position;
        still.push_mm = {0, 0, 0};
        Result<PushReport> report = push(tool, still);
        if (!report) return report.error();
        m_drag.reset();
        if (report->grabbed_elements > 0) m_drag = Drag{tool, still};
        return GrabReport{.grabbed_elements = report->grabbed_elements,
                          .grab_ms = report->solve_ms,
                          .message = std::move(report->message)};
    });
}

Result<PushReport> Tissue::drag_to(Vec3d offset_mm) noexcept {
    return attempt([&]() -> Result<PushReport> {
        if (!m_drag) return invalid("drag: expected a grab before it");
        Push rest = m_drag->position;
        rest.point_mm = rest.point_mm + m_drag->done_mm;
        rest.push_mm = offset_mm - m_drag->done_mm;
        Result<PushReport> report = push(m_drag->tool, rest);
        if (report) m_drag->done_mm = m_drag->done_mm + report->step_fraction * rest.push_mm;
        return report;
    });
}

void Tissue::let_go() noexcept {
    if (m_drag) release(m_drag->tool);
    m_drag.reset();
}

Result<SlideReport> Tissue::slide(std::uint32_t, const Push&, const TissueValues&) noexcept {
    return attempt([&]() -> Result<SlideReport> { return not_supported("slide", *this); });
}

Result<CutReport> Tissue::cut(const CutSurface&) noexcept {
    return attempt([&]() -> Result<CutReport> { return not_supported("cut", *this); });
}

Result<CarveReport> Tissue::carve(const CarveTool&) noexcept {
    return attempt([&]() -> Result<CarveReport> { return not_supported("carve", *this); });
}

Status Tissue::place_eye(std::uint32_t, Vec3d, double) noexcept {
    return Ok{};
}

bool Tissue::has_eye(std::uint32_t) const noexcept {
    return false;
}

std::optional<Vec3d> Tissue::force_n(std::uint32_t) noexcept {
    return {};
}

Result<Sweep> Tissue::sweep_part(const SweepLimit&) noexcept {
    return sweep();
}

Result<AdvanceReport> Tissue::advance(const Budget& budget) noexcept {
    AdvanceReport report;
    while (!report.settled && report.steps < budget.max_steps && report.ms < budget.max_ms) {
        Result<Sweep> swept = sweep();
        if (!swept) return swept.error();
        if (!swept->message.empty()) report.message = std::move(swept->message);
        ++report.steps;
        report.settled = swept->settled;
        report.ms += swept->ms;
    }
    return report;
}

Status Tissue::configure(const Record&) noexcept {
    return attempt([&]() -> Status { return not_supported("settings", *this); });
}

Result<std::int32_t> Tissue::take_depth(double, std::int32_t) noexcept {
    return attempt(
        [&]() -> Result<std::int32_t> { return not_supported("a depth of forces", *this); });
}

}  // namespace pliant
