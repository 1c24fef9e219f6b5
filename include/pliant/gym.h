// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Many endoscopes in one scan, for training and for data sets. Each has a tissue of its own; all
// move in one call, in parallel.
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
// relaxation, a fixed number of sweeps for each step. There is no clock: the same actions from the
// same poses give the same bits for any number of threads. The eye is never in tissue.
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
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstddef>
#include <cstdint>
#include <memory>
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
    int relax_sweeps = 1;    ///< relaxation of the tissue after each step, 0…1000
    /// Of the walls, for the estimate of the force [Pa], above 0.
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
    /// Materials; its scale must be 1, and its history is replaced.
    ChainMailSettings materials{};
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
    /// Of the present picture: label of the tissue a voxel behind the wall, 0: none.
    std::span<const std::int16_t> labels{};
};

struct EndoscopeState {
    EndoscopePose pose{};      ///< look and up are perpendicular unit vectors
    bool is_touching = false;  ///< the tip's sphere reaches into the wall's shape at rest
    bool is_stopped = false;  ///< bone, a limit of the tissue or a rigid wall stopped the last step
    /// Force of the wall on the tip [N, LPS], an estimate: Hertz' law for a sphere that is pressed
    /// into the wall at rest as far as the tip was meant to go,
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
    ///          direction; then nothing has changed
    Status place(int endoscope, const EndoscopePose& pose) noexcept;

    /// Moves the endoscopes, and makes their pictures.
    /// @param actions  four numbers for each endoscope: mm/s, rad/s, rad/s, rad/s
    /// @param moves    one for each: 0 if it keeps position, tissue and picture; empty: all move
    /// @returns InvalidArgument for another count, or numbers that are not finite: nothing has
    ///          changed. LimitExceeded if memory runs out: the endoscopes have moved or not, each
    ///          as a whole
    Status step(std::span<const double> actions, std::span<const std::uint8_t> moves = {}) noexcept;
    /// Makes the pictures of endoscopes that were placed or loaded since their last one.
    Status look() noexcept;

    /// Pushes tissue with a tool of its own. The push shows at the next step.
    /// @returns InvalidArgument like ChainMail::push, or if tissue would come to the eye or the
    ///          walls are rigid; then nothing has changed
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
    /// @returns Unwritable; LimitExceeded
    Result<std::vector<std::byte>> save_state(int endoscope) const noexcept;
    /// @returns Unreadable for other bytes; InvalidArgument for the state of another scan. Then
    ///          nothing has changed
    Status load_state(int endoscope, std::span<const std::byte> state) noexcept;

  private:
    struct Impl;
    explicit EndoscopeArena(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
