// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/spring_tissue.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/errors.h"

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
    const Result<SpringMotion> motion = m_model->step(kStepsPerSweep);
    if (!motion.ok()) return motion.error();
    if (motion->active_nodes > 0) m_active_nodes = motion->active_nodes;
    return Sweep{motion->settled, motion->solve_ms};
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
        {"springs.time_step_ms", 1000 * m_model->time_step_s()}};
}

void SpringScanTissue::state(std::vector<double>& numbers) const {
    numbers.resize(3 * m_positions.size());
    m_model->positions_mm(m_positions);
    for (std::size_t n = 0; n < m_positions.size(); ++n)
        for (int a = 0; a < 3; ++a) numbers[3 * n + std::size_t(a)] = m_positions[n][a];
}

Status SpringScanTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        if (numbers.size() != 3 * m_positions.size())
            return invalid("expected the positions of as many control nodes");
        std::vector<Vec3d> positions;
        for (std::size_t n = 0; n < numbers.size(); n += 3)
            positions.push_back({numbers[n], numbers[n + 1], numbers[n + 2]});
        return m_model->set_positions(positions);
    });
}

}  // namespace pliant
