// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scene_files.h>

#include "session/vessel_tissue.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "base/errors.h"

namespace pliant::serve {
namespace {

// The wire is calm if no node has moved farther than this in that many sweeps. The end of a wire
// that is pressed to the wall vibrates by 0.01 mm forever.
constexpr double kCalm_mm = 0.02;
constexpr int kCalmSweeps = 50;
constexpr int kMaxUntoldSweeps = 1000;  ///< limit of motion without commands

double farthest(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    double most = 0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, norm(a[n] - b[n]));
    return most;
}

}  // namespace

VesselTissue::VesselTissue(const MadeVessel& vessel, CatheterScene scene, CarriedScan carried,
                           const TaskArena& arena)
    : m_vessel(vessel),
      m_arena(arena),
      m_scene(std::make_unique<CatheterScene>(std::move(scene))),
      m_carried(std::move(carried)),
      m_now(vessel.wall.mesh) {}

Result<std::unique_ptr<VesselTissue>> VesselTissue::create(const MadeVessel& vessel,
                                                           const Volume& scan,
                                                           const TaskArena& arena) {
    auto scene = CatheterScene::create(vessel.wall, vessel.settings);
    if (!scene.ok()) return scene.error();
    auto carried = CarriedScan::create(scan, vessel.wall.mesh, {}, arena);
    if (!carried.ok()) return carried.error();
    return std::unique_ptr<VesselTissue>(
        new VesselTissue(vessel, std::move(*scene), std::move(*carried), arena));
}

Status VesselTissue::drive(std::uint32_t client, const DriveCommand& command) {
    CatheterCommand hand = m_hand;
    hand.insert_mm_s = command.insert_mm_s.value_or(hand.insert_mm_s);
    hand.rotate_deg_s = command.rotate_deg_s.value_or(hand.rotate_deg_s);
    hand.bend_first_deg = command.bend_first_deg.value_or(hand.bend_first_deg);
    hand.bend_second_deg = command.bend_second_deg.value_or(hand.bend_second_deg);
    if (const Status s = m_scene->command(hand); !s.ok()) return s;
    m_hand = hand;
    m_driver = hand.insert_mm_s != 0 || hand.rotate_deg_s != 0 ? client : 0;
    m_untold = 0;
    return Ok{};
}

void VesselTissue::release(std::uint32_t tool) noexcept {
    if (is_touched_by(tool)) (void)drive(tool, {.insert_mm_s = 0, .rotate_deg_s = 0});
}

TissueTraits VesselTissue::traits() const noexcept {
    return {.model = "vessel",
            .takes_pushes = false,
            .moves_by_itself = true,
            .sweep_ms = 1000 * kStepsPerSweep * m_vessel.settings.time_step_s,
            .update_hz = 1 / m_vessel.settings.time_step_s};
}

Result<PushReport> VesselTissue::push(std::uint32_t, const Push&) noexcept {
    return attempt([]() -> Result<PushReport> {
        return invalid("push: expected another tissue than a vessel");
    });
}

/// Whether the nodes have not moved since the last call. Returns false without memory for the
/// comparison.
bool VesselTissue::is_calm() noexcept try {
    const auto wire = m_scene->wire_positions();
    std::vector<Vec3d> wall = m_scene->wall_positions();
    m_wire.reserve(wire.size());
    const bool has_before = m_wire.size() == wire.size() && m_wall.size() == wall.size();
    const bool calm =
        has_before && farthest(wire, m_wire) < kCalm_mm && farthest(wall, m_wall) < kCalm_mm;
    m_wire.assign(wire.begin(), wire.end());
    m_wall = std::move(wall);
    return calm;
} catch (const std::bad_alloc&) {
    return false;
}

