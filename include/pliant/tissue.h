// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The interface of all tissue models: tools push and hold the tissue, it moves by itself, and its
// former states can be restored. The library's own are made by the functions of tissues.h.
// A tissue of your own implements it too, and is then resampled, rendered, felt, undone, recorded,
// replayed and served like them.
//
// The minimal tissue of your own (examples/own_tissue) derives from NodeTissue and has
//
//   volume(), deformation(), arena()   the scan, and the positions of its elements
//   push(), release(), sweep()         tools, and motion by itself
//   state(), set_state()               numbers for undo, files and checkpoints
//
// A tissue has no clock: its state depends on the calls alone, and is the same for any number of
// threads. A call that returns an error has changed nothing. Calls come from one thread at a time.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/deformation.h>
#include <pliant/record.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/springs.h>
#include <pliant/tool.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Capabilities of a model.
struct TissueTraits {
    std::string_view model = "own";  ///< its name in messages
    bool takes_pushes = true;
    bool slides = false;
    bool cuts = false;
    bool carves = false;
    bool has_energy = false;       ///< energy_mm2() allows force estimates
    bool moves_by_itself = false;  ///< without a push: its sweeps are steps of time
    double sweep_ms = 0;           ///< simulated time of a sweep; 0: the model has no time
    double update_hz = 0;          ///< rate of its internal updates, in real time
    /// Whether tissue that returns to rest may close over an eye that is not registered as an
    /// obstacle.
    bool closes_at_rest = false;
    /// Whether imprints remain, so that its shape at rest is not the scan's.
    bool keeps_imprints = false;
};

struct Sweep {
    bool settled = true;    ///< more sweeps have no effect
    double ms = 0;          ///< wall-clock time of the sweep
    std::string message{};  ///< reason why the motion was stopped before it settled
};

/// Limits of a call of advance(); the first one that is reached ends it.
struct Budget {
    std::int64_t max_steps = std::numeric_limits<std::int64_t>::max();
    double max_ms = std::numeric_limits<double>::infinity();  ///< wall-clock time
};

struct AdvanceReport {
    std::int64_t steps = 0;
    bool settled = false;   ///< more steps have no effect
    double ms = 0;          ///< wall-clock time
    std::string message{};  ///< reason why a motion was stopped before it settled
};

class Drivable;

/// Thread safety: one thread.
class Tissue : public MovingScan {
  public:
    virtual TissueTraits traits() const noexcept = 0;
    /// The catheter that is driven in it (drivable.h); null by default.
    virtual Drivable* drivable() noexcept { return nullptr; }
    const Drivable* drivable() const noexcept { return const_cast<Tissue*>(this)->drivable(); }

    // Tools, by number. A tool holds its tissue until it lets go.

