// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter is fed into a vessel: its wall as position-based tissue, the wire (a rod or a body of
// tetrahedra) with contact within its Newton steps, and boxes of which only those near the wire
// move.
//
//   auto wall = wall_around_centreline(centreline, {.thickness_mm = 1.5}, arena);
//   auto scene = CatheterScene::create(*wall, {.entry = entry_at(wall->ends[1])});
//   scene->command({.insert_mm_s = 50, .bend_first_deg = 20});
//   scene->step(1000, arena);                                  // of a millisecond each
//   scene->measures().force_n, scene->wire_places(), scene->wall_places()
//
// docs/vessel.md has the model, its limits, and `pliant vessel`.

#pragma once

#include <pliant/pbd.h>
#include <pliant/pbd_rod.h>
#include <pliant/record.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/vessel_wall.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

enum class CatheterModel {
    Rod,         ///< places and turns of a Cosserat rod
    Tetrahedra,  ///< a body of tetrahedra [VesselPbd2016]
};

struct CatheterShape {
    double length_mm = 600;
    double segment_mm = 3;
    double radius_mm = 0.9;
    double bend_n_mm2 = 20;  ///< EI
    /// GJ. With tetrahedra it follows from segment and radius how much of EI it may be, and the
    /// tip's is as much of its own EI.
    double twist_n_mm2 = 20;
    double tip_mm = 30;  ///< that steering bends, and that is softer
    double tip_bend_n_mm2 = 2;
    double mass_g_mm = 4e-3;
    double damping_per_s = 20;
    double friction = 0.05;  ///< Coulomb's, on the wall
    CatheterModel model = CatheterModel::Rod;
};

struct WallTissue {
    double young_modulus_pa = 5e5;
    double poisson_ratio = 0.45;
    /// With the blood and the tissue around that have to move as well. Slow motion doesn't depend
    /// on it; forces are right where sub-steps are small for it (docs/vessel.md).
    double density_g_mm3 = 0.02;
    double support_pa_per_mm = 10000;  ///< of what is around: pressure for a displacement
    double damping_per_s = 100;
};

struct CatheterEntry {
    Vec3d place_mm{0, 0, 0};   ///< where the guide ends
    Vec3d direction{0, 0, 1};  ///< into the vessel
    double inserted_mm = 5;    ///< at first
};
/// In the middle of an open end, a part of its radius inside.
CatheterEntry entry_at(const VesselEnd& end, double inwards = 0.5);

struct CatheterSettings {
    CatheterShape catheter{};
    WallTissue wall{};
    CatheterEntry entry{};
    bool local = true;   ///< only boxes near the catheter move
    double box_mm = 10;  ///< their side
    /// A box this near to the catheter's surface moves; -1: as far as wide_reach_mm says.
    double reach_mm = 2;
    double time_step_s = 1e-3;
    int sub_steps = 5;   ///< at least: as many as contact wants are made (docs/vessel.md)
    int iterations = 4;  ///< of the wire's Newton method, in each sub-step
};

/// Rows of these settings, by their tables in a scene file.
SettingRows<CatheterSettings> catheter_rows() noexcept;

/// The reach with which a local step differs from one of the whole wall by 2 % of the movement at
/// most, from how slowly movement dies away along a tube on its support; 1000 without a support.
double wide_reach_mm(const VesselWall& wall, const WallTissue& tissue);

/// What the hand does, until told otherwise.
struct CatheterCommand {
    double insert_mm_s = 0;
    double rotate_deg_s = 0;
    double bend_first_deg = 0, bend_second_deg = 0;  ///< of the tip, about two axes across
    friend bool operator==(const CatheterCommand&, const CatheterCommand&) = default;
};

struct CatheterMeasures {
    std::int64_t steps = 0;
    double time_s = 0;
    double inserted_mm = 0, rotated_deg = 0;
    double force_n = 0;        ///< along the guide, on the hand that pushes
    double torque_n_mm = 0;    ///< about it
    double contact_n = 0;      ///< of the wire on the wall, sizes summed up
    double wall_moved_mm = 0;  ///< farthest particle from its rest place
    double depth_mm = 0;       ///< the wire's surface beyond the ghost surface; below 0: distance
    double wire_energy_mj = 0, wall_energy_mj = 0, kinetic_energy_mj = 0;
    VolumeChange volume{};
    std::int64_t inverted = 0;  ///< tetrahedra, of wall and catheter
    std::int32_t active_tetrahedra = 0;
    /// Number of the open end that the tip has left the vessel through, from 1 on; 0: none. What is
    /// beyond an end counts in no depth.
    std::int32_t left_end = 0;
};

