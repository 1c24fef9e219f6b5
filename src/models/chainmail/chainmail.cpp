// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The public interface of the room: a push from the world's coordinates to the lattice's and back.

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/check.h"
#include "chainmail/grab.h"
#include "chainmail/operation.h"
#include "field/field_state.h"
#include "lattice/near_cells.h"
#include "lattice/tool_touch.h"
#include "propagate/propagation.h"
#include "propagate/step.h"

namespace pliant {

namespace {

/// Elements beyond the scan that a push may move whatever the scan's size.
constexpr std::int64_t kElementsBeyond = 8'000'000;

std::string cause_of(LimitedBy limit, const ChainMailSettings& settings) {
    switch (limit) {
        case LimitedBy::None:
            return {};
        case LimitedBy::Fold:
            return "space would fold";
        case LimitedBy::Bone:
            return "bone (values above [material] bone_threshold_hu = " +
                   short_text(settings.bone_threshold_hu) +
                   (settings.label_materials.empty() ? "" : ", or a fixed label") +
                   ") is in the way";
        case LimitedBy::Movement:
            return "an element reached its largest movement ([material] max_movement_mm = " +
                   short_text(settings.max_movement_mm) + ", less for harder tissue)";
        case LimitedBy::Wall:
            return "a wall is in the way";
    }
    return {};
}

/// Bone that stops a push.
struct NearestBone {
    double away_mm;  ///< from the nearest grabbed element
    Vec3d position_mm;
};

std::optional<NearestBone> nearest_bone(const Lattice& lattice, std::span<const ElementRef> grabbed,
                                        std::span<const Vec3i> bone) {
    const Grid& grid = lattice.grid();
    const auto distance_mm = [&](Vec3i a, Vec3i b) {
        Vec3d v{};
        for (int k = 0; k < 3; ++k) v[k] = grid.spacing_mm[k] * (a[k] - b[k]);
        return norm(v);
    };
    const int size = lattice.brick_size();
    double nearest_mm = std::numeric_limits<double>::infinity();
    Vec3i nearest{0, 0, 0};
    for (const ElementRef& element : grabbed) {
        const int n = element.index;
        const Vec3i held = size * lattice.brick(element.brick).coord +
                           Vec3i{n % size, n / size % size, n / (size * size)};
        for (const Vec3i e : bone) {
            const double mm = distance_mm(e, held);
            // Equal ones in one order, whichever thread found them first.
            if (mm > nearest_mm ||
                (mm == nearest_mm && voxel_index(grid, e) >= voxel_index(grid, nearest)))
                continue;
            nearest_mm = mm;
            nearest = e;
        }
    }
    if (!(nearest_mm < 1e9)) return {};
    return NearestBone{nearest_mm, world_from_voxel(grid, {double(nearest.x), double(nearest.y),
                                                           double(nearest.z)})};
}

std::string where_is(const NearestBone& bone) {
    const Vec3d x = bone.position_mm;
    const auto tenths = [](double mm) { return short_text(std::round(10 * mm) / 10); };
    return ", " + tenths(bone.away_mm) + " mm from the tool's tissue, at " + tenths(x.x) + ", " +
           tenths(x.y) + ", " + tenths(x.z);
}

}  // namespace

bool ChainMail::Impl::uses_vectors() const {
    return lattice.brick_size() == 8 && settings.solver != ChainMailSolver::PlainSweep;
}

const SweepKernels& ChainMail::Impl::kernels() const {
    return uses_vectors() ? vector_sweep_kernels() : plain_sweep_kernels();
}

std::int64_t ChainMail::Impl::max_elements() const {
    return std::min(settings.max_elements,
                    4 * std::int64_t(voxel_count(lattice.grid())) + kElementsBeyond);
}

int ChainMail::Impl::max_bricks() const {
    return int(
        std::min<std::int64_t>(max_elements() / lattice.elements_per_brick() + 8, INT32_MAX));
}

Error ChainMail::Impl::too_large() const {
    const std::int64_t most = max_elements();
    return {ErrorCode::LimitExceeded,
            "the push would move more than " + std::to_string(most) +
                " elements; expected a shorter push, a larger [material] "
                "offset, or " +
                (most == settings.max_elements ? "a larger [lattice] max_elements"
                                               : "air around the scan ([air] enabled)")};
}

bool ChainMail::Impl::propagate(std::span<const ElementRef> elements, Vec3<Fixed> shift) {
    if (settings.limits == LinkLimits::Rounded)
        return propagate_rounded(
            lattice, elements, shift,
            {kernels(), uses_vectors() ? vector_relax_rounded() : plain_relax_rounded()}, arena,
            max_bricks(), work);
    if (settings.solver != ChainMailSolver::Heap)
        return propagate_by_sweeps(lattice, elements, shift, kernels(), arena, max_bricks(), work);
    bool done = true;
    for (const ComponentPush& push : components_of(shift))
        if (done && push.amount > 0)
            done = propagate_by_heap(lattice, elements, push, max_bricks());
    work.shared = false;
    work.touched = lattice.resident_bricks();
    return done;
}

PushReport report_of_step(std::int64_t grabbed, StepLimit limit) {
    PushReport report;
    report.grabbed_elements = grabbed;
    report.step_fraction = limit.fraction;
    report.limited_by = limit.limited_by;
    return report;
}

Reasons reasons_of(LimitedBy limit, const ChainMailSettings& settings, const std::string& detail) {
    if (limit == LimitedBy::None) return {};
    const std::string cause = cause_of(limit, settings) + detail;
    return {"stopped: " + cause, "nothing moved: " + cause};
}

void complete(PushReport& report, std::int64_t moved, Reasons& reasons) noexcept {
    report.moved_elements = moved;
    const bool nothing = report.step_fraction <= 0 || (report.step_fraction < 1 && moved == 0);
    report.status = nothing                    ? PushStatus::Rejected
                    : report.step_fraction < 1 ? PushStatus::Limited
                                               : PushStatus::Applied;
    if (nothing) report.step_fraction = 0;
    report.message = std::move(nothing ? reasons.nothing_moved : reasons.stopped);
}

Result<PushReport> ChainMail::Impl::push_grabbed(std::span<const ElementRef> elements,
                                                 Vec3<Fixed> shift, Vec3<Fixed>* done) {
    // The grabbed elements' own limit first: it bounds the solve, and makes a longer push no more
    // costly.
    const StepLimit own = limit_of_grabbed(lattice, elements, shift);
    const Vec3<Fixed> tried = fraction_of(shift, own.fraction);
    work.may_share = guard == nullptr;
    work.may_skip_cancelled = guard == nullptr;  // a guard looks at the whole push
    if (!propagate(elements, tried)) return too_large();
    const StepLimit reached = limit_of_reached(lattice, work, kernels(), tried, arena);
    StepGuard::Verdict verdict{reached.fraction, fraction_of(tried, reached.fraction),
                               reached.fraction < 1 ? reached.limited_by : own.limited_by};
    if (guard) verdict = guard->limit(work.touched, tried, verdict);
    PushReport report = report_of_step(std::int64_t(elements.size()),
                                       {own.fraction * verdict.fraction, verdict.limited_by});
    std::string detail;
    if (verdict.limited_by == LimitedBy::Bone && reached.fraction < 1)
        if (const auto bone = nearest_bone(lattice, elements,
                                           bone_at_limit(lattice, work, tried, reached.fraction))) {
            detail = where_is(*bone);
            report.bone_mm = bone->position_mm;
        }
    Reasons reasons = reasons_of(verdict.limited_by, settings, detail);
    reserve_moves(lattice, work);
    // No allocations from here on.
    lattice.tick();
    *done = verdict.done;
    complete(report, apply_shift(lattice, work, kernels(), tried, verdict.done, arena), reasons);
    return report;
}

void ChainMail::Impl::drop_unmoved() {
    lattice.drop_still_bricks(work.touched);
    // A push of no elements, or by zero, reached no brick, not even the grabbed elements' own.
    int last = -1;
    for (const ElementRef& element : grabbed_elements) {
        if (element.brick != last) lattice.drop_still_bricks({&element.brick, 1});
        last = element.brick;
    }
}

void ChainMail::Impl::yield_to_push() {
    if (!yields) return;
    // Imprints can exist where all elements are at their rest position.
    std::vector<int> made;
    for (const auto& [coord, brick] : plastic_rest.bricks())
        if (lattice.find_brick(coord) < 0) made.push_back(lattice.ensure_brick(coord));
    flow(lattice, plastic_rest, arena);
    lattice.drop_still_bricks(made);
}

Vec3d ChainMail::Impl::lattice_mm_from_world(Vec3d push_mm) const {
    return settings.scale * lattice_from_world_vector(volume.grid, push_mm);
}

bool ChainMail::Impl::take_hold(std::span<const Vec3i> elements) {
    grabbed_elements.clear();
    // Consecutive elements are mostly of one brick.
    Vec3i coord;
    int brick = -1;
    for (const Vec3i& element : elements) {
        if (lattice.is_void(element)) continue;
        const Vec3i its = lattice.brick_of(element);
        if (brick < 0 || its != coord) brick = lattice.ensure_brick(its);
        coord = its;
        grabbed_elements.push_back({brick, lattice.index_in_brick(element, coord)});
    }
    return !grabbed_elements.empty();
}

Result<PushReport> ChainMail::Impl::push(std::span<const Vec3i> elements, Vec3d push_mm) {
    const Vec3d lattice_mm = lattice_mm_from_world(push_mm);
    if (!is_finite(lattice_mm) || norm(lattice_mm) > kMaxMovementMm)
        return about("push", ErrorCode::InvalidArgument,
                     "expected three numbers and a length up to 500 mm after scaling, "
                     "found a length of " +
                         std::to_string(norm(lattice_mm)) + " mm");
    const Stopwatch watch;
    Operation step(*this, {.step = "push", .ends_drag = true, .has_copies = yields});
    if (!take_hold(elements)) {
        PushReport report;
        report.message = "nothing moved: the tool touches no tissue there";
        step.commit();
        return report;
    }
    const Vec3<Fixed> shift{units_from_mm(lattice_mm.x), units_from_mm(lattice_mm.y),
                            units_from_mm(lattice_mm.z)};
    Vec3<Fixed> done{0, 0, 0};
    Result<PushReport> report = push_grabbed(grabbed_elements, shift, &done);
    if (!report.ok()) return report;
    drop_unmoved();
    if (report->moved_elements > 0) yield_to_push();
    allowance.shrink(lattice, arena);
    report->solve_ms = watch.ms();
    report->forgotten_steps = step.commit();
    return report;
}

namespace {

bool is_between_voxels(const Grid& grid, Vec3d ijk) {
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= 0 && ijk[a] <= grid.size[a] - 1)) return false;
    return true;
}

