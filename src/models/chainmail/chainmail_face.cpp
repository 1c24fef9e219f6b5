// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The public interface of relaxation and imprint: checks options, reports results in millimetres.

#include "base/errors.h"
#include "base/text.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"
#include "relax/energy.h"

namespace pliant {
namespace {

constexpr double kMaxToolMm = 1e5;  ///< largest coordinate and radius of tools

Error wrong(const std::string& option, const std::string& expected, double found) {
    return about("relax", ErrorCode::InvalidArgument,
                 option + ": expected " + expected + ", found " + text_of(found));
}

Status check_options(const RelaxOptions& o) {
    if (!(o.budget_ms >= 0)) return wrong("budget_ms", "0 or more", o.budget_ms);
    if (o.max_bricks < 0) return wrong("max_bricks", "0 or more", double(o.max_bricks));
    if (const Status status = check(o, relax_rows()); !status.ok())
        return about("relax", ErrorCode::InvalidArgument, status.error().message);
    for (const RelaxTool& tool : o.tools) {
        if (!(tool.radius_mm > 0 && tool.radius_mm <= kMaxToolMm))
            return wrong("tools: radius_mm", "more than 0, up to 100000", tool.radius_mm);
        for (const Vec3d position : {tool.from_mm, tool.to_mm})
            if (!(norm(position) <= kMaxToolMm))
                return wrong("tools", "positions up to 100000 mm from the origin", norm(position));
    }
    return Ok{};
}

struct RelaxingGuard {
    Relaxation& relaxation;
    bool has_begun = false;
    ~RelaxingGuard() {
        if (has_begun) relaxation.roll_back();
    }
};

Error open_group() {
    return {ErrorCode::InvalidArgument, "undo: expected no open group, found one; end it first"};
}

}  // namespace

Result<RelaxReport> ChainMail::Impl::relax(const RelaxOptions& given) {
    if (const Status status = check_options(given); !status.ok()) return status.error();
    RelaxOptions with_held;
    if (!held.empty()) {
        with_held = given;
        with_held.held.insert(with_held.held.end(), held.begin(), held.end());
        // The fields start from positions at the pick, which relaxation changes.
        if (has_fields || steps_without_fields) steps_without_fields = 0;
        drop_fields();
    }
    const RelaxOptions& options = held.empty() ? given : with_held;
    RelaxingGuard relaxing{relaxation};  // acts after the operation has restored the lattice
    Operation step(*this, {.step = "relax"});
    const double before = options.measure_energy ? elastic_energy_mm2() : 0;
    relaxing.has_begun = true;
    relaxation.begin(options);
    // Continued slices have all their memory, and need no copies.
    if (options.measure_energy || relaxation.needs_memory()) step.keep_copies();
    RelaxReport report = relaxation.run(options);
    if (options.measure_energy) {
        report.energy_before_mm2 = before;
        report.energy_after_mm2 = elastic_energy_mm2();
    }
    allowance.shrink(lattice, arena);
    report.forgotten_steps = step.commit();
    relaxing.has_begun = false;
    return report;
}

double ChainMail::Impl::elastic_energy_mm2() {
    return mm2_from_energy(energy.of(lattice, plastic_rest, arena));
}

Result<RelaxReport> ChainMail::relax(const RelaxOptions& options) {
    return attempt([&] { return m_impl->relax(options); });
}

double ChainMail::elastic_energy_mm2() const {
    return m_impl->elastic_energy_mm2();
}

Vec3d ChainMail::imprint_mm(Vec3i ijk) const {
    const Vec3<Fixed> p = m_impl->plastic_rest.imprint_at(m_impl->lattice, ijk);
    return world_from_lattice_vector(m_impl->volume.grid,
                                     {mm_from_units(p.x), mm_from_units(p.y), mm_from_units(p.z)});
}

// The public interface of undo and redo.

Status ChainMail::Impl::undo() {
    SuspendedDrag suspended(*this);
    if (history.is_open()) return open_group();
    if (!history.has_aside() && history.undo_steps() == 0) {
        Error none{ErrorCode::NotFound, "undo: expected a step to take back, found none"};
        suspended.end();
        return none;
    }
    history.undo([&] { restore_allowance(); });
    suspended.end();
    return Ok{};
}

Status ChainMail::Impl::redo() {
    SuspendedDrag suspended(*this);
    if (history.is_open()) return open_group();
    if (history.has_aside() || history.redo_steps() == 0) {
        Error none{ErrorCode::NotFound, "redo: expected a step that was undone, found none"};
        suspended.end();
        return none;
    }
    history.redo([&] { restore_allowance(); });
    suspended.end();
    return Ok{};
}

Status ChainMail::undo() {
    return attempt([&] { return m_impl->undo(); });
}
Status ChainMail::redo() {
    return attempt([&] { return m_impl->redo(); });
}

int ChainMail::undo_steps() const {
    return m_impl->history.undo_steps();
}
int ChainMail::redo_steps() const {
    return m_impl->history.redo_steps();
}
std::size_t ChainMail::history_bytes() const {
    return m_impl->history.bytes();
}
const std::string& ChainMail::next_undo_name() const {
    return m_impl->history.next_undo_name();
}
const std::string& ChainMail::next_redo_name() const {
    return m_impl->history.next_redo_name();
}
void ChainMail::begin_group(const std::string& name) {
    m_impl->history.begin_anyway(name);
}
int ChainMail::end_group() {
    return m_impl->history.end();
}

}  // namespace pliant
