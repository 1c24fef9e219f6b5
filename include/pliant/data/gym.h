// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Many endoscopes in one scan, and many catheters in one vessel (below), for training and for data
// sets. Each has a tissue of its own; all move in one call, in parallel.
//
//   scan ──┬── endoscope 0: tip, tissue, deformed scan (only touched pages are copied), picture
//          ├── endoscope 1
//          └── …
//
//   action  4 numbers: advance [mm/s], roll, pitch, yaw [rad/s], for 1 / control_hz seconds
//   roll    about the optical axis, clockwise in the operator's view: the picture's top turns to
//           the right
//   pitch   up in the picture      yaw   to the right in the picture
//
// The tip turns, then advances along its new optical axis (backwards for a negative speed). A wall
// in its way makes way, or stops it if it is rigid. Tissue that the tip has left returns by
// sweeps, a fixed number of them after a fixed number of steps. There is no clock: the same
// actions from the same poses give the same bits for any number of threads. The eye is never in
// tissue. Walls are ChainMail, or the elastic scan, which gives the force on the tip in newtons.
//
// Flow is exact for the material of the walls. The wall's point p that a pixel of one picture shows
// is tissue that rested at X = φ⁻¹(p). At the next picture it is at q = φ'(X), and its pixel is the
// projection of q:
//
//   X = φ⁻¹(p)    q = φ'(X)    scene flow = q − p    flow = projection(q) − pixel
//
// φ is the trilinear map between the elements, the same that the deformed scan is made with.
//
// @code
//   auto endoscopes = EndoscopeArena::create(scan, {.count = 16}, arena);
//   auto placed = (*endoscopes)->place(0, {.eye_mm = eye, .look = {0, 0, -1}});  // and the others
//   while (running) {
//       auto done = (*endoscopes)->step(wanted_actions());
//       if (!done) break;  // done.error()
//       show((*endoscopes)->picture(0, 256, 256));
//   }
// @endcode

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/tasks.h>
#include <pliant/models/catheter.h>
#include <pliant/models/scan_tissue.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct EndoscopePose {
    Vec3d eye_mm{0, 0, 0};  ///< middle of the tip's sphere, LPS
    Vec3d look{0, 0, -1};   ///< optical axis, LPS, any length > 0
    Vec3d up{0, -1, 0};     ///< top of the picture; zero or parallel to look: chosen
};

struct EndoscopeArenaSettings {
    int count = 1;           ///< endoscopes, 1…4096
    int width = 64;          ///< of a picture [pixels], 1…8192
    int height = 64;         ///< likewise
    double control_hz = 20;  ///< steps per second of the endoscope's motion, above 0
    bool deforms = true;     ///< false: walls are rigid, and stop the tip or let it slide along
    double radius_mm = 1.4;  ///< of the tip, above 0
    int relax_sweeps = 1;    ///< sweeps of the tissue after a step, 0…1000
    int relax_every = 1;     ///< steps from one sweep, or several, to the next, 1…1000
    /// Young's modulus of ChainMail's walls, for the estimate of the force [Pa], above 0.
    double young_modulus_pa = 15e3;
    double iso_hu = -500;  ///< threshold of the wall
    Polarity polarity = Polarity::Rising;
    double field_of_view_deg = 80;    ///< across the picture's height, before distortion, 1…170
    double barrel_distortion = 0.15;  ///< 0…2
    Style style = Style::Real;
    Lining lining = Lining::Airway;
    FieldStop field_stop = FieldStop::Full;
    bool is_smooth = false;  ///< colour by four rays for each pixel at an edge
    // Pictures to make.
    bool has_colour = true;
    bool has_depth = true;
    bool has_normals = false;
    bool has_flow = false;  ///< also scene flow, visibility, and labels if there are any
    /// Labels of the tissue on the scan's grid, at rest; null: none.
    std::shared_ptr<const Volume> labels{};
    /// The tissue. The scale of ChainMail must be 1, and its history is replaced.
    ScanTissueSettings materials{};
};

/// Where the tissue that a pixel showed is in the next picture.
enum class FlowVisibility : std::uint8_t {
    None,     ///< the pixel showed no wall, or tissue that has been torn: no flow
    Seen,     ///< in the picture
    Hidden,   ///< behind other tissue
    Outside,  ///< outside of the picture; flow is (0, 0) if it has no projection
};

/// Pictures of all endoscopes, one after the other, rows from the top; empty if not made. See
/// EndoscopeFrame for colour, depth and normals. Those of flow belong to the pixels of each
/// endoscope's picture *before* the last step, and lead from there to the present one; they are 0
/// after place().
struct EndoscopePictures {
    std::span<const Rgb8> colour{};
    std::span<const float> depth_mm{};
    std::span<const Vec3f> normals{};
    std::span<const float> flow{};  ///< two for each pixel: to the right, down [pixels]
    std::span<const FlowVisibility> visibility{};
    std::span<const Vec3f> scene_flow_mm{};  ///< LPS
    /// Label of the tissue a voxel behind the wall in the present picture, 0: none.
    std::span<const std::int16_t> labels{};
};