/// Error of a point outside of the scan: its bounds, and the point in RAS if that lies inside.
Error outside_of_scan(const Grid& grid, Vec3d point_mm) {
    const WorldBox box = centre_bounds(grid);
    const Vec3d ijk = voxel_from_world(grid, point_mm);
    bool is_in_box = true;  // of an oblique scan, which doesn't fill it
    for (int a = 0; a < 3; ++a)
        is_in_box &= point_mm[a] >= box.low_mm[a] && point_mm[a] <= box.high_mm[a];
    std::string text = "expected a point in the scan,";
    for (int a = 0; a < 3; ++a)
        text += std::string(a ? ", " : " ") + (is_in_box ? "ijk" : "xyz")[a] + " " +
                (is_in_box ? "0…" + std::to_string(grid.size[a] - 1)
                           : short_text(box.low_mm[a]) + "…" + short_text(box.high_mm[a]));
    const auto tenths = [](double voxels) { return short_text(std::round(10 * voxels) / 10); };
    text += (is_in_box ? " voxels, found " : " mm (LPS), found ") + short_text(point_mm);
    if (is_in_box)
        text += " mm (LPS), which is voxel " + tenths(ijk.x) + ", " + tenths(ijk.y) + ", " +
                tenths(ijk.z);
    const Vec3d turned{-point_mm.x, -point_mm.y, point_mm.z};
    if (is_between_voxels(grid, voxel_from_world(grid, turned)))
        text += "; did you mean " + short_text(turned.x) + "," + short_text(turned.y) + "," +
                short_text(turned.z) + ", which is the point if it was given in RAS?";
    return about("push", ErrorCode::InvalidArgument, text);
}

}  // namespace

