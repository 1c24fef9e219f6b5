// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/spring_tissue.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/text.h"

namespace pliant {
namespace {

/// Node updates of advance() between two tests whether the tissue rests.
constexpr int kStepsAtATime = 20;

std::vector<double> numbers_of(Vec3i v) {
    return {double(v.x), double(v.y), double(v.z)};
}

/// Rows of the settings that can be changed during use: the depth.
SettingRows<SpringDeformationSettings> live_rows() {
    return {find_setting<SpringDeformationSettings>("depth", spring_rows()), 1};
}

}  // namespace

TissueTraits SpringScanTissue::traits() const noexcept {
    return {.model = "springs",
            .cuts = true,
            .moves_by_itself = true,
            .sweep_ms = 1000 * kStepsPerSweep / kRate_hz,
            .update_hz = kRate_hz};
}

Result<PushReport> SpringScanTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&] { return m_model->push(tool, push); });
}

std::optional<Vec3d> SpringScanTissue::force_n(std::uint32_t tool) noexcept {
    return m_model->force_n(tool);
}

Result<Sweep> SpringScanTissue::sweep() noexcept {
    Result<SpringMotion> motion = m_model->step(kStepsPerSweep);
    if (!motion.ok()) return motion.error();
    if (motion->active_nodes > 0) m_active_nodes = motion->active_nodes;
    return Sweep{motion->settled, motion->solve_ms, std::move(motion->message)};
}

Result<AdvanceReport> SpringScanTissue::advance(const Budget& budget) noexcept {
    return attempt([&]() -> Result<AdvanceReport> {
        AdvanceReport report;
        std::int32_t active_nodes = 0;
        while (report.steps < budget.max_steps && report.ms < budget.max_ms &&
               !m_model->is_settled()) {
            const int count =
                int(std::min<std::int64_t>(kStepsAtATime, budget.max_steps - report.steps));
            Result<SpringMotion> motion = m_model->step(count);
            if (!motion) return motion.error();
            report.steps += motion->steps;
            report.ms += motion->solve_ms;
            active_nodes = std::max(active_nodes, motion->active_nodes);
            if (!motion->message.empty()) report.message = std::move(motion->message);
        }
        if (active_nodes > 0) m_active_nodes = active_nodes;
        report.settled = m_model->is_settled();
        return report;
    });
}

Status SpringScanTissue::reset() noexcept {
    m_model->reset();
    return Ok{};
}

Record SpringScanTissue::settings() const {
    return record_of(m_model->settings(), live_rows());
}

Status SpringScanTissue::configure(const Record& changes) noexcept {
    return attempt([&]() -> Status {
        SpringDeformationSettings changed = m_model->settings();
        if (Status s = apply(changes, live_rows(), changed); !s) return s;
        return m_model->set_depth(changed.depth);
    });
}

Record SpringScanTissue::figures() const {
    return {{"nodes", numbers_of(m_model->control().grid().size)},
            {"active_nodes", int(m_active_nodes)}};
}

Record SpringScanTissue::report() const {
    const ControlGrid& grid = m_model->control().grid();
    const SpringDeformationSettings& settings = m_model->settings();
    const Vec3i n = grid.size;
    return {
        {"summary", std::to_string(n.x) + " x " + std::to_string(n.y) + " x " +
                        std::to_string(n.z) + " control nodes, " + std::to_string(m_active_nodes) +
                        " moved to depth " + std::to_string(settings.depth)},
        {"solver", "force-transmittal"},
        {"springs.cell_voxels", numbers_of(grid.cell)},
        {"springs.nodes", numbers_of(grid.size)},
        {"springs.fixed_nodes", int(m_model->fixed_nodes())},
        {"springs.active_nodes", int(m_active_nodes)},
        {"springs.depth", int(settings.depth)},
        {"springs.young_modulus_pa", settings.young_modulus_pa},
        {"springs.poisson_ratio", settings.poisson_ratio},
        {"springs.time_step_ms", 1000 * m_model->time_step_s()}};
}

Result<CutReport> SpringScanTissue::cut(const CutSurface& surface) noexcept {
    return m_model->cut(surface);
}

Result<std::int32_t> SpringScanTissue::take_depth(double threshold_mm,
                                                  std::int32_t max_depth) noexcept {
    return attempt([&]() -> Result<std::int32_t> {
        const auto found = m_model->find_depth(threshold_mm, max_depth);
        if (!found.ok()) return found.error();
        if (found->depth == 0)
            return about("depth", ErrorCode::NotFound,
                         "expected changes below " + short_text(threshold_mm) + " mm within " +
                             std::to_string(max_depth) + " layers, found " +
                             short_text(found->changes.back()) + " mm");
        if (const Status s = m_model->set_depth(found->depth); !s.ok()) return s.error();
        return found->depth;
    });
}

// The state: the positions of all nodes, and the corners of all cuts.

void SpringScanTissue::state(std::vector<double>& numbers) const {
    const std::span<const CutTriangle> cuts = m_model->cuts_mm();
    numbers.resize(3 * m_positions.size() + 9 * cuts.size());
    m_model->positions_mm(m_positions);
    double* to = numbers.data();
    const auto add = [&](Vec3d v) {
        for (int a = 0; a < 3; ++a) *to++ = v[a];
    };
    for (const Vec3d& position : m_positions) add(position);
    for (const CutTriangle& triangle : cuts)
        for (const Vec3d& corner : triangle) add(corner);
}

Status SpringScanTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const std::size_t count = 3 * m_positions.size();
        if (numbers.size() < count || (numbers.size() - count) % 9 != 0)
            return invalid("expected the positions of as many control nodes");
        const auto at = [&](std::size_t n) {
            return Vec3d{numbers[n], numbers[n + 1], numbers[n + 2]};
        };
        std::vector<Vec3d> positions;
        for (std::size_t n = 0; n < count; n += 3) positions.push_back(at(n));
        std::vector<CutTriangle> cuts;
        for (std::size_t n = count; n < numbers.size(); n += 9)
            cuts.push_back({at(n), at(n + 3), at(n + 6)});
        return m_model->set_shape(positions, cuts);
    });
}

}  // namespace pliant