struct EndoscopeState {
    EndoscopePose pose{};  ///< look and up are perpendicular unit vectors
    /// The tip's sphere reaches into the wall's shape at rest; the elastic scan presses on it.
    bool is_touching = false;
    bool is_stopped = false;  ///< bone, a limit of the tissue or a rigid wall stopped the last step
    /// Force of the wall on the tip [N, LPS]. That of the elastic scan is its solution's. Otherwise
    /// an estimate: Hertz' law for a sphere that is pressed into the wall at rest as far as the tip
    /// was meant to go,
    ///   F = 4/3 · E / (1 − ν²) · √R · d^(3/2),   ν = 0.45.
    Vec3d force_n{0, 0, 0};
    double max_displacement_mm = 0;  ///< of all tissue
    std::int64_t steps = 0;          ///< since place()
};

/// Thread safety: one thread.
class EndoscopeArena {
  public:
    /// Keeps references: scan and threads must outlive it. All endoscopes begin at a pose of
    /// find_endoscope, if there is one.
    /// @returns InvalidArgument that names the setting; LimitExceeded if memory runs out
    static Result<std::unique_ptr<EndoscopeArena>> create(const Volume& scan,
                                                          const EndoscopeArenaSettings& settings,
                                                          const TaskArena& threads) noexcept;
    ~EndoscopeArena();
    EndoscopeArena(const EndoscopeArena&) = delete;
    EndoscopeArena& operator=(const EndoscopeArena&) = delete;

    /// Places an endoscope, and returns its tissue to rest. Its pictures are brought up to date by
    /// the next call of look() or step().
    /// @returns InvalidArgument if the eye is not in a lumen of the scan, or a vector is no
    ///          direction; then nothing has changed. LimitExceeded if memory runs out: it is placed
    ///          or not, tip and tissue alike
    Status place(int endoscope, const EndoscopePose& pose) noexcept;

    /// Moves the endoscopes, and makes their pictures.
    /// @param actions  four numbers for each endoscope: mm/s, rad/s, rad/s, rad/s
    /// @param moves    one for each: 0 if it keeps position, tissue and picture; empty: all move
    /// @returns InvalidArgument for another count, or numbers that are not finite: nothing has
    ///          changed. LimitExceeded if memory runs out: tissue has moved or not, and tips are
    ///          where they were or where they should be
    Status step(std::span<const double> actions, std::span<const std::uint8_t> moves = {}) noexcept;
    /// Makes the pictures of endoscopes that were placed or loaded since their last one, or lack
    /// them after a failure. @returns LimitExceeded; the flow of the next picture is then 0
    Status look() noexcept;

    /// Pushes tissue with a tool of its own. The push shows at the next step.
    /// @returns InvalidArgument like ChainMail::push, or if tissue would come to the eye or the
    ///          walls are rigid; then nothing has changed. LimitExceeded if memory runs out: tissue
    ///          has moved or not
    Result<PushReport> push(int endoscope, const Push& push) noexcept;

    /// Pictures of the last call of step() or look(); valid until the next.
    EndoscopePictures pictures() const;
    /// A picture of another size, smooth, for people.
    Image picture(int endoscope, int width, int height) const;
    const EndoscopeState& state(int endoscope) const;
    int count() const;
    const EndoscopeArenaSettings& settings() const;
    /// Camera of an endoscope.
    Endoscope camera(int endoscope) const;
    const Volume& scan() const;                 ///< at rest
    const Volume& volume(int endoscope) const;  ///< the deformed scan
    /// Displacements of its tissue; null if walls are rigid.
    const Deformation* deformation(int endoscope) const;
    /// Hash of an endoscope's pose and tissue.
    std::uint64_t hash(int endoscope) const;

    /// Pose and tissue of an endoscope, by way of a temporary file. The flow of the next step is 0.
    /// The elastic scan finds the tip's contacts anew.
    /// @returns Unwritable; LimitExceeded
    Result<std::vector<std::byte>> save_state(int endoscope) const noexcept;
    /// @returns Unreadable for other bytes; InvalidArgument for the state of another scan. Then
    ///          nothing has changed. LimitExceeded if memory runs out: it is loaded or not, tip and
    ///          tissue alike
    Status load_state(int endoscope, std::span<const std::byte> state) noexcept;

