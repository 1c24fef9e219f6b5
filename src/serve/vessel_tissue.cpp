// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/vessel_tissue.h"

#include <algorithm>
#include <chrono>

#include "core/errors.h"
#include "scene/number_file.h"

namespace pliant::serve {
namespace {

// It has come to rest when nothing is farther than this from where it was so many sweeps ago. The
// end of a wire that is pressed to the wall trembles by a hundredth of a millimetre for ever.
constexpr double kCalm_mm = 0.02;
constexpr int kCalmSweeps = 50;
// Of undo; a state of 12,000 nodes has 0.6 MB.
constexpr std::size_t kMostSteps = 200, kMostBytes = 256'000'000;
constexpr std::uint64_t kMagic = 0x32'76'73'6c'70'00'00'0a;  ///< of a file with a state
constexpr int kMostUntoldSweeps = 1000;  ///< what nobody drives comes to a halt in any case

Error no_tools(const char* what) {
    return invalid(std::string(what) + ": expected another tissue than a vessel");
}

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

void VesselTissue::release(std::uint32_t tool) {
    if (is_touched_by(tool)) (void)drive(tool, {.insert_mm_s = 0, .rotate_deg_s = 0});
}

Result<PushReport> VesselTissue::push(std::uint32_t, const Push&) {
    return no_tools("push");
}
Result<GrabReport> VesselTissue::grab(std::uint32_t, const Push&, double) {
    return no_tools("grab");
}
Result<PushReport> VesselTissue::drag_to(Vec3d) {
    return no_tools("drag");
}

/// Whether nothing has moved since the last time that this was asked.
bool VesselTissue::is_calm() {
    const auto wire = m_scene->wire_places();
    std::vector<Vec3d> wall = m_scene->wall_places();
    const bool has_before = m_wire.size() == wire.size() && m_wall.size() == wall.size();
    const bool calm =
        has_before && farthest(wire, m_wire) < kCalm_mm && farthest(wall, m_wall) < kCalm_mm;
    m_wire.assign(wire.begin(), wire.end());
    m_wall = std::move(wall);
    return calm;
}

Sweep VesselTissue::sweep() {
    const auto start = std::chrono::steady_clock::now();
    const auto ms = [&] {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count();
    };
    if (!m_failure.empty()) return {};
    const Status stepped = m_scene->step(kStepsPerSweep, m_arena);
    m_is_shown = false;
    if (!stepped.ok()) {
        m_failure = stepped.error().message;
        return {true, ms()};
    }
    ++m_untold;
    if (is_touched()) return {false, ms()};
    const bool calm = m_untold % kCalmSweeps == 0 && is_calm();
    return {calm || m_untold >= kMostUntoldSweeps, ms()};
}

/// As it is when a state is put back: the hand rests, and whether it is calm is asked anew.
void VesselTissue::halt() {
    m_hand.insert_mm_s = m_hand.rotate_deg_s = 0;
    (void)m_scene->command(m_hand);
    m_driver = 0;
    m_untold = 0;
    m_wire.clear();
    m_wall.clear();
    m_is_shown = false;
    // Contacts are found anew after a state was put back, so they are here.
    (void)m_scene->restore(m_scene->state(), m_arena);
}

void VesselTissue::reset() {
    auto scene = CatheterScene::create(m_vessel.wall, m_vessel.settings);
    if (!scene.ok()) return;  // it could be made before
    m_scene = std::make_unique<CatheterScene>(std::move(*scene));
    m_hand = {};
    m_failure.clear();
    halt();
}

void VesselTissue::begin_group(const std::string&) {
    m_before = m_scene->state();
}

int VesselTissue::end_group() {
    if (!m_before || *m_before == m_scene->state()) return 0;
    m_undone.clear();
    m_done.push_back(std::move(*m_before));
    m_before.reset();
    int forgotten = 0;
    const std::size_t bytes = m_done.back().size() * sizeof(double);
    while (m_done.size() > kMostSteps || m_done.size() * bytes > kMostBytes) {
        m_done.pop_front();
        ++forgotten;
    }
    return m_done.empty() ? -1 : forgotten;
}

Status VesselTissue::put_back(std::span<const double> state) {
    if (const Status s = m_scene->restore(state, m_arena); !s.ok()) return s;
    m_hand = m_scene->hand();
    m_failure.clear();
    halt();
    return Ok{};
}

Status VesselTissue::undo() {
    if (m_done.empty()) return Error{ErrorCode::NotFound, "undo: expected a step, found none"};
    m_undone.push_back(m_scene->state());
    const State state = std::move(m_done.back());
    m_done.pop_back();
    return put_back(state);
}

Status VesselTissue::redo() {
    if (m_undone.empty()) return Error{ErrorCode::NotFound, "redo: expected a step, found none"};
    m_done.push_back(m_scene->state());
    const State state = std::move(m_undone.back());
    m_undone.pop_back();
    return put_back(state);
}

Status VesselTissue::save_state(const std::filesystem::path& path) const {
    return save_numbers(path, kMagic, m_scene->state());
}

Status VesselTissue::load_state(const std::filesystem::path& path) {
    const auto state = load_numbers(path, kMagic);
    if (!state.ok()) return state.error();
    if (const Status s = put_back(*state); !s.ok())
        return unreadable(path.filename(), s.error().message);
    m_done.clear();
    m_undone.clear();
    return Ok{};
}

void VesselTissue::show() const {
    if (m_is_shown) return;
    m_is_shown = true;
    m_now.nodes_mm = m_scene->wall_places();
    const VesselWall& rest = m_vessel.wall;
    m_view.wall_moved_mm = farthest(m_now.nodes_mm, rest.mesh.nodes_mm);
    m_view.moved_mm.resize(rest.ghost_places.size());
    for (std::size_t n = 0; n < rest.ghost_places.size(); ++n) {
        const Vec3d by = place_of(rest.ghost_places[n], m_now) - rest.ghost.nodes_mm[n];
        m_view.moved_mm[n] = {float(by.x), float(by.y), float(by.z)};
    }
    m_view.inverted = m_scene->inverted_tetrahedra();
    const auto wire = m_scene->wire_places();
    m_view.catheter_mm.assign(wire.begin() + m_scene->first_inserted(), wire.end());
    (void)m_carried.update(m_now.nodes_mm);
}

const VesselView& VesselTissue::view() const {
    show();
    return m_view;
}

const Lattice& VesselTissue::lattice() const {
    show();
    return m_carried.scan().lattice();
}

}  // namespace pliant::serve
