// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation and imprint at the room's face: options checked, results in millimetres.

#include <charconv>
#include <cmath>

#include "chainmail/chainmail_impl.h"
#include "chainmail/energy.h"
#include "volume/text.h"

namespace pliant {
namespace {

constexpr double kMaxOverRelaxation = 1.95;
constexpr double kMaxToolMm = 1e5;  ///< places and radii of tools

Error wrong(const std::string& option, const std::string& expected, double found) {
    return {ErrorCode::InvalidArgument,
            "relax: " + option + ": expected " + expected + ", found " + text_of(found)};
}

Status check_options(const RelaxOptions& o) {
    if (!(o.budget_ms >= 0)) return wrong("budget_ms", "0 or more", o.budget_ms);
    if (o.max_sweeps < 0) return wrong("max_sweeps", "0 or more", o.max_sweeps);
    if (!(o.over_relaxation >= 1 && o.over_relaxation <= kMaxOverRelaxation))
        return wrong("over_relaxation", "1 to 1.95", o.over_relaxation);
    for (const RelaxTool& tool : o.tools) {
        if (!(tool.radius_mm > 0 && tool.radius_mm <= kMaxToolMm))
            return wrong("tools: radius_mm", "more than 0, up to 100000", tool.radius_mm);
        for (const Vec3d place : {tool.from_mm, tool.to_mm})
            if (!(norm(place) <= kMaxToolMm))
                return wrong("tools", "places up to 100000 mm from the origin", norm(place));
    }
    return Ok{};
}

}  // namespace

RelaxReport ChainMail::Impl::relax(const RelaxOptions& options) {
    begin_step("relax");
    RelaxReport report;
    if (held.empty()) {
        report = relaxation.run(options);
    } else {
        // The fields start from where elements were at the pick, which is not where they will be.
        if (has_fields || steps_without_fields) steps_without_fields = 0;
        drop_fields();
        RelaxOptions all = options;
        all.held.insert(all.held.end(), held.begin(), held.end());
        report = relaxation.run(all);
    }
    allowance.shrink(lattice, arena);
    report.forgotten_steps = end_step();
    return report;
}

Result<RelaxReport> ChainMail::relax(const RelaxOptions& options) {
    if (const Status status = check_options(options); !status.ok()) return status.error();
    const double before = options.measure_energy ? elastic_energy_mm2() : 0;
    RelaxReport report = m_impl->relax(options);
    if (options.measure_energy) {
        report.energy_before_mm2 = before;
        report.energy_after_mm2 = elastic_energy_mm2();
    }
    return report;
}

double ChainMail::elastic_energy_mm2() const {
    return mm2_from_energy(m_impl->energy.of(m_impl->lattice, m_impl->plastic_rest, m_impl->arena));
}

Vec3d ChainMail::imprint_mm(Vec3i ijk) const {
    const Vec3<Fixed> p = m_impl->plastic_rest.imprint_at(m_impl->lattice, ijk);
    return world_from_lattice_vector(m_impl->volume.grid,
                                     {mm_from_units(p.x), mm_from_units(p.y), mm_from_units(p.z)});
}

}  // namespace pliant
