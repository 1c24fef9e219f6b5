// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <chrono>

#include "scene/scan_network.h"
#include "scene/spring_deformation_impl.h"

namespace pliant {
namespace {

constexpr double kSettled_mm_s = 0.05;
constexpr double kBack_mm = 0.02;  ///< a settled node nearer to its rest place is put there
constexpr double kNewtonPerMicronewton = 1e-6;

}  // namespace

SpringDeformation::SpringDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringDeformation::~SpringDeformation() = default;

Result<std::unique_ptr<SpringDeformation>> SpringDeformation::create(
    const Volume& volume, const SpringDeformationSettings& settings, const TaskArena& arena) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (const Status s = check_settings(settings); !s.ok()) return s.error();
    const auto grid = control_grid(volume, settings);
    if (!grid.ok()) return grid.error();
    auto control = ControlLattice::create(volume, *grid, arena);
    if (!control.ok()) return control.error();
    auto tissue = tissue_of(volume, *grid, settings);
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<SpringDeformation>(new SpringDeformation(
        std::make_unique<Impl>(settings, std::move(*control), std::move(*tissue))));
}

// Time.

void SpringDeformation::Impl::put(std::span<const Vec3d> places) {
    for (std::size_t n = 0; n < places.size(); ++n)
        (void)tissue.set_state(std::int32_t(n), places[n], {0, 0, 0});
}

/// No speed any more.
void SpringDeformation::Impl::stop() {
    std::vector<Vec3d> places;
    for (std::int32_t n = 0; n < control->node_count(); ++n) places.push_back(tissue.position(n));
    put(places);
}

/// What came back is back. What no force reaches any more, because the depth is less than it was,
/// begins to move by itself.
void SpringDeformation::Impl::come_to_rest() {
    stop();
    if (!held.empty()) return;
    double farthest = 0;
    std::vector<std::int32_t> away;
    for (std::int32_t n = 0; n < control->node_count(); ++n) {
        const double distance = norm(tissue.displacement(n));
        farthest = std::max(farthest, distance);
        if (distance > 0 && !is_fixed(n)) away.push_back(n);
    }
    if (farthest < kBack_mm) {
        tissue.reset();
        former.clear();
    } else if (away != former) {
        former = std::move(away);
        settled = false;
    }
    renew_sources();
}

SpringMotion SpringDeformation::step(int count) {
    Impl& m = *m_impl;
    SpringMotion motion;
    const auto start = std::chrono::steady_clock::now();
    if (!m.settled) {
        const auto stepped = m.tissue.step(count, m.control->arena());
        if (stepped.ok()) {
            motion.steps = stepped->steps;
            motion.active_nodes = stepped->active_nodes;
            for (std::int32_t n = 0; n < m.control->node_count(); ++n)
                motion.fastest_mm_s = std::max(motion.fastest_mm_s, norm(m.tissue.velocity(n)));
            m.settled = motion.fastest_mm_s < kSettled_mm_s;
        } else {
            motion.message = stepped.error().message;
            m.settled = true;
        }
        if (m.settled) m.come_to_rest();
        m.is_shown = false;
    }
    motion.settled = m.settled;
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

void SpringDeformation::Impl::show() {
    if (is_shown) return;
    displacements = tissue.displacements();
    (void)control->place(displacements);
    is_shown = true;
}

const SpringDeformationSettings& SpringDeformation::settings() const {
    return m_impl->settings;
}

Status SpringDeformation::set_depth(std::int32_t depth) {
    if (const Status s = m_impl->tissue.set_depth(depth); !s.ok()) return s;
    m_impl->settings.depth = depth;
    m_impl->settled = false;
    return Ok{};
}

void SpringDeformation::reset() {
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
    m_impl->show();
    return m_impl->displacements;
}

std::vector<Vec3d> SpringDeformation::places_mm() const {
    std::vector<Vec3d> places;
    for (std::int32_t n = 0; n < m_impl->control->node_count(); ++n)
        places.push_back(m_impl->tissue.position(n));
    return places;
}

Status SpringDeformation::set_places(std::span<const Vec3d> places_mm) {
    Impl& m = *m_impl;
    std::vector<Vec3d> moved(places_mm.begin(), places_mm.end());
    std::vector<std::int32_t> away;
    const auto count = std::min(moved.size(), std::size_t(m.control->node_count()));
    for (std::size_t n = 0; n < count; ++n) {
        moved[n] = places_mm[n] - m.tissue.network().nodes()[n].rest;
        if (moved[n] != Vec3d{0, 0, 0} && !m.is_fixed(std::int32_t(n)))
            away.push_back(std::int32_t(n));
    }
    if (const Status s = m.control->place(moved); !s.ok()) return s;
    m.tools.clear();
    m.former = std::move(away);
    m.put(places_mm);
    m.renew_sources();
    m.settled = m.former.empty();
    m.is_shown = false;
    return Ok{};
}

const ControlLattice& SpringDeformation::control() const {
    m_impl->show();
    return *m_impl->control;
}
std::int32_t SpringDeformation::fixed_nodes() const {
    return m_impl->fixed;
}
std::uint64_t SpringDeformation::hash() const {
    return m_impl->tissue.hash();
}

const Volume& SpringDeformation::volume() const {
    return m_impl->control->volume();
}
const Lattice& SpringDeformation::lattice() const {
    m_impl->show();
    return m_impl->control->lattice();
}
const TaskArena& SpringDeformation::arena() const {
    return m_impl->control->arena();
}

}  // namespace pliant
