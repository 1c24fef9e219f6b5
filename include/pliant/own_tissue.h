// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bases of a tissue of your own (docs/howto/own_tissue.md is a walk through examples/own_tissue):
//
//   OwnTissue     its functions may throw, and an error restores the state
//   NodeTissue    its functions are noexcept, and restore the state themselves, where attempt()
//                 (result.h) catches in them. The library's models derive from it
//
// Both have undo, redo, files and checkpoints from state() and set_state(). A minimal tissue has
//
//   volume(), arena()                  references to the arguments that it was made with
//   deformation()                      positions of the scan's elements
//   update_deformation()               writes them, when they are asked for
//   traits()                           its name and capabilities
//   do_push(), do_sweep(), do_reset()  tools, and motion by itself
//   release(), is_touched…()           the tools' hold
//   state(), do_set_state()            numbers for undo, files and checkpoints
//
// check_tissue() (check_tissue.h) tests that it keeps the rules of tissue.h.

#pragma once

#include <pliant/deformation.h>
#include <pliant/tissue.h>

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A tissue whose whole state is a list of numbers of moderate length, such as the positions of its
/// nodes. History and files are implemented with it.
/// Thread safety: one thread.
class NodeTissue : public Tissue {
  public:
    /// Writes the state: all data that determine future results. May throw std::bad_alloc.
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
    Status save_state(const std::string& path) const noexcept override;
    Status load_state(const std::string& path) noexcept override;
    /// Hash of the deformation, after update_deformation(). It leaves out quantities that
    /// positions don't show, such as velocities: states of equal hash may differ in the future.
    std::uint64_t hash() const override;

  private:
    using State = std::vector<double>;
    Status go_back(std::list<State>& from, std::list<State>& to) noexcept;

    std::list<State> m_before;          ///< one state, during a group
    std::list<State> m_done, m_undone;  ///< states before, or after; the next one is last
    State m_now;                        ///< memory for the end of a group
};

/// A tissue whose functions may throw. The functions of Tissue call those named do_…; an exception
/// becomes an Error: LimitExceeded for std::bad_alloc, else InvalidArgument with its text. After
/// any error that left another state, the state before the call is restored by do_set_state(),
/// which also releases the tools. For this the state is copied before each call that may change it.
/// Thread safety: one thread.
class OwnTissue : public NodeTissue {
  public:
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept final;
    Result<GrabReport> grab(std::uint32_t tool, const Push& position,
                            double reach_mm) noexcept final;
    Result<PushReport> drag_to(Vec3d offset_mm) noexcept final;
    Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                              const TissueValues& tissue_values) noexcept final;
    Result<CutReport> cut(const CutSurface& surface) noexcept final;
    Result<CarveReport> carve(const CarveTool& tool) noexcept final;
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept final;
    Result<Sweep> sweep() noexcept final;
    Status reset() noexcept final;
    Status configure(const Record& changes) noexcept final;
    Status set_state(std::span<const double> numbers) noexcept final;

  protected:
    virtual Result<PushReport> do_push(std::uint32_t tool, const Push& push) = 0;
    virtual Result<Sweep> do_sweep() { return Sweep{}; }
    virtual Status do_reset() = 0;
    /// Restores a state, with all tools released.
    /// @returns InvalidArgument if it can't be a state of this tissue
    virtual Status do_set_state(std::span<const double> numbers) = 0;
    // Those of Tissue by default.
    virtual Result<GrabReport> do_grab(std::uint32_t tool, const Push& position, double reach_mm);
    virtual Result<PushReport> do_drag_to(Vec3d offset_mm);
    virtual std::optional<Vec3d> do_force_n(std::uint32_t tool);
    virtual Result<SlideReport> do_slide(std::uint32_t tool, const Push& way,
                                         const TissueValues& tissue_values);
    virtual Result<CutReport> do_cut(const CutSurface& surface);
    virtual Result<CarveReport> do_carve(const CarveTool& tool);
    virtual Status do_configure(const Record& changes);

  private:
    template <class Call>
    auto guarded(const char* name, const Call& call) noexcept -> decltype(call());

    std::vector<double> m_kept, m_left;  ///< states before and after a call that failed
};

/// Makes the tissue of a scan; both must outlive it.
using MakeTissue =
    std::function<Result<std::unique_ptr<Tissue>>(const Volume& scan, const TaskArena& arena)>;

}  // namespace pliant
#pragma GCC visibility pop
