// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter is fed into a vessel. The wall is position-based tissue. The wire is a rod or a body
// of tetrahedra, and contact is solved within its Newton steps. With `local`, only the boxes of the
// wall near the wire move.
//
// @code
//   auto wall = wall_around_centreline(centreline, {.thickness_mm = 1.5}, arena);
//   auto scene = CatheterScene::create(*wall, {.entry = entry_at(wall->ends[1])});
//   scene->command({.insert_mm_s = 50, .bend_first_deg = 20});
//   scene->step(1000, arena);                  // of a millisecond each
//   double force_n = scene->measures().force_n;
//   draw(scene->wire_positions(), scene->wall_positions());
// @endcode
//
// docs/method/vessel.md has the model, its limits, and `pliant vessel`.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A Cosserat rod.
struct CatheterShape {
    double length_mm = 600;
    double segment_mm = 3;
    double radius_mm = 0.9;
    double bend_n_mm2 = 20;   ///< EI
    double twist_n_mm2 = 20;  ///< GJ
    double tip_mm = 30;       ///< length of the softer end that steering bends
    double tip_bend_n_mm2 = 2;
    double mass_g_mm = 4e-3;
    double damping_per_s = 20;
    double friction = 0.05;  ///< Coulomb friction coefficient on the wall
    /// Compliance of the surfaces at a contact [mm/N]. 0: 10 mm³ divided by the larger EI, and at
    /// most 0.1, so that a stiff wire, whose forces are large, yields as little as a soft one.
    double contact_mm_per_n = 0;
};

enum class WallModel {
    Solid,      ///< neo-Hookean tetrahedra
    Distances,  ///< stretch, bend and volume constraints [VesselPbd2016]
    Rigid,      ///< doesn't move: the wire alone is computed
};

struct WallTissue {
    WallModel model = WallModel::Solid;
    double young_modulus_pa = 5e5;  ///< this and Poisson's ratio: of Solid
    double poisson_ratio = 0.45;
    /// Distances: share of its error that a projection removes from the length of an edge, from
    /// the angle between two faces of the surface, and from the volume of a tetrahedron
    /// [VesselPbd2016, Eq. 1]. 0: no such constraints. There is one projection in a sub-step, so
    /// smaller sub-steps make a stiffer wall.
    double stretch_stiffness = 0.1, bend_stiffness = 0.05, volume_stiffness = 1;
    Vec3d gravity_mm_s2{0, 0, 0};  ///< acceleration of the wall
    /// Includes blood and surrounding tissue that move along. Slow motion doesn't depend on it;
    /// forces are accurate if the sub-steps are small for it (docs/method/vessel.md).
    double density_g_mm3 = 0.02;
    double support_pa_per_mm = 10000;  ///< pressure of the surrounding tissue per displacement
    double damping_per_s = 100;
    /// Visits of each of the wall's constraints in a sub-step, and whether every second one goes
    /// through them in the opposite order, which needs an even number (PbdSettings). Both help
    /// where the volumes of hard walls are missed.
    int iterations = 1;
    bool alternates = false;
};

struct CatheterEntry {
    Vec3d position_mm{0, 0, 0};  ///< end of the guide
    Vec3d direction{0, 0, 1};    ///< into the vessel
    double inserted_mm = 5;      ///< length inserted at creation
};
/// Entry in the middle of an open end, a fraction of its radius inside the vessel.
CatheterEntry entry_at(const VesselEnd& end, double inwards = 0.5);

struct CatheterSettings {
    CatheterShape catheter{};
    WallTissue wall{};
    CatheterEntry entry{};
    bool local = true;   ///< only boxes near the catheter move
    double box_mm = 10;  ///< edge of a box
    /// Boxes within this distance of the catheter's surface move; -1: wide_reach_mm.
    double reach_mm = 2;
    double time_step_s = 1e-3;
    int sub_steps = 5;   ///< minimum; contact may need more (docs/method/vessel.md)
    int iterations = 4;  ///< Newton iterations of the wire in each sub-step
};

