// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <chrono>

#include "base/errors.h"
#include "tissue/scan_network.h"
#include "tissue/spring_deformation_impl.h"

namespace pliant {
namespace {

constexpr double kSettled_mm_s = 0.05;
constexpr double kBack_mm = 0.02;  ///< a settled node nearer to its rest position is moved to it
constexpr double kNewtonPerMicronewton = 1e-6;

}  // namespace

SpringDeformation::SpringDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringDeformation::~SpringDeformation() = default;

Result<std::unique_ptr<SpringDeformation>> SpringDeformation::create(
    const Volume& volume, const SpringDeformationSettings& settings,
    const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<SpringDeformation>> {
        if (const Status s = check_volume(volume); !s.ok()) return s.error();
        if (const Status s = check(settings, spring_rows()); !s.ok()) return s.error();
        const auto grid = control_grid(volume, settings);
        if (!grid.ok()) return grid.error();
        auto control = ControlLattice::create(volume, *grid, arena);
        if (!control.ok()) return control.error();
        auto tissue = tissue_of(volume, *grid, settings);
        if (!tissue.ok()) return tissue.error();
        auto impl = std::make_unique<Impl>(settings, std::move(*control), std::move(*tissue));
        return std::unique_ptr<SpringDeformation>(new SpringDeformation(std::move(impl)));
    });
}

// Time.

void SpringDeformation::Impl::put(std::span<const Vec3d> positions) noexcept {
    for (std::size_t n = 0; n < positions.size(); ++n)
        if (!is_fixed(std::int32_t(n)))
            (void)tissue.set_state(std::int32_t(n), positions[n], {0, 0, 0});
}

/// Sets all velocities to zero.
void SpringDeformation::Impl::stop() noexcept {
    for (std::int32_t n = 0; n < control->node_count(); ++n)
        if (!is_fixed(n)) (void)tissue.set_state(n, tissue.position(n), {0, 0, 0});
}

/// Moves nodes near their rest position to it. Nodes that forces no longer reach, since the depth
/// was reduced, then start to move freely.
void SpringDeformation::Impl::come_to_rest() noexcept {
    stop();
    if (!held.empty()) return;
    double farthest = 0;
    std::vector<std::int32_t>& away = loose;
    away.clear();
    for (std::int32_t n = 0; n < control->node_count(); ++n) {
        const double distance = norm(tissue.displacement(n));
        farthest = std::max(farthest, distance);
        if (distance > 0 && !is_fixed(n)) away.push_back(n);
    }
    if (farthest < kBack_mm) {
        tissue.reset();
        former.clear();
    } else if (away != former) {
        former.assign(away.begin(), away.end());
        settled = false;
    }
    renew_sources();
}

Result<SpringMotion> SpringDeformation::step(int count) noexcept {
    return attempt([&] { return m_impl->step(count); });
}

Result<SpringMotion> SpringDeformation::Impl::step(int count) {
    SpringMotion motion;
    const auto start = std::chrono::steady_clock::now();
    if (!settled) {
        const auto stepped = tissue.step(count, control->arena());
        if (stepped.ok()) {
            motion.steps = stepped->steps;
            motion.active_nodes = stepped->active_nodes;
            for (std::int32_t n = 0; n < control->node_count(); ++n)
                motion.fastest_mm_s = std::max(motion.fastest_mm_s, norm(tissue.velocity(n)));
            settled = motion.fastest_mm_s < kSettled_mm_s;
        } else if (is_out_of_memory(stepped.error())) {
            return stepped.error();
        } else {
            try {
                motion.message = stepped.error().message;
            } catch (const std::bad_alloc&) {  // earlier steps are complete
                motion.message = "unstable";
            }
            settled = true;
        }
        if (settled) come_to_rest();
        is_shown = false;
    }
    motion.settled = settled;
    motion.solve_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return motion;
}