    virtual Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept = 0;
    /// Begins a drag; there is at most one. By default the tool pushes by zero, and holds the
    /// touched tissue.
    /// @param reach_mm  expected length of the drag, for models with a precomputation
    virtual Result<GrabReport> grab(std::uint32_t tool, const Push& place,
                                    double reach_mm) noexcept;
    /// Drags to an offset from the start of the drag. By default a push by the remaining
    /// difference.
    /// @pre a drag is under way
    virtual Result<PushReport> drag_to(Vec3d offset_mm) noexcept;
    /// Ends the drag, if there is one.
    virtual void let_go() noexcept;
    virtual void release(std::uint32_t tool) noexcept = 0;
    virtual bool is_touched_by(std::uint32_t tool) const noexcept = 0;
    virtual bool is_touched() const noexcept = 0;
    /// Moves a sphere along which tissue slides. @returns Unsupported by default
    virtual Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                                      const TissueValues& tissue_values) noexcept;
    /// @returns Unsupported by default
    virtual Result<CutReport> cut(const CutSurface& surface) noexcept;
    /// @returns Unsupported by default
    virtual Result<CarveReport> carve(const CarveTool& tool) noexcept;
    /// Registers an observing eye as an obstacle: tissue does not close over it.
    /// @param radius_mm  0 removes the eye
    virtual Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept;
    virtual bool has_eye(std::uint32_t tool) const noexcept;

    /// Force on a tool [N]; none if the model doesn't compute forces.
    virtual std::optional<Vec3d> force_n(std::uint32_t tool) noexcept;
    /// Elastic energy [mm² · weight] of a model without forces, for force estimates; none if it has
    /// no energy either, or memory runs out.
    virtual std::optional<double> energy_mm2() noexcept { return {}; }

    /// Advances the tissue's own motion by its smallest recorded part.
    /// @returns LimitExceeded if memory runs out
    virtual Result<Sweep> sweep() noexcept = 0;
    /// Advances it by many of its smallest steps: sweeps of ChainMail, time steps of the others. By
    /// default a step is a sweep().
    /// @returns LimitExceeded if memory runs out; earlier steps are complete
    virtual Result<AdvanceReport> advance(const Budget& budget) noexcept;
    /// Returns all tissue to rest.
    virtual Status reset() noexcept = 0;

    /// Settings that can be changed during use, by name; none by default.
    virtual Record settings() const { return {}; }
    /// Changes some of them, all or none. @returns Unsupported by default
    virtual Status configure(const Record& changes) noexcept;
    /// Sets the depth of forces to the smallest one at which one more layer moves nothing by
    /// more than the threshold, for the present tools.
    /// @returns the depth; Unsupported by default, NotFound up to max_depth or without a tool
    virtual Result<std::int32_t> take_depth(double threshold_mm, std::int32_t max_depth) noexcept;
    /// Figures for display, by name, such as counts of nodes.
    virtual Record figures() const { return {}; }
    /// Figures for a report, which may take a while to compute. A name with a dot is a part of an
    /// object: "certificate.all". "summary" is a line for a reader.
    virtual Record report() const { return {}; }

    // History, in steps: all calls from begin_group() to end_group() are one step.

    virtual void begin_group(const std::string& name) = 0;
    /// @returns number of the oldest steps that were forgotten for this one; −1: all steps
    ///          including this one, since it is too large or memory runs out
    virtual int end_group() noexcept = 0;
    virtual int undo_steps() const noexcept = 0;
    virtual Status undo() noexcept = 0;
    virtual Status redo() noexcept = 0;

    /// Brings the state into the form that load_state() gives after save_state().
    /// @pre !is_touched()
    virtual Status rest() noexcept = 0;
    virtual Status save_state(const std::filesystem::path& path) const noexcept = 0;
    /// Clears the history. @returns Unreadable for a file of another tissue, or a damaged one
    virtual Status load_state(const std::filesystem::path& path) noexcept = 0;
    /// Hash of the state: the same for any number of threads.
    virtual std::uint64_t hash() const = 0;

  private:
    struct Drag {
        std::uint32_t tool = 0;
        Push place;
        Vec3d done_mm{0, 0, 0};
    };
    std::optional<Drag> m_drag;  ///< of the default implementation
};

