// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The interface of all tissue models: tools push and hold the tissue, it moves by itself, and its
// former states can be restored. The library's own are made by the functions of tissues.h. Write
// one of your own with own_tissue.h; it is then resampled, rendered, felt, undone, recorded,
// replayed and served like them, and check_tissue.h tests that it keeps the rules below.
//
// Rules of every tissue:
//
//   * It has no clock: its state depends on the calls alone, and has the same bits for any number
// of
//     threads.
//   * A call that returns an error has changed nothing.
//   * Calls come from one thread at a time.

#pragma once

#include <pliant/core/moving_scan.h>
#include <pliant/core/record.h>
#include <pliant/result.h>
#include <pliant/tool.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

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

/// Limits of a part of a sweep; the first one that is reached ends it.
struct SweepLimit {
    std::int64_t max_parts = std::numeric_limits<std::int64_t>::max();
    double max_ms = std::numeric_limits<double>::infinity();  ///< wall-clock time
    std::stop_token stop{};                                   ///< another thread may end it
};

struct Sweep {
    bool settled = true;    ///< more sweeps have no effect
    double ms = 0;          ///< wall-clock time of the sweep
    std::string message{};  ///< reason why the motion was stopped before it settled
    /// Longest motion of an element in the sweep; infinite: not known.
    double largest_step_mm = std::numeric_limits<double>::infinity();
    /// Parts that were made if the sweep is unfinished; none: it is finished. With as many as
    /// max_parts the same state gives the same result again.
    std::optional<std::int64_t> parts{};
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

    // Tools, by number. A tool that pushed holds its tissue: while the rest moves by itself, the
    // held part stays where the tool left it, until the tool pushes again or is released.

    /// Grabs the tissue at push.point_mm, where it is now, and moves it by push.push_mm, as far as
    /// it can go. The tool's earlier hold ends first: a second push of the same tool grabs anew, at
    /// its own point. Tissue that another tool holds may change hands.
    /// Radius 0 grabs the smallest part of the model around the point: the elements or nodes of the
    /// cell, tetrahedron or control cell that holds it. A sphere without tissue grabs the same, or
    /// nothing; elements that the tool meets on its way may be grabbed as well.
    /// @returns the executed part of the push. A PushReport begins as Rejected, with fraction 0, so
    ///          a tissue sets status and step_fraction of a push that it carries out.
    ///          InvalidArgument for numbers that aren't finite, and for points that the model
    ///          doesn't reach
    virtual Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept = 0;
    /// Begins a drag; there is at most one. By default the tool pushes by zero, and holds the
    /// touched tissue.
    /// @param position  the tool; its push_mm is ignored
    /// @param reach_mm  expected length of the drag, for models with a precomputation
    virtual Result<GrabReport> grab(std::uint32_t tool, const Push& position,
                                    double reach_mm) noexcept;
    /// Drags to an offset from the start of the drag. By default a push by the remaining
    /// difference. @returns InvalidArgument without a drag
    virtual Result<PushReport> drag_to(Vec3d offset_mm) noexcept;
    /// Ends the drag, if there is one; by default the tool is released.
    virtual void let_go() noexcept;
    /// Ends a tool's hold; nothing moves before the next sweep. No effect on a tool without one.
    virtual void release(std::uint32_t tool) noexcept = 0;
    virtual bool is_touched_by(std::uint32_t tool) const noexcept = 0;
    virtual bool is_touched() const noexcept = 0;  ///< by any tool
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

    /// Force on a tool [N], zero if it holds nothing; none if the model doesn't compute forces.
    virtual std::optional<Vec3d> force_n(std::uint32_t tool) noexcept;
    /// Elastic energy [mm² · weight] of a model without forces, for force estimates; none if it has
    /// no energy either, or memory runs out.
    virtual std::optional<double> energy_mm2() noexcept { return {}; }

    /// Advances the tissue's own motion by a sweep, however long that takes.
    /// @returns settled if it rests; LimitExceeded if memory runs out
    virtual Result<Sweep> sweep() noexcept = 0;
    /// Makes a part of a sweep, for a model whose sweeps take long; the next call goes on with the
    /// rest. By default it makes a whole sweep.
    virtual Result<Sweep> sweep_part(const SweepLimit& limit) noexcept;
    /// Advances it by many of its smallest steps: sweeps of ChainMail, time steps of the others. By
    /// default a step is a sweep(). max_ms is tested between steps, and never ends one early: the
    /// state is always that of some number of whole steps.
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

    // History, in steps: all calls from begin_group() to end_group() are one step. A group in which
    // nothing changed is none.

    virtual void begin_group(const std::string& name) = 0;
    /// @returns number of the oldest steps that were forgotten for this one; −1: all steps
    ///          including this one, since it is too large or memory runs out
    virtual int end_group() noexcept = 0;
    virtual int undo_steps() const noexcept = 0;
    /// Restores the state before the last step, bit for bit. @returns NotFound without a step
    virtual Status undo() noexcept = 0;
    /// Restores the state after the step that was undone last.
    virtual Status redo() noexcept = 0;

    /// Brings the state into the form that load_state() gives after save_state().
    /// @pre !is_touched()
    virtual Status rest() noexcept = 0;
    /// @param path  a std::filesystem::path fits too
    virtual Status save_state(const std::string& path) const noexcept = 0;
    /// Clears the history. @returns Unreadable for a file of another tissue, or a damaged one
    virtual Status load_state(const std::string& path) noexcept = 0;
    /// Hash of the state: the same for any number of threads. States of equal hash look the same,
    /// but may differ in the future: NodeTissue's leaves velocities out.
    virtual std::uint64_t hash() const = 0;

  private:
    struct Drag {
        std::uint32_t tool = 0;
        Push position;
        Vec3d done_mm{0, 0, 0};
    };
    std::optional<Drag> m_drag;  ///< of the default implementation
};

}  // namespace pliant
#pragma GCC visibility pop