/// Rows of these settings, grouped by their tables in a scene file.
SettingRows<CatheterSettings> catheter_rows() noexcept;

/// Reach at which a local step differs from a step of the whole wall by at most 2 % of the
/// movement. It follows from the decay length of a displacement along a tube on its elastic
/// support. Returns 1000 without a support, and for WallModel::Distances, which has no modulus; 0
/// for a rigid wall.
double wide_reach_mm(const VesselWall& wall, const WallTissue& tissue);

/// Motion of the hand. It stays in force until the next command.
struct CatheterCommand {
    double insert_mm_s = 0;
    double rotate_deg_s = 0;
    double bend_first_deg = 0, bend_second_deg = 0;  ///< of the tip, about two perpendicular axes
    friend bool operator==(const CatheterCommand&, const CatheterCommand&) = default;
};

/// Holds the tip in a place, with its frame (CatheterScene::tip_frame), by springs of 10⁴ N/mm and
/// 10⁶ N mm/rad.
struct TipHold {
    Vec3d position_mm{0, 0, 0};  ///< [mm, LPS]
    Rotation frame{};
    bool slides = false;  ///< freely along the frame's third axis
};

/// What acts on the tip beside the wall, as in a test rig or in a snare.
struct TipRig {
    Vec3d force_n{0, 0, 0}, moment_n_mm{0, 0, 0};  ///< of constant direction [LPS]
    std::optional<TipHold> hold{};
};

struct CatheterMeasures {
    std::int64_t steps = 0;
    double time_s = 0;
    double inserted_mm = 0, rotated_deg = 0;
    double force_n = 0;            ///< along the guide, reaction on the hand
    double torque_n_mm = 0;        ///< about the guide's axis
    double contact_n = 0;          ///< sum of the contact forces' magnitudes on the wall
    double largest_contact_n = 0;  ///< the largest of them
    double contact_mm_per_n = 0;   ///< compliance of the contacts
    double wall_moved_mm = 0;      ///< largest distance of a particle from its rest position
    double depth_mm = 0;           ///< penetration of the ghost surface; negative: distance
    /// The wall's energy is that of its solids and its support: the paper's constraints have none.
    double wire_energy_mj = 0, wall_energy_mj = 0, kinetic_energy_mj = 0;
    VolumeChange volume{};
    std::int64_t inverted = 0;  ///< tetrahedra of the wall with a negative volume
    std::int32_t active_tetrahedra = 0;
    std::int32_t sub_steps = 0;  ///< of the last step; contact may need more than the setting
    /// Number that the wire's tip and waves in the wall need; more than 1000 aren't made.
    std::int32_t needed_sub_steps = 0;
    /// Number of the open end through which the tip has left the vessel, from 1 on; 0: none. Depth
    /// does not include points beyond an open end.
    std::int32_t left_end = 0;
};

/// Lists the faults of a state, one line each: penetration of the wall by more than 0.1 mm,
/// inverted tetrahedra, too few sub-steps, a tip that has left the vessel through an open end.
/// Empty if there is none.
std::vector<std::string> warnings_of(const CatheterMeasures& measures);

/// If memory runs out, functions that return a Result return LimitExceeded and change nothing.
/// Functions that return a vector or a mesh throw std::bad_alloc.
/// Thread safety: concurrent reads.
class CatheterScene {
  public:
    /// @returns InvalidArgument that names the setting, also if the entry lies outside of the
    ///          vessel
    static Result<CatheterScene> create(VesselWall wall, const CatheterSettings& settings) noexcept;
    ~CatheterScene();
    CatheterScene(CatheterScene&&) noexcept;
    CatheterScene& operator=(CatheterScene&&) noexcept;

    /// With the actual sub-steps, reach and compliance of contacts.
    const CatheterSettings& settings() const;
    const VesselWall& wall() const;  ///< rest state

