// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The public interface of dragging: from the tool's offset to steps of the grabbed elements.

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"

namespace pliant {
namespace {

Vec3<Fixed> whole_units(Vec3d mm) {
    return {units_from_mm(mm.x), units_from_mm(mm.y), units_from_mm(mm.z)};
}

}  // namespace

bool ChainMail::Impl::can_use_fields() const {
    return settings.solver != ChainMailSolver::Heap && settings.limits == LinkLimits::Box &&
           !lattice.may_exceed_limits();
}

void ChainMail::Impl::drop_fields() noexcept {
    if (!has_fields) return;
    has_fields = false;
    drag.let_go(lattice);
    // Caches of brick indices must detect that bricks were dropped.
    lattice.tick();
}

Status ChainMail::Impl::pick() {
    drop_fields();
    steps_without_fields.reset();
    if (!can_use_fields()) return Ok{};
    steps_without_fields = 0;  // in case of failure
    take_hold(held);
    has_fields = drag.pick(lattice, grabbed_elements, drag_reach, kernels(),
                           uses_vectors() ? vector_look_at_fields() : plain_look_at_fields(), arena,
                           max_bricks(), work);
    if (!has_fields) return too_large();
    steps_without_fields.reset();
    return Ok{};
}

Result<GrabReport> ChainMail::Impl::grab(std::span<const Vec3i> elements, double reach_mm) {
    const double reach = settings.scale * reach_mm;
    if (!(reach > 0 && reach <= kMaxMovementMm))
        return Error{ErrorCode::InvalidArgument,
                     "grab: expected a reach_mm above 0 and up to 500 mm after scaling, found " +
                         std::to_string(reach) + " mm"};
    const Stopwatch watch;
    Operation step(*this, {.step = "drag", .ends_drag = true});
    GrabReport report;
    std::vector<Vec3i> taken;
    std::copy_if(elements.begin(), elements.end(), std::back_inserter(taken),
                 [&](Vec3i element) { return !lattice.is_void(element); });
    if (taken.empty()) {
        report.message = "nothing grabbed: the tool touches no tissue there";
        step.commit();
        return report;
    }
    held = std::move(taken);
    drag_reach = std::max<Fixed>(1, units_from_mm(reach));
    drag_offset = {0, 0, 0};
    if (const Status status = pick(); !status.ok()) return status.error();
    lattice.tick();
    report.grabbed_elements = std::int64_t(held.size());
    if (has_fields) {
        report.reach_elements = drag.reach_elements();
        report.field_bytes = std::int64_t(drag.bytes());
    }
    step.commit_open();
    report.grab_ms = watch.ms();
    return report;
}

Result<PushReport> ChainMail::Impl::drag_by(Vec3<Fixed> step, Vec3<Fixed>& done) {
    if (has_fields && !(can_use_fields() && drag.covers(step))) {
        // The drag leaves the range of its fields. The new range must hold at least this step.
        for (int a = 0; a < 3; ++a) drag_reach = std::max(drag_reach, std::abs(step[a]));
        if (const Status status = pick(); !status.ok()) return status.error();
    }
    // New fields at the second step after relaxation: they are of no use if each step is relaxed.
    if (steps_without_fields && (*steps_without_fields)++ > 0) {
        for (int a = 0; a < 3; ++a) drag_reach = std::max(drag_reach, std::abs(step[a]));
        if (const Status status = pick(); !status.ok()) return status.error();
    }
    if (!has_fields) {
        take_hold(held);
        Result<PushReport> report = push_grabbed(grabbed_elements, step, &done);
        drop_unmoved();
        return report;
    }
    const StepLimit own = limit_of_grabbed(lattice, grabbed_elements, step);
    const Vec3<Fixed> tried = fraction_of(step, own.fraction);
    const StepLimit reached = drag.limit(lattice, tried, arena);
    const bool by_reached = reached.fraction < 1;
    PushReport report = report_of_step(
        std::int64_t(held.size()),
        {own.fraction * reached.fraction, by_reached ? reached.limited_by : own.limited_by});
    Reasons reasons = reasons_of(report.limited_by, settings);
    // No allocations from here on.
    lattice.tick();
    done = fraction_of(tried, reached.fraction);
    complete(report,
             drag.move(lattice, done, uses_vectors() ? vector_move_dragged() : plain_move_dragged(),
                       arena),
             reasons);
    return report;
}

Result<PushReport> ChainMail::Impl::drag_to(Vec3d offset_mm) {
    if (held.empty())
        return Error{ErrorCode::InvalidArgument, "drag: nothing is grabbed, expected a grab first"};
    const Vec3d to_mm = lattice_mm_from_world(offset_mm);
    const Vec3d from_mm{mm_from_units(drag_offset.x), mm_from_units(drag_offset.y),
                        mm_from_units(drag_offset.z)};
    const double length = norm(to_mm - from_mm);
    if (!is_finite(to_mm) || !(length <= kMaxMovementMm))
        return Error{ErrorCode::InvalidArgument,
                     "drag: expected three numbers and a step of up to 500 mm after scaling, found "
                     "a step of " +
                         std::to_string(length) + " mm"};
    const Stopwatch watch;
    Operation frame(*this, {.has_copies = yields});
    Vec3<Fixed> done{0, 0, 0};
    Result<PushReport> report = drag_by(whole_units(to_mm) - drag_offset, done);
    if (!report.ok()) return report;
    if (report->moved_elements > 0) yield_to_push();
    allowance.shrink(lattice, arena);
    frame.commit();
    drag_offset = drag_offset + done;
    report->solve_ms = watch.ms();
    return report;
}

void ChainMail::Impl::let_go() noexcept {
    if (held.empty()) return;
    drop_fields();
    steps_without_fields.reset();
    held.clear();
    history.end();
}

Result<GrabReport> ChainMail::grab(const Push& position, double reach_mm) {
    return attempt([&]() -> Result<GrabReport> {
        const Result<std::vector<Vec3i>> elements = m_impl->elements_at(position);
        if (!elements.ok()) return elements.error();
        return m_impl->grab(*elements, reach_mm);
    });
}

Result<GrabReport> ChainMail::grab_elements(std::span<const Vec3i> elements, double reach_mm) {
    return attempt([&] { return m_impl->grab(elements, reach_mm); });
}

Result<PushReport> ChainMail::drag_to(Vec3d offset_mm) {
    return attempt([&] { return m_impl->drag_to(offset_mm); });
}

void ChainMail::let_go() {
    m_impl->let_go();
}

bool ChainMail::is_grabbing() const {
    return !m_impl->held.empty();
}

}  // namespace pliant