/// A tissue whose whole state is a list of numbers of moderate length, such as the positions of its
/// nodes. History and files are implemented with it.
/// Thread safety: one thread.
class NodeTissue : public Tissue {
  public:
    /// Writes the state: all data that determine future results.
    /// @param[out] numbers  resized if needed, else no memory is allocated
    virtual void state(std::vector<double>& numbers) const = 0;
    /// Restores a state, with all tools released.
    /// @returns InvalidArgument if it can't be a state of this tissue
    virtual Status set_state(std::span<const double> numbers) noexcept = 0;
    /// Kind of its files: a different number for each model.
    virtual std::uint64_t file_kind() const noexcept { return 0x30'6e'77'6f'70'00'00'0a; }

    void begin_group(const std::string& name) override;
    int end_group() noexcept override;
    int undo_steps() const noexcept override { return int(m_done.size()); }
    Status undo() noexcept override;
    Status redo() noexcept override;
    Status rest() noexcept override;
    Status save_state(const std::filesystem::path& path) const noexcept override;
    Status load_state(const std::filesystem::path& path) noexcept override;
    /// Hash of the deformation by default.
    std::uint64_t hash() const override;

  private:
    using State = std::vector<double>;
    Status go_back(std::list<State>& from, std::list<State>& to) noexcept;

    std::list<State> m_before;          ///< one state, during a group
    std::list<State> m_done, m_undone;  ///< states before, or after; the next one is last
    State m_now;                        ///< memory for the end of a group
};

/// Makes the tissue of a scan; both must outlive it.
using MakeTissue =
    std::function<Result<std::unique_ptr<Tissue>>(const Volume& scan, const TaskArena& arena)>;

// A scan deformed by springs: a network of control nodes over a region of the scan [Choi2004,
// 4.2.2] moves by force transmittal, and the voxels are embedded in its cells.
//
// @code
//   auto tissue = SpringDeformation::create(volume, {.cell_mm = 8}, arena);
//   auto push = (*tissue)->push(1, {.point_mm = point, .push_mm = {5, 0, 0}});  // tool 1 grabs
//   while (!(*tissue)->step(20)->settled) continue;
//   Result<Deformed> deformed = deform_volume(**tissue);
// @endcode
//
// A tool holds its nodes until it lets go. Time advances only in steps, so the result depends on
// the calls alone. It is bit-identical for any number of threads.

struct SpringDeformationSettings {
    Box3i region{};                  ///< voxels that may move; empty: the whole scan
    double cell_mm = 8;              ///< edge of a control cell, rounded to whole voxels
    double young_modulus_pa = 15e3;  ///< of tissue; air has 1 % of it
    double poisson_ratio = 0.25;  ///< of tissue; above 1/4 control cells resist changes of volume
    double air_threshold_hu = -500;  ///< smaller values are air
    double fixed_hu = 300;           ///< nodes with a larger mean value around them are fixed
    double fixed_share = 0.05;       ///< cells with a larger share of such voxels have fixed nodes
    std::int32_t depth = 10;         ///< layers of nodes that forces reach around a tool
    /// Time in which free motion decays to 1/e [s].
    double damping_s = 0.005;
    /// Tissues by label: `elastic` and law Immobile have an effect, and bone_threshold_hu as
    /// fixed_hu. Voxels of law Constant aren't fixed by their value.
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};  ///< on the scan's grid; required by label_materials

    friend bool operator==(const SpringDeformationSettings&,
                           const SpringDeformationSettings&) = default;
};
/// Rows of these settings, except the region and labels.
SettingRows<SpringDeformationSettings> spring_rows() noexcept;

struct SpringMotion {
    std::int64_t steps = 0;
    std::int32_t active_nodes = 0;  ///< nodes that could move
    double fastest_mm_s = 0;
    bool settled = false;  ///< at rest: more steps make no visible change
    double solve_ms = 0;
    std::string message;  ///< reason why an unstable motion was stopped
};

