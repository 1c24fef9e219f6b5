// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The motion of a scan's control nodes, and SpringDeformation, which is their tissue under another
// interface.

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "tissue/scan_network.h"
#include "tissue/spring_tissue.h"

namespace pliant {

SpringScanTissue::SpringScanTissue(const SpringDeformationSettings& settings, SpringTissue tissue,
                                   std::unique_ptr<ControlLattice> control)
    : SpringNodes(std::move(tissue), std::move(control)), m_settings(settings) {
    // So that nothing fails once a tool has been released or time has passed.
    const auto count = std::size_t(node_count());
    m_displacements.assign(count, Vec3d{0, 0, 0});
    m_former.reserve(2 * count);
    m_former_kept.reserve(2 * count);
    m_loose.reserve(count);
    m_no_forces.assign(count, Vec3d{0, 0, 0});
    m_moves.resize(count);
    m_stretched.resize(count);
}

Result<std::unique_ptr<SpringScanTissue>> SpringScanTissue::create(
    const Volume& volume, const SpringDeformationSettings& settings, const TaskArena& arena) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (const Status s = check(settings, spring_rows()); !s.ok()) return s.error();
    const auto grid = control_grid(volume, settings);
    if (!grid.ok()) return grid.error();
    auto control = ControlLattice::create(volume, *grid, arena);
    if (!control.ok()) return control.error();
    auto tissue = tissue_of(volume, *grid, settings);
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<SpringScanTissue>(
        new SpringScanTissue(settings, std::move(*tissue), std::move(*control)));
}

// Time.

/// Stops all nodes, and moves those near their rest position to it. Nodes that forces no longer
/// reach, since the depth was reduced, then start to move freely.
void SpringScanTissue::settle() noexcept {
    halt();
    if (!m_held.empty()) return;
    double farthest = 0;
    std::vector<std::int32_t>& away = m_loose;
    away.clear();
    for (std::int32_t n = 0; n < node_count(); ++n) {
        const double distance = norm(m_tissue.displacement(n));
        farthest = std::max(farthest, distance);
        if (distance > 0 && !is_fixed(n)) away.push_back(n);
    }
    if (farthest < home_mm()) {
        m_tissue.reset();
        m_former.clear();
    } else if (away != m_former) {
        m_former.assign(away.begin(), away.end());
        m_settled = false;
    }
    renew_sources();
}

Result<SpringMotion> SpringScanTissue::step_nodes(int count) {
    SpringMotion motion;
    const Stopwatch watch;
    if (!m_settled) {
        const auto stepped = m_tissue.step(count, arena());
        if (stepped.ok()) {
            motion.steps = stepped->steps;
            motion.active_nodes = stepped->active_nodes;
            motion.fastest_mm_s = fastest_mm_s();
            m_settled = is_calm(motion.fastest_mm_s);
        } else if (is_out_of_memory(stepped.error())) {
            return stepped.error();
        } else {
            try {
                motion.message = stepped.error().message;
            } catch (const std::bad_alloc&) {  // earlier steps are complete
                motion.message = "unstable";
            }
            m_settled = true;
        }
        if (m_settled) settle();
        m_is_shown = false;
    }
    motion.settled = m_settled;
    motion.solve_ms = watch.ms();
    return motion;
}

Status SpringScanTissue::set_depth(std::int32_t depth) noexcept {
    if (const Status s = m_tissue.set_depth(depth); !s.ok()) return s;
    m_settings.depth = depth;
    wake();
    return Ok{};
}

// The whole tissue.

Status SpringScanTissue::place_scan(std::span<const Vec3d> positions_mm) const {
    for (std::size_t n = 0; n < positions_mm.size(); ++n)
        m_displacements[n] = positions_mm[n] - m_rest.nodes_mm[n];
    return control().place(m_displacements);
}

Status SpringScanTissue::set_positions(std::span<const Vec3d> positions_mm) {
    std::vector<Vec3d> moved(positions_mm.begin(), positions_mm.end());
    std::vector<std::int32_t> away;
    const auto count = std::min(moved.size(), std::size_t(node_count()));
    for (std::size_t n = 0; n < count; ++n) {
        moved[n] = positions_mm[n] - m_rest.nodes_mm[n];
        if (moved[n] != Vec3d{0, 0, 0} && !is_fixed(std::int32_t(n)))
            away.push_back(std::int32_t(n));
    }
    if (const Status s = control().place(moved); !s.ok()) return s;
    m_tools.clear();
    m_former.assign(away.begin(), away.end());
    put(positions_mm, m_memory.velocities);
    renew_sources();
    wake();
    m_settled = m_former.empty();
    return Ok{};
}

