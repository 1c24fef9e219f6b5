// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel as a tissue: a catheter is driven, the wall deforms, and the scan moves with the wall. A
// sweep is two steps of the simulation. Simulated time stops once the motion has settled, until the
// next command.

#include <pliant/models/drivable.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "base/stopwatch.h"

namespace pliant {
namespace {

constexpr int kStepsPerSweep = 2;
// The wire is calm if no node has moved farther than this in that many sweeps. The end of a wire
// that is pressed to the wall vibrates by 0.01 mm forever.
constexpr double kCalmWire_mm = 0.02;
constexpr int kCalmSweeps = 50;
constexpr int kMaxUntoldSweeps = 1000;  ///< limit of motion without commands

double farthest(std::span<const Vec3d> a, std::span<const Vec3d> b) {
    double most = 0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, norm(a[n] - b[n]));
    return most;
}

class VesselTissue final : public NodeTissue, public Drivable {
  public:
    VesselTissue(const CatheterSettings& settings, CatheterScene scene, CarriedScan carried,
                 const TaskArena& arena)
        : m_settings(settings),
          m_arena(arena),
          m_scene(std::make_unique<CatheterScene>(std::move(scene))),
          m_carried(std::move(carried)),
          m_now(m_scene->wall().mesh) {}

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_driver == tool && tool != 0;
    }
    bool is_touched() const noexcept override { return m_driver != 0; }
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;
    Status rest() noexcept override { return halt(); }
    Drivable* drivable() noexcept override { return this; }

    void state(std::vector<double>& numbers) const override { numbers = m_scene->state(); }
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x32'76'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override { return m_scene->hash(); }

    const Volume& volume() const override { return m_carried.scan().volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_arena; }
    Status update_deformation() const override;

    Status drive(std::uint32_t tool, const CatheterCommand& hand) noexcept override;
    CatheterCommand hand() const noexcept override { return m_hand; }
    CatheterMeasures measures() const noexcept override { return m_scene->quick_measures(); }
    const CatheterView& view() const noexcept override;
    std::string failure() const override { return m_failure; }
    double radius_mm() const noexcept override { return m_settings.catheter.radius_mm; }
    double length_mm() const noexcept override { return m_settings.catheter.length_mm; }
    CatheterEntry entry() const noexcept override { return m_settings.entry; }
    const TriangleMesh& wall() const noexcept override { return m_scene->wall().ghost; }

  private:
    bool is_calm() noexcept;
    Status halt() noexcept;

    const CatheterSettings m_settings;  ///< as given: the scene's own have the actual sub-steps
    const TaskArena& m_arena;
    std::unique_ptr<CatheterScene> m_scene;
    CatheterCommand m_hand{};
    std::uint32_t m_driver = 0;         ///< tool of the hand that moves; 0: none
    int m_untold = 0;                   ///< sweeps since the last command
    std::vector<Vec3d> m_wire, m_wall;  ///< at the last call of is_calm()
    std::string m_failure;

    // Display data are computed on demand, not in each step.
    mutable CarriedScan m_carried;
    mutable TetMesh m_now;
    mutable CatheterView m_view;
    mutable bool m_is_shown = false;
};

Status VesselTissue::drive(std::uint32_t tool, const CatheterCommand& hand) noexcept {
    if (const Status s = m_scene->command(hand); !s.ok()) return s;
    m_hand = hand;
    m_driver = hand.insert_mm_s != 0 || hand.rotate_deg_s != 0 ? tool : 0;
    m_untold = 0;
    return Ok{};
}

void VesselTissue::release(std::uint32_t tool) noexcept {
    CatheterCommand still = m_hand;
    still.insert_mm_s = still.rotate_deg_s = 0;
    if (is_touched_by(tool)) (void)drive(tool, still);
}

TissueTraits VesselTissue::traits() const noexcept {
    return {.model = "vessel",
            .takes_pushes = false,
            .moves_by_itself = true,
            .sweep_ms = 1000 * kStepsPerSweep * m_settings.time_step_s,
            .update_hz = 1 / m_settings.time_step_s};
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
    const bool calm = has_before && farthest(wire, m_wire) < kCalmWire_mm &&
                      farthest(wall, m_wall) < kCalmWire_mm;
    m_wire.assign(wire.begin(), wire.end());
    m_wall = std::move(wall);
    return calm;
} catch (const std::bad_alloc&) {
    return false;
}

Result<Sweep> VesselTissue::sweep() noexcept {
    return attempt([&]() -> Result<Sweep> {
        const Stopwatch watch;
        if (!m_failure.empty()) return Sweep{};
        const Status stepped = m_scene->step(kStepsPerSweep, m_arena);
        if (!stepped.ok() && is_out_of_memory(stepped.error())) return stepped.error();
        m_is_shown = false;
        if (!stepped.ok()) {
            m_failure = stepped.error().message;
            return Sweep{true, watch.ms()};
        }
        ++m_untold;
        if (is_touched()) return Sweep{false, watch.ms()};
        const bool calm = m_untold % kCalmSweeps == 0 && is_calm();
        return Sweep{calm || m_untold >= kMaxUntoldSweeps, watch.ms()};
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
        auto made = CatheterScene::create(m_scene->wall(), m_settings);
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

Status VesselTissue::update_deformation() const {
    return attempt([&]() -> Status {
        if (m_is_shown) return Ok{};
        m_now.nodes_mm = m_scene->wall_positions();
        const VesselWall& rest = m_scene->wall();
        m_view.wall_moved_mm = farthest(m_now.nodes_mm, rest.mesh.nodes_mm);
        m_view.moved_mm.resize(rest.ghost_positions.size());
        for (std::size_t n = 0; n < rest.ghost_positions.size(); ++n) {
            const Vec3d by = position_of(rest.ghost_positions[n], m_now) - rest.ghost.nodes_mm[n];
            m_view.moved_mm[n] = {float(by.x), float(by.y), float(by.z)};
        }
        m_view.inverted = m_scene->inverted_tetrahedra();
        const auto wire = m_scene->wire_positions();
        m_view.catheter_mm.assign(wire.begin() + m_scene->first_inserted(), wire.end());
        const Status updated = m_carried.update(m_now.nodes_mm);
        if (!updated.ok() && is_out_of_memory(updated.error())) return updated;
        m_is_shown = true;
        return Ok{};
    });
}

const CatheterView& VesselTissue::view() const noexcept {
    (void)update_deformation();
    return m_view;
}

const Deformation& VesselTissue::deformation() const {
    (void)update_deformation();
    return m_carried.scan().deformation();
}

}  // namespace

Result<std::unique_ptr<Tissue>> make_vessel(const Volume& scan, VesselWall wall,
                                            const CatheterSettings& settings,
                                            const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        auto scene = CatheterScene::create(std::move(wall), settings);
        if (!scene.ok()) return scene.error();
        auto carried = CarriedScan::create(scan, scene->wall().mesh, {}, arena);
        if (!carried.ok()) return carried.error();
        return std::unique_ptr<Tissue>(
            new VesselTissue(settings, std::move(*scene), std::move(*carried), arena));
    });
}

}  // namespace pliant