Result<std::vector<Vec3i>> ChainMail::Impl::elements_at(const Push& push) const {
    const Vec3d ijk = voxel_from_world(volume.grid, push.point_mm);
    if (!is_between_voxels(volume.grid, ijk)) return outside_of_scan(volume.grid, push.point_mm);
    if (!(push.sphere_radius_mm >= 0 && push.sphere_radius_mm <= kMaxMovementMm))
        return about("push", ErrorCode::InvalidArgument, "expected a sphere radius of 0 to 500 mm");
    const double radius_mm = push.sphere_radius_mm;
    if (radius_mm == 0) return grab_cell(lattice, ijk).value_or(std::vector<Vec3i>{});
    const TissueValues tissue{settings.air_threshold_hu};
    std::vector<Vec3i> grabbed = grab_sphere(lattice, ijk, radius_mm, tissue);
    // A sphere that fits between the elements grabs the cells that it touches.
    const Vec3d h = volume.grid.spacing_mm;
    if (radius_mm < std::max({h.x, h.y, h.z})) {
        const Touch touch = touch_sphere(lattice, volume, ijk, radius_mm, tissue);
        grabbed.insert(grabbed.end(), touch.elements.begin(), touch.elements.end());
        std::sort(grabbed.begin(), grabbed.end(), comes_before);
        grabbed.erase(std::unique(grabbed.begin(), grabbed.end()), grabbed.end());
    }
    if (push.shape)
        std::erase_if(grabbed, [&](Vec3i e) {
            const Vec3d rest = world_from_voxel(volume.grid, {e.x * 1.0, e.y * 1.0, e.z * 1.0});
            const Vec3d position = rest + deformation.displacement_mm(e);
            return !push.shape->contains(position - push.point_mm);
        });
    return grabbed;
}