    /// @returns InvalidArgument if a component isn't finite
    Status command(const CatheterCommand& command) noexcept;
    const CatheterCommand& hand() const;  ///< the last command
    /// Loads or holds the tip until the next call, or lets it go. No part of state(), as settings.
    /// @returns InvalidArgument if a component isn't finite
    Status rig_tip(const std::optional<TipRig>& rig) noexcept;
    /// Advances by `count` time steps. The wire stops at the end of its length and where it is
    /// fully withdrawn.
    /// @returns LimitExceeded if a position is no longer finite or memory runs out: earlier steps
    ///          of this call remain, the failed step changes nothing
    Status step(std::int32_t count, const TaskArena& arena) noexcept;

    /// Inserted length, force, torque, contact, depth, time and sub-steps. The other measures need
    /// a pass over the wall.
    CatheterMeasures quick_measures() const noexcept;
    CatheterMeasures measures() const noexcept;
    /// Number of inverted tetrahedra of the wall. Needs a pass over the wall.
    std::int64_t inverted_tetrahedra() const noexcept;
    std::span<const Vec3d> wire_positions() const;  ///< [mm, LPS], of all nodes, the tip last
    std::int32_t first_inserted() const;            ///< index of the last node inside the guide
    Vec3d tip_mm() const;
    /// Frame at the tip: the third axis points ahead, the tip bends about the first two.
    Rotation tip_frame() const;
    std::vector<Vec3d> wall_positions() const;
    std::vector<Vec3d> ghost_positions() const;
    const PbdBody& body() const;
    /// Returns the complete dynamic state as numbers, for a scene with the same wall and settings.
    std::vector<double> state() const;
    /// Continues from a state, bit for bit. Reported forces are those of the next step.
    /// @returns InvalidArgument if it is not a state of such a scene, LimitExceeded if memory runs
    ///          out; then nothing has changed
    Status restore(std::span<const double> state, const TaskArena& arena) noexcept;
    /// Hash of all positions and velocities, equal for any number of threads.
    std::uint64_t hash() const noexcept;

  private:
    struct Impl;
    explicit CatheterScene(std::unique_ptr<Impl> impl);
    static Result<CatheterScene> make(VesselWall wall, const CatheterSettings& settings);
    static Status check_command(const CatheterCommand& command);
    Status put(std::span<const double> state);
    std::unique_ptr<Impl> m_impl;
};

/// Steers along a path: bends the tip towards a point of the path at a fixed distance ahead.
/// Thread safety: concurrent reads.
class WayPilot {
  public:
    explicit WayPilot(std::vector<Vec3d> way_mm, double ahead_mm = 15, double gain = 1.5,
                      double max_deg = 120);
    /// @param command  receives the two bends
    void steer(const CatheterScene& scene, CatheterCommand& command);
    double way_mm() const { return m_length.empty() ? 0 : m_length.back(); }
    /// Arc length of the path's point nearest to the tip [mm].
    double progress_mm(Vec3d tip_mm) const;

  private:
    Vec3d at(double length_mm) const;
    std::vector<Vec3d> m_way;
    std::vector<double> m_length;
    double m_ahead, m_gain, m_most;
    double m_first = 0, m_second = 0;
};

// Moves the scan around a vessel with the vessel's wall. The displacement of a voxel near the wall
// is a weighted mean over the nearby wall nodes. It fades out with the distance and is zero beyond
// `reach_mm`. The deformation is a control lattice (resample.h), so the deformed volume, its
// fields and pictures come as with every tissue.
//
// @code
//   auto carried = CarriedScan::create(volume, wall.mesh, {}, arena);
//   carried->update(scene.wall_positions());
//   Result<Deformed> deformed = deform_volume(carried->scan());
// @endcode

struct CarriedScanSettings {
    double reach_mm = 20;  ///< distance from the wall's nodes
    double cell_mm = 3;    ///< edge of a cell of the control lattice, rounded to whole voxels, at
                           ///< least one
};