// The same tissue as a SpringDeformation.

struct SpringDeformation::Impl {
    std::unique_ptr<SpringScanTissue> tissue;
};

SpringDeformation::SpringDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringDeformation::~SpringDeformation() = default;

Result<std::unique_ptr<SpringDeformation>> SpringDeformation::create(
    const Volume& volume, const SpringDeformationSettings& settings,
    const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<SpringDeformation>> {
        auto tissue = SpringScanTissue::create(volume, settings, arena);
        if (!tissue.ok()) return tissue.error();
        auto impl = std::make_unique<Impl>(Impl{std::move(*tissue)});
        return std::unique_ptr<SpringDeformation>(new SpringDeformation(std::move(impl)));
    });
}

Result<PushReport> SpringDeformation::push(std::uint32_t tool, const Push& push) noexcept {
    return m_impl->tissue->push(tool, push);
}
void SpringDeformation::let_go(std::uint32_t tool) noexcept {
    m_impl->tissue->release(tool);
}
bool SpringDeformation::is_held() const {
    return m_impl->tissue->is_touched();
}
bool SpringDeformation::holds(std::uint32_t tool) const {
    return m_impl->tissue->is_touched_by(tool);
}
Result<SpringMotion> SpringDeformation::step(int count) noexcept {
    return attempt([&] { return m_impl->tissue->step_nodes(count); });
}
double SpringDeformation::time_step_s() const {
    return m_impl->tissue->time_step_s();
}
bool SpringDeformation::is_settled() const {
    return m_impl->tissue->is_settled();
}
Result<CutReport> SpringDeformation::cut(const CutSurface& surface) noexcept {
    return m_impl->tissue->cut(surface);
}
std::span<const CutTriangle> SpringDeformation::cuts_mm() const {
    return m_impl->tissue->control().cuts_mm();
}
Result<DepthFound> SpringDeformation::find_depth(double threshold_mm,
                                                 std::int32_t max_depth) const noexcept {
    return attempt([&] { return m_impl->tissue->find_depth(threshold_mm, max_depth); });
}
const SpringDeformationSettings& SpringDeformation::settings() const {
    return m_impl->tissue->scan_settings();
}
Status SpringDeformation::set_depth(std::int32_t depth) noexcept {
    return m_impl->tissue->set_depth(depth);
}
void SpringDeformation::reset() noexcept {
    (void)m_impl->tissue->reset();
}
Vec3d SpringDeformation::force_n(std::uint32_t tool) {
    return m_impl->tissue->force_n(tool).value_or(Vec3d{0, 0, 0});
}
const std::vector<Vec3d>& SpringDeformation::displacements_mm() const {
    (void)update_deformation();
    return m_impl->tissue->displacements_mm();
}
std::vector<Vec3d> SpringDeformation::positions_mm() const {
    std::vector<Vec3d> positions(std::size_t(m_impl->tissue->node_count()));
    positions_mm(positions);
    return positions;
}
void SpringDeformation::positions_mm(std::span<Vec3d> positions_mm) const noexcept {
    m_impl->tissue->positions_mm(positions_mm);
}
Status SpringDeformation::set_positions(std::span<const Vec3d> positions_mm) noexcept {
    return attempt([&] { return m_impl->tissue->set_positions(positions_mm); });
}
Status SpringDeformation::set_shape(std::span<const Vec3d> positions_mm,
                                    std::span<const CutTriangle> cuts_mm) noexcept {
    return attempt([&] { return m_impl->tissue->set_shape(positions_mm, cuts_mm); });
}
const ControlLattice& SpringDeformation::control() const {
    (void)update_deformation();
    return m_impl->tissue->control();
}
std::int32_t SpringDeformation::fixed_nodes() const {
    return m_impl->tissue->fixed_nodes();
}
std::uint64_t SpringDeformation::hash() const {
    return m_impl->tissue->hash();
}
const Volume& SpringDeformation::volume() const {
    return m_impl->tissue->volume();
}
const Deformation& SpringDeformation::deformation() const {
    return m_impl->tissue->deformation();
}
const TaskArena& SpringDeformation::arena() const {
    return m_impl->tissue->arena();
}
Status SpringDeformation::update_deformation() const noexcept {
    return m_impl->tissue->update_deformation();
}

}  // namespace pliant