double SpringDeformation::time_step_s() const {
    return m_impl->tissue.time_step();
}
bool SpringDeformation::is_settled() const {
    return m_impl->settled;
}

// The whole tissue.

Status SpringDeformation::Impl::show() noexcept {
    if (is_shown) return Ok{};
    for (std::int32_t n = 0; n < control->node_count(); ++n)
        displacements[std::size_t(n)] = tissue.displacement(n);
    Status placed = control->place(displacements);
    if (!placed.ok() && is_out_of_memory(placed.error())) return placed;
    is_shown = true;
    return Ok{};
}

Status SpringDeformation::update_deformation() const noexcept {
    return m_impl->show();
}

const SpringDeformationSettings& SpringDeformation::settings() const {
    return m_impl->settings;
}

Status SpringDeformation::set_depth(std::int32_t depth) noexcept {
    if (const Status s = m_impl->tissue.set_depth(depth); !s.ok()) return s;
    m_impl->settings.depth = depth;
    m_impl->settled = false;
    return Ok{};
}

void SpringDeformation::reset() noexcept {
    Impl& m = *m_impl;
    m.tools.clear();
    m.former.clear();
    m.renew_sources();
    m.tissue.reset();
    m.settled = true;
    m.is_shown = false;
}

Vec3d SpringDeformation::force_n(std::uint32_t tool) {
    const auto found = m_impl->tools.find(tool);
    if (found == m_impl->tools.end()) return {0, 0, 0};
    const auto reaction = m_impl->tissue.reaction(found->second, ReactionLaw::Held);
    return reaction.ok() ? kNewtonPerMicronewton * reaction->force : Vec3d{0, 0, 0};
}

const std::vector<Vec3d>& SpringDeformation::displacements_mm() const {
    (void)m_impl->show();
    return m_impl->displacements;
}

std::vector<Vec3d> SpringDeformation::positions_mm() const {
    std::vector<Vec3d> positions(std::size_t(m_impl->control->node_count()));
    positions_mm(positions);
    return positions;
}

void SpringDeformation::positions_mm(std::span<Vec3d> positions_mm) const noexcept {
    for (std::size_t n = 0; n < positions_mm.size(); ++n)
        positions_mm[n] = m_impl->tissue.position(std::int32_t(n));
}

Status SpringDeformation::set_positions(std::span<const Vec3d> positions_mm) noexcept {
    return attempt([&] { return m_impl->set_positions(positions_mm); });
}

Status SpringDeformation::Impl::set_positions(std::span<const Vec3d> positions_mm) {
    std::vector<Vec3d> moved(positions_mm.begin(), positions_mm.end());
    std::vector<std::int32_t> away;
    const auto count = std::min(moved.size(), std::size_t(control->node_count()));
    for (std::size_t n = 0; n < count; ++n) {
        moved[n] = positions_mm[n] - tissue.network().nodes()[n].rest;
        if (moved[n] != Vec3d{0, 0, 0} && !is_fixed(std::int32_t(n)))
            away.push_back(std::int32_t(n));
    }
    if (const Status s = control->place(moved); !s.ok()) return s;
    tools.clear();
    former.assign(away.begin(), away.end());
    put(positions_mm);
    renew_sources();
    settled = former.empty();
    is_shown = false;
    return Ok{};
}

const ControlLattice& SpringDeformation::control() const {
    (void)m_impl->show();
    return *m_impl->control;
}
std::int32_t SpringDeformation::fixed_nodes() const {
    return m_impl->fixed;
}
std::uint64_t SpringDeformation::hash() const {
    return m_impl->tissue.hash() ^ m_impl->hash_of_cuts();
}

const Volume& SpringDeformation::volume() const {
    return m_impl->control->volume();
}
const Deformation& SpringDeformation::deformation() const {
    (void)m_impl->show();
    return m_impl->control->deformation();
}
const TaskArena& SpringDeformation::arena() const {
    return m_impl->control->arena();
}

}  // namespace pliant