/// Thread safety: one thread.
class CarriedScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument if the wall lies outside of the scan or a setting is invalid
    static Result<CarriedScan> create(const Volume& volume, const TetMesh& wall,
                                      const CarriedScanSettings& settings,
                                      const TaskArena& arena) noexcept;
    ~CarriedScan();
    CarriedScan(CarriedScan&&) noexcept;
    CarriedScan& operator=(CarriedScan&&) noexcept;

    /// Moves the scan with the wall's nodes.
    /// @param wall_positions  current positions of all wall nodes [mm, LPS]
    /// @returns InvalidArgument if their number is wrong, LimitExceeded if memory runs out; then
    ///          nothing has changed
    Status update(std::span<const Vec3d> wall_positions) noexcept;
    const ControlLattice& scan() const;

  private:
    struct Impl;
    explicit CarriedScan(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// The scene file of `pliant vessel` and `pliant serve`; scene_files.h makes its scene.
// docs/howto/vessel.md lists its keys.
//
// If memory runs out, functions return LimitExceeded.

/// Largest value of `max_steps`, and largest number of steps of a log of the hand.
inline constexpr std::int64_t kMaxVesselSteps = 10'000'000;

/// Motion of the hand until the first of the given bounds.
struct VesselAct {
    CatheterCommand command{};
    bool follow = false;  ///< the tip is steered along the path
    std::optional<double> for_s, until_inserted_mm, until_way_mm;
};

struct VesselFile {
    std::string file;  ///< path of this file

    // Exactly one source: a phantom, a wall's tetrahedra, a surface, a centreline, a label volume,
    // a scan.
    std::string phantom, mesh, surface, centreline, labels_file, scan;
    std::string ghost;  ///< inner surface of the mesh; empty: found from its rims
    std::string ends;   ///< a centreline whose ends cut off a closed surface
    double trim = 0.5;
    std::vector<int> labels{1};
    double low_hu = 0, high_hu = 0, within_mm = 15, smoothing_voxels = 0.8;
    WallSettings wall{};

    std::string way_file;
    int way_branch = 1;
    bool way_reverse = false;
    std::vector<Vec3d> way_mm;  ///< points of the path; with a scan: start and end
    double ahead_mm = 15, gain = 1.5, max_deg = 120;

    int entry_end = 1;  ///< number of the open end
    double entry_inwards = 0.5;
    bool entry_given = false;  ///< the entry is given as a position and a direction
    CatheterSettings settings{};
    std::vector<VesselAct> acts;  ///< may be empty
    double max_steps = 1e6;       ///< limit of the script's steps
};

/// Rows of a scene file, without those of catheter_rows().
SettingRows<VesselFile> vessel_file_rows() noexcept;
/// Rows of a [[script]] table.
SettingRows<VesselAct> vessel_act_rows() noexcept;

/// Reads a scene file. Its relative paths refer to its folder.
/// @returns one line with the file and the key
Result<VesselFile> read_vessel_file(const std::string& file) noexcept;

/// Plays the acts of a scene file in order:
///
/// @code
///   while (script.next(scene, command)) {
///       scene.command(command);
///       scene.step(1, arena);
///   }
/// @endcode
/// Thread safety: concurrent reads.
class VesselScript {
  public:
    VesselScript(const VesselFile& file, const std::vector<Vec3d>& way);
    /// Sets the command of the next step. @returns false after the last act
    bool next(const CatheterScene& scene, CatheterCommand& command);
    /// Distance of the tip along the path [mm]; 0 without a path.
    double way_mm(const CatheterScene& scene) const;
    double progress() const;  ///< share of finished acts, 0…1

  private:
    bool is_over(const CatheterScene& scene, const CatheterMeasures& now) const;

    std::vector<VesselAct> m_acts;
    WayPilot m_pilot;
    bool m_has_way;
    std::size_t m_act = 0;
    CatheterMeasures m_began{};  ///< at the start of the act
    double m_began_way = 0;
};

/// Makes a synthetic scan of a vessel with contrast agent, for scenes without a scan: the lumen at
/// 300 HU, its wall at 90, tissue around it at 20 to 60 in a pattern that makes motion visible. The
/// voxels have an edge of 1 mm, or more if an axis would need over 256 of them. The key values
/// recommend a view.
/// @returns InvalidArgument if the wall's boundary isn't closed
Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
