// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/chainmail_tissue.h"

#include <algorithm>
#include <limits>

#include "base/errors.h"
#include "chainmail/chainmail_impl.h"

namespace pliant {

TissueTraits ChainMailTissue::traits() const noexcept {
    return {.model = "chainmail",
            .slides = true,
            .cuts = true,
            .carves = true,
            .has_energy = true,
            .closes_at_rest = true,
            .keeps_imprints = m_model.settings().yield > 0};
}

Result<PushReport> ChainMailTissue::push(std::uint32_t tool, const Push& push) noexcept {
    return attempt([&]() -> Result<PushReport> {
        auto held = m_model.elements_at(push);
        if (!held.ok()) return held.error();
        std::map<std::uint32_t, Contact> made;  // its node is inserted later without allocation
        made[tool];
        auto report = m_model.push_elements(*held, push.push_mm);
        if (!report.ok()) return report;
        const Vec3d end = push.point_mm + report->step_fraction * push.push_mm;
        made[tool] = {{end, end, push.sphere_radius_mm}, std::move(*held)};
        m_contacts.erase(tool);
        m_contacts.merge(made);
        return report;
    });
}

Result<GrabReport> ChainMailTissue::grab(std::uint32_t tool, const Push& position,
                                         double reach_mm) noexcept {
    return attempt([&]() -> Result<GrabReport> {
        auto report = m_model.grab(position, reach_mm);
        if (report.ok()) m_contacts.erase(tool);
        return report;
    });
}

Result<PushReport> ChainMailTissue::drag_to(Vec3d offset_mm) noexcept {
    return attempt([&] { return m_model.drag_to(offset_mm); });
}

Result<SlideReport> ChainMailTissue::slide(std::uint32_t tool, const Push& way,
                                           const TissueValues& tissue_values) noexcept {
    return attempt([&]() -> Result<SlideReport> {
        std::map<std::uint32_t, Contact> made;
        made[tool];
        auto slid = slide_sphere(m_model, way, tissue_values);
        if (!slid.ok()) return slid;
        made[tool] = {{slid->end_mm, slid->end_mm, way.sphere_radius_mm}, {}, true};
        m_contacts.erase(tool);
        m_contacts.merge(made);
        return slid;
    });
}

Result<CutReport> ChainMailTissue::cut(const CutSurface& surface) noexcept {
    return attempt([&] { return m_model.cut(surface); });
}

Result<CarveReport> ChainMailTissue::carve(const CarveTool& tool) noexcept {
    return attempt([&] { return m_model.carve(tool); });
}

Status ChainMailTissue::place_eye(std::uint32_t tool, Vec3d position_mm,
                                  double radius_mm) noexcept {
    return attempt([&]() -> Status {
        if (radius_mm > 0)
            m_eyes[tool] = {position_mm, position_mm, radius_mm};
        else
            m_eyes.erase(tool);
        return Ok{};
    });
}

std::optional<double> ChainMailTissue::energy_mm2() noexcept try {
    return m_model.elastic_energy_mm2();
} catch (const std::bad_alloc&) {
    return {};
}

/// Tools and held elements.
RelaxOptions ChainMailTissue::relax_options() const {
    RelaxOptions options;
    for (const auto& [tool, contact] : m_contacts) {
        const bool keeps_out = m_resting == RestingTool::KeepsTissueOut || contact.slid;
        if (contact.tool.radius_mm > 0 && keeps_out) options.tools.push_back(contact.tool);
        options.held.insert(options.held.end(), contact.held.begin(), contact.held.end());
    }
    for (const auto& [tool, eye] : m_eyes) options.tools.push_back(eye);
    return options;
}

Result<Sweep> ChainMailTissue::sweep_part(const SweepLimit& limit) noexcept {
    return attempt([&]() -> Result<Sweep> {
        RelaxOptions options = relax_options();
        options.max_sweeps = 1;
        options.max_bricks = limit.max_parts;
        options.budget_ms = limit.max_ms;
        options.stop = limit.stop;
        const auto report = m_model.relax(options);
        if (!report.ok() && is_out_of_memory(report.error())) return report.error();
        // Any other error would recur in each sweep.
        if (!report.ok()) return Sweep{};
        Sweep sweep{report->settled, report->relax_ms, {}, report->largest_step_mm};
        if (report->sweeps == 0 && !report->settled) {
            sweep.largest_step_mm = std::numeric_limits<double>::infinity();
            sweep.parts = report->bricks;
        }
        return sweep;
    });
}

Result<AdvanceReport> ChainMailTissue::advance(const Budget& budget) noexcept {
    return attempt([&]() -> Result<AdvanceReport> {
        RelaxOptions options = relax_options();
        options.max_sweeps =
            int(std::clamp<std::int64_t>(budget.max_steps, 0, std::numeric_limits<int>::max()));
        options.budget_ms = budget.max_ms;
        const auto relaxed = m_model.relax(options);
        if (!relaxed) return relaxed.error();
        return AdvanceReport{relaxed->sweeps, relaxed->settled, relaxed->relax_ms};
    });
}

Status ChainMailTissue::reset() noexcept {
    return attempt([&]() -> Status {
        m_model.reset();
        m_contacts.clear();
        return Ok{};
    });
}

Record ChainMailTissue::settings() const {
    return record_of(m_model.settings(), chainmail_material_rows());
}

Status ChainMailTissue::configure(const Record& changes) noexcept {
    return attempt([&]() -> Status {
        ChainMailSettings changed = m_model.settings();
        if (Status s = apply(changes, chainmail_material_rows(), changed); !s) return s;
        return m_model.set_materials(changed);
    });
}

Record ChainMailTissue::report() const {
    const LatticeState state = m_model.state();
    const FoldCertificate certificate = m_model.fold_certificate();
    return {{"solver", m_model.settings().solver == ChainMailSolver::Heap ? "heap" : "sweep"},
            {"moved_elements", SettingValue(state.moved_elements)},
            {"max_movement_mm", state.max_movement_mm},
            {"max_violation_mm", state.max_violation_mm},
            {"folded_cells", SettingValue(state.folded_cells)},
            {"cut_links", SettingValue(state.cut_links)},
            {"carved_elements", SettingValue(state.carved_elements)},
            {"resident_bricks", SettingValue(state.resident_bricks)},
            {"bytes_per_resident_element", state.bytes_per_resident_element},
            {"no_fold_certified", certificate.certified},
            {"certificate.all", certificate.all},
            {"certificate.tissue", certificate.tissue}};
}

Status ChainMailTissue::undo() noexcept {
    return attempt([&] { return m_model.undo(); });
}

Status ChainMailTissue::redo() noexcept {
    return attempt([&] { return m_model.redo(); });
}

Status ChainMailTissue::rest() noexcept {
    m_eyes.clear();
    ChainMailInside::of(m_model).relaxation.start_over();
    return Ok{};
}

Status ChainMailTissue::save_state(const std::string& path) const noexcept {
    return attempt([&] { return m_model.save_state(path); });
}

Status ChainMailTissue::load_state(const std::string& path) noexcept {
    return attempt([&] { return m_model.load_state(path); });
}

}  // namespace pliant