Result<Sweep> VesselTissue::sweep() noexcept {
    return attempt([&]() -> Result<Sweep> {
        const auto start = std::chrono::steady_clock::now();
        const auto ms = [&] {
            return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                             start)
                .count();
        };
        if (!m_failure.empty()) return Sweep{};
        const Status stepped = m_scene->step(kStepsPerSweep, m_arena);
        if (!stepped.ok() && is_out_of_memory(stepped.error())) return stepped.error();
        m_is_shown = false;
        if (!stepped.ok()) {
            m_failure = stepped.error().message;
            return Sweep{true, ms()};
        }
        ++m_untold;
        if (is_touched()) return Sweep{false, ms()};
        const bool calm = m_untold % kCalmSweeps == 0 && is_calm();
        return Sweep{calm || m_untold >= kMaxUntoldSweeps, ms()};
    });
}

/// State after a restore: the hand rests, and calmness is tested from scratch.
Status VesselTissue::halt() noexcept {
    CatheterCommand still = m_hand;
    still.insert_mm_s = still.rotate_deg_s = 0;
    if (const Status s = m_scene->command(still); !s.ok()) return s;
    // A restore detects contacts again, so they are detected here too.
    const Status restored = attempt([&] { return m_scene->restore(m_scene->state(), m_arena); });
    if (!restored.ok() && is_out_of_memory(restored.error())) {
        (void)m_scene->command(m_hand);
        return restored;
    }
    m_hand = still;
    m_driver = 0;
    m_untold = 0;
    m_wire.clear();
    m_wall.clear();
    m_is_shown = false;
    return Ok{};
}

/// Builds another scene to replace this one: if memory runs out, it can be discarded.
Status VesselTissue::reset() noexcept {
    return attempt([&]() -> Status {
        auto made = CatheterScene::create(m_vessel.wall, m_vessel.settings);
        if (!made.ok()) return made.error();
        auto scene = std::make_unique<CatheterScene>(std::move(*made));
        const CatheterCommand hand = std::exchange(m_hand, {});
        m_scene.swap(scene);
        if (const Status s = halt(); !s.ok()) {
            m_scene.swap(scene);
            m_hand = hand;
            return s;
        }
        m_failure.clear();
        return Ok{};
    });
}

Status VesselTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const std::vector<double> now = m_scene->state();
        if (const Status s = m_scene->restore(numbers, m_arena); !s.ok()) return s;
        const CatheterCommand hand = std::exchange(m_hand, m_scene->hand());
        if (const Status s = halt(); !s.ok()) {
            (void)m_scene->restore(now, m_arena);
            m_hand = hand;
            return s;
        }
        m_failure.clear();
        return Ok{};
    });
}

Status VesselTissue::show() const {
    if (m_is_shown) return Ok{};
    m_now.nodes_mm = m_scene->wall_positions();
    const VesselWall& rest = m_vessel.wall;
    m_view.wall_moved_mm = farthest(m_now.nodes_mm, rest.mesh.nodes_mm);
    m_view.moved_mm.resize(rest.ghost_positions.size());
    for (std::size_t n = 0; n < rest.ghost_positions.size(); ++n) {
        const Vec3d by = place_of(rest.ghost_positions[n], m_now) - rest.ghost.nodes_mm[n];
        m_view.moved_mm[n] = {float(by.x), float(by.y), float(by.z)};
    }
    m_view.inverted = m_scene->inverted_tetrahedra();
    const auto wire = m_scene->wire_positions();
    m_view.catheter_mm.assign(wire.begin() + m_scene->first_inserted(), wire.end());
    const Status updated = m_carried.update(m_now.nodes_mm);
    if (!updated.ok() && is_out_of_memory(updated.error())) return updated;
    m_is_shown = true;
    return Ok{};
}

Status VesselTissue::update_deformation() const {
    return attempt([&] { return show(); });
}

const VesselView& VesselTissue::view() const {
    (void)update_deformation();
    return m_view;
}

const Deformation& VesselTissue::deformation() const {
    (void)update_deformation();
    return m_carried.scan().deformation();
}

}  // namespace pliant::serve
