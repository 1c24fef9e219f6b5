// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The face of the room: a push from the world's coordinates to the lattice's and back.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "chainmail/chainmail_impl.h"
#include "chainmail/check.h"
#include "chainmail/grab.h"
#include "chainmail/propagation.h"
#include "chainmail/settings.h"
#include "chainmail/step.h"

namespace pliant {

namespace {

Error too_large(const ChainMailSettings& settings) {
    return {ErrorCode::LimitExceeded,
            "the push would move more than " + std::to_string(settings.max_elements) +
                " elements; expected a shorter push, a larger [material] offset, or a larger "
                "[lattice] max_elements"};
}

std::string reason(const PushReport& report) {
    const bool none = report.status == PushStatus::Rejected;
    switch (report.limited_by) {
        case LimitedBy::None:
            return {};
        case LimitedBy::Bone:
            return std::string(none ? "nothing moved" : "stopped") +
                   ": bone (values above [material] bone_threshold_hu) is in the way";
        case LimitedBy::Movement:
            return std::string(none ? "nothing moved" : "stopped") +
                   ": an element reached its largest movement ([material] max_movement_mm)";
    }
    return {};
}

}  // namespace

bool ChainMail::Impl::propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift) {
    const auto max_bricks = int(std::min<std::int64_t>(
        settings.max_elements / lattice.elements_per_brick() + 8, INT32_MAX));
    for (int axis = 0; axis < 3; ++axis) {
        if (shift[axis] == 0) continue;
        const ComponentPush push{axis, shift[axis] > 0 ? 1 : -1, std::abs(shift[axis])};
        const bool done = settings.solver == ChainMailSolver::Heap
                              ? propagate_by_heap(lattice, grabbed, push, max_bricks)
                              : propagate_by_sweeps(lattice, grabbed, push, arena, max_bricks);
        if (!done) return false;
    }
    return true;
}

Result<PushReport> ChainMail::Impl::push_grabbed(std::span<const ElementRef> grabbed,
                                                 Vec3<Fixed> shift) {
    // The grabbed elements' own limit first: it bounds the solve, and a longer push than it allows
    // needs no larger one.
    const StepLimit own = limit_of_grabbed(lattice, grabbed, shift);
    const Vec3<Fixed> tried = fraction_of(shift, own.fraction);
    if (!propagate(grabbed, tried)) {
        discard_raises(lattice, lattice.resident_bricks());
        return too_large(settings);
    }
    const std::vector<int> bricks = lattice.resident_bricks();
    const StepLimit reached = limit_of_reached(lattice, bricks, tried, arena);
    PushReport report;
    report.grabbed_elements = std::int64_t(grabbed.size());
    report.step_fraction = own.fraction * reached.fraction;
    report.limited_by = reached.fraction < 1 ? reached.limited_by : own.limited_by;
    report.moved_elements =
        apply_shift(lattice, bricks, tried, fraction_of(tried, reached.fraction), arena);
    const bool nothing =
        report.step_fraction <= 0 || (report.step_fraction < 1 && report.moved_elements == 0);
    report.status = nothing                    ? PushStatus::Rejected
                    : report.step_fraction < 1 ? PushStatus::Limited
                                               : PushStatus::Applied;
    if (nothing) report.step_fraction = 0;
    report.message = reason(report);
    return report;
}