/// If memory runs out, calls return LimitExceeded and change nothing.
/// Thread safety: one thread.
class SpringDeformation : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the setting; LimitExceeded above a million nodes
    static Result<std::unique_ptr<SpringDeformation>> create(
        const Volume& volume, const SpringDeformationSettings& settings,
        const TaskArena& arena) noexcept;
    ~SpringDeformation() override;

    /// Lets a tool grab the free nodes of the cell that holds the point, or the free nodes in the
    /// sphere, and moves them; previously held nodes are released. Time advances during the push.
    /// It stops before a control cell folds. grabbed_elements and moved_elements count nodes.
    /// @returns InvalidArgument, with nothing changed, if the point is outside of the control
    ///          lattice, or the push isn't finite or too long
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept;
    void let_go(std::uint32_t tool) noexcept;
    bool is_held() const;
    bool holds(std::uint32_t tool) const;

    /// Makes steps of time_step_s(), fewer if it comes to rest. Without a tool pushed tissue
    /// returns, and finally has its original positions, bit for bit. The elements follow when
    /// update_deformation(), lattice() or control() is called.
    Result<SpringMotion> step(int count) noexcept;
    double time_step_s() const;
    bool is_settled() const;

    /// Cuts the tissue along a ribbon: links and volumes that it crosses no longer pull, and the
    /// elements follow the nodes on their side. Tools keep their nodes.
    /// @returns InvalidArgument for a surface without area, or far away
    Result<CutReport> cut(const CutSurface& surface) noexcept;
    /// All cuts, at rest.
    std::span<const CutTriangle> cuts_mm() const;

    /// Finds the smallest depth at which one more layer moves no node by more than the threshold,
    /// at the equilibrium with the present tools [Choi2004, 3.1.3]. Nothing changes.
    /// @returns depth 0 if it is above max_depth; NotFound if no tool holds a node
    Result<DepthFound> find_depth(double threshold_mm, std::int32_t max_depth) const noexcept;

    const SpringDeformationSettings& settings() const;
    /// @returns InvalidArgument for a negative depth
    Status set_depth(std::int32_t depth) noexcept;
    void reset() noexcept;

    /// Force on the tool [N], with the other nodes held; 0 if it holds none.
    Vec3d force_n(std::uint32_t tool);

    /// Displacement of every control node [mm, LPS].
    const std::vector<Vec3d>& displacements_mm() const;
    /// Position of every control node [mm, LPS].
    std::vector<Vec3d> positions_mm() const;
    /// Copies the positions. @param[out] positions_mm  one for each node
    void positions_mm(std::span<Vec3d> positions_mm) const noexcept;
    /// Sets the positions of all nodes, at zero speed. Tools let go; displaced nodes can move.
    /// @returns InvalidArgument, with nothing changed, like ControlLattice::place
    Status set_positions(std::span<const Vec3d> positions_mm) noexcept;
    /// Likewise, with other cuts than the present ones.
    Status set_shape(std::span<const Vec3d> positions_mm,
                     std::span<const CutTriangle> cuts_mm) noexcept;
    const ControlLattice& control() const;
    std::int32_t fixed_nodes() const;
    /// Hash of all positions.
    std::uint64_t hash() const;

    const Volume& volume() const override;
    const Deformation& deformation() const override;
    const TaskArena& arena() const override;
    Status update_deformation() const noexcept override;

  private:
    struct Impl;
    explicit SpringDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// Virtual endoscopy in one call per frame [Draeger2005, 4.4]: the eye moves, tissue makes way, the
// volume follows.
//
// @code
//   auto endoscopy = EyeDeformation::create(scan, {}, arena);
//   while (running) {
//       auto moved = (*endoscopy)->deform(eye, wanted_eye());
//       if (!moved) break;      // moved.error(): one line; nothing has changed
//       eye = moved->eye_mm;    // never in tissue
//       for (const Box3i& box : moved->boxes) show((*endoscopy)->volume(), box);
//   }
// @endcode

struct EyeSettings {
    double radius_mm = 2;   ///< sphere around the eye that stays free, above 0
    TissueValues values{};  ///< values of the scan that are tissue
    ChainMailSettings materials{};
};

struct EyeMove {
    Vec3d eye_mm{0, 0, 0};  ///< valid position of the eye, LPS; the wanted one if it could go there
    bool touched = false;   ///< whether tissue moved
    bool is_stopped = false;  ///< whether bone, a movement limit or a closed lumen stopped it
    std::span<const Box3i> boxes{};  ///< voxels that may have changed; valid until the next call
    double solve_ms = 0, resample_ms = 0;
};

/// Thread safety: one thread.
class EyeDeformation {
  public:
    /// Keeps references: scan and arena must outlive it.
    /// @returns InvalidArgument that names the setting
    static Result<std::unique_ptr<EyeDeformation>> create(const Volume& scan,
                                                          const EyeSettings& settings,
                                                          const TaskArena& arena) noexcept;
    ~EyeDeformation();
    EyeDeformation(const EyeDeformation&) = delete;
    EyeDeformation& operator=(const EyeDeformation&) = delete;

    /// Moves the eye in a straight line, finds the wall between the two positions, pushes it away,
    /// and brings the volume up to date. Throws nothing.
    /// @param last_eye_mm  position that the last call returned, or one in the lumen, LPS
    /// @returns InvalidArgument for a path that is not finite, longer than 500 mm or outside of the
    ///          scan; LimitExceeded if memory runs out. Then the tissue has not changed
    Result<EyeMove> deform(Vec3d last_eye_mm, Vec3d eye_mm) noexcept;

    /// The deformed scan.
    const Volume& volume() const;
    /// The tissue, for history, relaxation, cuts; deform() shows their effect with its next call.
    ChainMail& tissue();

  private:
    struct Impl;
    explicit EyeDeformation(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