/// One line for each fault of a state: a point more than 0.1 mm beyond the wall, inverted
/// tetrahedra, a tip that has left the vessel through an open end. Empty where there is none.
std::vector<std::string> warnings_of(const CatheterMeasures& measures);

/// Where memory runs out, functions that return a Result return LimitExceeded and change nothing;
/// those that return a vector or a mesh throw std::bad_alloc.
class CatheterScene {
  public:
    /// @returns InvalidArgument that names the setting, also where the entry isn't in the vessel
    static Result<CatheterScene> create(VesselWall wall, const CatheterSettings& settings) noexcept;
    ~CatheterScene();
    CatheterScene(CatheterScene&&) noexcept;
    CatheterScene& operator=(CatheterScene&&) noexcept;

    const CatheterSettings& settings() const;  ///< with the sub-steps and the reach that are used
    const VesselWall& wall() const;            ///< at rest

    /// @returns InvalidArgument for what is no number
    Status command(const CatheterCommand& command) noexcept;
    const CatheterCommand& hand() const;  ///< the last one
    /// The wire stops where nothing is left to insert or to withdraw.
    /// @returns LimitExceeded where a place is no number any more, or memory runs out: the steps of
    ///          this call that came before stay made, and the one that failed changes nothing
    Status step(std::int32_t count, const TaskArena& arena) noexcept;

    /// Inserted, force, torque, contact, depth and time; the others cost a pass over the wall.
    CatheterMeasures quick_measures() const noexcept;
    CatheterMeasures measures() const noexcept;
    /// Inverted tetrahedra of wall and catheter; a pass over the wall.
    std::int64_t inverted_tetrahedra() const noexcept;
    std::span<const Vec3d> wire_places() const;  ///< [mm], of all nodes; the last is the tip
    std::int32_t first_inserted() const;         ///< the last node in the guide
    Vec3d tip_mm() const;
    Rotation tip_frame()
        const;  ///< whose third axis points ahead; the first two are those of bends
    /// The catheter as tetrahedra, those in the guide too; empty where it is a rod.
    TetMesh catheter_mesh() const;
    std::vector<Vec3d> wall_places() const;
    std::vector<Vec3d> ghost_places() const;
    const PbdBody& body() const;
    /// All that goes on from here, as numbers: of a scene with the same wall and settings.
    std::vector<double> state() const;
    /// Goes on from there, to the same bits. Forces are those of the next step.
    /// @returns with nothing changed, InvalidArgument where it is no state of such a scene,
    ///          LimitExceeded where memory runs out
    Status restore(std::span<const double> state, const TaskArena& arena) noexcept;
    /// Of all places and velocities: equal for any number of threads.
    std::uint64_t hash() const noexcept;

  private:
    struct Impl;
    explicit CatheterScene(std::unique_ptr<Impl> impl);
    static Result<CatheterScene> make(VesselWall wall, const CatheterSettings& settings);
    static Status check_command(const CatheterCommand& command);
    Status put(std::span<const double> state);
    std::unique_ptr<Impl> m_impl;
};

/// Steers along a way: the tip is bent towards the point that is some way ahead of it.
class WayPilot {
  public:
    explicit WayPilot(std::vector<Vec3d> way_mm, double ahead_mm = 15, double gain = 1.5,
                      double most_deg = 120);
    /// @param command  whose bends are set
    void steer(const CatheterScene& scene, CatheterCommand& command);
    double way_mm() const { return m_length.empty() ? 0 : m_length.back(); }
    /// How far along the way the tip is.
    double progress_mm(Vec3d tip_mm) const;

  private:
    Vec3d at(double length_mm) const;
    std::vector<Vec3d> m_way;
    std::vector<double> m_length;
    double m_ahead, m_gain, m_most;
    double m_first = 0, m_second = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