Result<PushReport> ChainMail::Impl::push(std::span<const Vec3i> elements, Vec3d push_mm) {
    const Vec3d lattice_mm = settings.scale * lattice_from_world_vector(volume.grid, push_mm);
    if (!is_finite(lattice_mm) || norm(lattice_mm) > kMaxMovementMm)
        return Error{ErrorCode::InvalidArgument,
                     "push: expected three numbers and a length up to 500 mm after scaling, "
                     "found a length of " +
                         std::to_string(norm(lattice_mm)) + " mm"};
    const auto start = std::chrono::steady_clock::now();
    std::vector<ElementRef> grabbed;
    for (const Vec3i& element : elements)
        if (!lattice.is_void(element)) grabbed.push_back(lattice.ensure_element(element));
    if (grabbed.empty()) {
        PushReport report;
        report.message = "nothing moved: the tool touches no tissue there";
        return report;
    }
    const Vec3<Fixed> shift{units_from_mm(lattice_mm.x), units_from_mm(lattice_mm.y),
                            units_from_mm(lattice_mm.z)};
    lattice.tick();
    Result<PushReport> report = push_grabbed(grabbed, shift);
    if (report.ok() && report->moved_elements > 0) flow(lattice, plastic_rest, arena);
    lattice.drop_still_bricks();
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    if (report.ok()) report->solve_ms = elapsed.count();
    return report;
}

ChainMail::ChainMail(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ChainMail::~ChainMail() = default;
ChainMail::ChainMail(ChainMail&&) noexcept = default;
ChainMail& ChainMail::operator=(ChainMail&&) noexcept = default;

Result<ChainMail> ChainMail::create(const Volume& volume, const ChainMailSettings& settings,
                                    const TaskArena& arena) {
    if (const Status status = check_settings(settings); !status.ok()) return status.error();
    auto impl = std::make_unique<Impl>(volume, settings, arena);
    if (!impl->lattice.materials().fits())
        return Error{ErrorCode::InvalidArgument,
                     "material laws: expected up to 65535 different limits in all, found more"};
    return ChainMail(std::move(impl));
}

Result<std::vector<Vec3i>> ChainMail::elements_at(const Push& push) const {
    const Grid& grid = m_impl->volume.grid;
    const Vec3d ijk = voxel_from_world(grid, push.point_mm);
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= 0 && ijk[a] <= grid.size[a] - 1))
            return Error{ErrorCode::InvalidArgument,
                         "push: the point lies outside of the scan (voxel " +
                             std::to_string(ijk.x) + ", " + std::to_string(ijk.y) + ", " +
                             std::to_string(ijk.z) + "), expected 0 to size - 1 along each axis"};
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxMovementMm))
        return Error{ErrorCode::InvalidArgument, "push: expected a sphere radius of 0 to 500 mm"};
    if (push.sphere_radius_mm > 0)
        return grab_sphere(m_impl->lattice, ijk, push.sphere_radius_mm,
                           m_impl->settings.air_threshold_hu);
    return grab_cell(m_impl->lattice, ijk).value_or(std::vector<Vec3i>{});
}

Result<PushReport> ChainMail::push(const Push& push) {
    const Result<std::vector<Vec3i>> grabbed = elements_at(push);
    if (!grabbed.ok()) return grabbed.error();
    return m_impl->push(*grabbed, push.push_mm);
}

Result<PushReport> ChainMail::push_elements(std::span<const Vec3i> elements, Vec3d push_mm) {
    return m_impl->push(elements, push_mm);
}

Vec3d ChainMail::displacement_mm(Vec3i ijk) const {
    const Vec3<Fixed> u = m_impl->lattice.displacement_at(ijk);
    return world_from_lattice_vector(m_impl->volume.grid,
                                     {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)});
}

LatticeState ChainMail::state() const {
    LatticeState state = check_lattice(m_impl->lattice, m_impl->law, m_impl->arena);
    if (state.resident_bricks > 0)
        state.bytes_per_resident_element +=
            double(m_impl->plastic_rest.bytes()) /
            (double(state.resident_bricks) * m_impl->lattice.elements_per_brick());
    return state;
}

std::uint64_t ChainMail::hash() const {
    return hash_displacements(m_impl->lattice);
}

Box3i ChainMail::moved_box() const {
    return pliant::moved_box(m_impl->lattice);
}

const Volume& ChainMail::volume() const {
    return m_impl->volume;
}
const TaskArena& ChainMail::arena() const {
    return m_impl->arena;
}
const ChainMailSettings& ChainMail::settings() const {
    return m_impl->settings;
}
const Lattice& ChainMail::lattice() const {
    return m_impl->lattice;
}

}  // namespace pliant