  private:
    struct Impl;
    explicit EndoscopeArena(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// Many catheters, each in a vessel of its own with the same wall at rest; all move in one call.
//
//   action  3 numbers: insertion [mm/s], rotation [rad/s], bending of the tip [rad/s], for
//           1 / control_hz seconds
//
// The picture is a fluoroscopy: the shadow of a scan at rest, a roadmap of the vessel, and the
// shadow of the catheter beyond the guide. A pixel has the mean of the chords through a straight
// cylinder over the pixel's square,
//
//   (B(d + a₊) − B(d + a₋) − B(d − a₋) + B(d − a₊)) / 4 a b,   B″(t) = 2 √(r² − t²),
//   a₊ = a + b,  a₋ = a − b,   a, b = s/2 · |n|
//
// with r the catheter's radius, d the distance of the pixel's middle from the axis, s the pixel's
// width, and n the unit vector across the catheter. So a catheter thinner than a pixel is as dark
// as it should be. Where a catheter crosses itself, it counts once.
//
// @code
//   auto catheters = CatheterArena::create(wall, scan, {.count = 16}, arena);
//   auto placed = (*catheters)->place(0, 0.5);  // and the others
//   while (running) {
//       auto done = (*catheters)->step(wanted_actions());
//       if (!done) break;  // done.error()
//       show((*catheters)->pictures());
//   }
// @endcode

struct CatheterArenaSettings {
    int count = 1;             ///< catheters, 1…4096
    int width = 64;            ///< of a picture [pixels], 1…8192
    int height = 64;           ///< likewise
    double control_hz = 7.5;   ///< steps per second of the catheter's motion, above 0
    bool has_pictures = true;  ///< false: no fluoroscopy
    Fluoroscopy view{};
    double device_water = 20;  ///< absorption of the catheter, in that of water, 0…1000
    int points = 8;            ///< tracked points from the tip on, 1…1024
    double points_mm = 5;      ///< distance of the tracked points along the catheter, above 0
    double bend_rad = 0;       ///< bend of the tip about its first axis at first
    double max_bend_rad = 2;   ///< limit of the bend, 0…2π
    /// Catheter, wall and guide. The largest time step of at most time_step_s of which a whole
    /// number makes a step of control is used.
    CatheterSettings catheter{};
};

struct CatheterArenaState {
    Vec3d tip_mm{0, 0, 0};    ///< LPS
    Vec3d ahead{0, 0, 1};     ///< direction of the tip, LPS
    Vec3d bends_to{1, 0, 0};  ///< direction to which the tip bends, LPS
    double inserted_mm = 0;
    double rotated_rad = 0;          ///< of the hand, since place(), with its rotation
    double bend_rad = 0;             ///< wanted bend of the tip
    double push_n = 0;               ///< reaction on the hand along the guide
    double wall_force_n = 0;         ///< sum of the contact forces' magnitudes on the wall
    double depth_mm = 0;             ///< penetration of the wall's surface; negative: distance
    double max_displacement_mm = 0;  ///< of the wall's nodes
    int left_end = 0;        ///< number of the open end through which the tip has left; 0: none
    std::int64_t steps = 0;  ///< since place()
};

/// Thread safety: one thread.
class CatheterArena {
  public:
    /// Keeps references: scan and threads must outlive it.
    /// @param scan  seen in the pictures
    /// @returns InvalidArgument that names the setting; LimitExceeded if memory runs out
    static Result<std::unique_ptr<CatheterArena>> create(const VesselWall& wall, const Volume& scan,
                                                         const CatheterArenaSettings& settings,
                                                         const TaskArena& threads) noexcept;
    ~CatheterArena();
    CatheterArena(const CatheterArena&) = delete;
    CatheterArena& operator=(const CatheterArena&) = delete;

    /// Withdraws a catheter to the guide, and returns its wall to rest; then rotates it, which
    /// takes 0.2 s of simulated time. Its picture is brought up to date by the next call of look()
    /// or step().
    /// @returns as step()
    Status place(int catheter, double rotated_rad) noexcept;

    /// Moves the catheters, and makes their pictures. A tip that has left the vessel is not
    /// pushed any further.
    /// @param actions  three numbers for each catheter: mm/s, rad/s, rad/s
    /// @param moves    one for each: 0 if it keeps its state; empty: all move
    /// @returns InvalidArgument for another count, numbers that are not finite, or over 1000 mm/s;
    ///          LimitExceeded if a position is no longer finite or memory runs out. Then nothing
    ///          has changed
    Status step(std::span<const double> actions, std::span<const std::uint8_t> moves = {}) noexcept;
    /// Makes the pictures of catheters that were placed or loaded since their last one.
    Status look() noexcept;

    /// Fluoroscopies of the last call of step() or look(), one after the other, rows from the top.
    std::span<const std::uint8_t> pictures() const;
    /// Tracked points of all catheters, projected to the plane through the middle of the picture:
    /// mm to the right and up from it, the tip first, the guide's end repeated. Three nested axes:
    /// catheter, point, 2.
    std::span<const float> points() const;
    /// Projects a point [mm, LPS] to the plane through the middle of the picture: mm to the right
    /// and up from it. Both are infinite for points that are not in front of the source.
    std::array<double, 2> project(Vec3d point_mm) const;
    /// A fluoroscopy of another size. @returns LimitExceeded if memory runs out
    Result<Image> picture(int catheter, int width, int height) const noexcept;
    const CatheterArenaState& state(int catheter) const;
    const CatheterScene& scene(int catheter) const;
    int count() const;
    const CatheterArenaSettings& settings() const;  ///< with the actual time step
    /// Hash of positions and velocities, equal for any number of threads.
    std::uint64_t hash(int catheter) const;

    /// The complete state of a catheter and its wall, as numbers.
    Result<std::vector<double>> save_state(int catheter) const noexcept;
    /// @returns InvalidArgument for the state of another arena; then nothing has changed
    Status load_state(int catheter, std::span<const double> state) noexcept;

  private:
    struct Impl;
    explicit CatheterArena(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