ChainMail::ChainMail(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ChainMail::~ChainMail() = default;
ChainMail::ChainMail(ChainMail&&) noexcept = default;
ChainMail& ChainMail::operator=(ChainMail&&) noexcept = default;

Result<ChainMail> ChainMail::create(const Volume& volume, const ChainMailSettings& settings,
                                    const TaskArena& arena) {
    return attempt([&]() -> Result<ChainMail> {
        Result<MaterialMap> materials = make_materials(volume, settings);
        if (!materials.ok()) return materials.error();
        return ChainMail(std::make_unique<Impl>(volume, settings, std::move(*materials), arena));
    });
}

Result<std::vector<Vec3i>> ChainMail::elements_at(const Push& push) const {
    return attempt([&] { return m_impl->elements_at(push); });
}

Result<PushReport> ChainMail::push(const Push& push) {
    return attempt([&]() -> Result<PushReport> {
        const Result<std::vector<Vec3i>> elements = m_impl->elements_at(push);
        if (!elements.ok()) return elements.error();
        return m_impl->push(*elements, push.push_mm);
    });
}

Result<PushReport> ChainMail::push_elements(std::span<const Vec3i> elements, Vec3d push_mm) {
    return attempt([&] { return m_impl->push(elements, push_mm); });
}

void ChainMail::Impl::reset() {
    let_go();
    history.begin_anyway("reset");
    lattice.tick();
    try {
        lattice.for_each_brick([&](Brick& brick) { lattice.before_move(brick); });
        for (const auto& [coord, brick] : plastic_rest.bricks())
            lattice.before_imprint(coord, &brick);
    } catch (const std::bad_alloc&) {
        history.give_up();  // a reset that fails would leave no way to free memory
    }
    lattice.drop_all_bricks();
    plastic_rest.clear();
    allowance.shrink(lattice, arena);
    history.end();
}

void ChainMail::reset() {
    m_impl->reset();
}

Vec3d ChainMail::displacement_mm(Vec3i ijk) const {
    const Vec3<Fixed> u = m_impl->lattice.displacement_at(ijk);
    return world_from_lattice_vector(m_impl->volume.grid,
                                     {mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)});
}

LatticeState ChainMail::state() const {
    const MaterialMap& materials = m_impl->lattice.material_map();
    LatticeState state = check_lattice(
        m_impl->lattice, [&](Vec3i ijk) { return materials.limits_at(ijk); }, m_impl->arena,
        &m_impl->allowance);
    if (state.resident_bricks > 0)
        state.bytes_per_resident_element +=
            double(m_impl->plastic_rest.bytes()) /
            (double(state.resident_bricks) * m_impl->lattice.elements_per_brick());
    return state;
}

std::uint64_t ChainMail::hash() const {
    return hash_state(m_impl->lattice);
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
const Deformation& ChainMail::deformation() const {
    return m_impl->deformation;
}

}  // namespace pliant
