// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What every model of a tissue can do, for whoever owns a scene: tools push it and hold it, it goes
// on by itself, and what was done to it can be taken back. What only one model can do is asked of
// that model. Nothing here knows a clock: what comes out depends on the calls alone.
//
// A call that returns an error, or throws std::bad_alloc, has changed nothing.

#pragma once

#include <pliant/resample.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class SpringDeformation;

struct Sweep {
    bool settled = true;  ///< more of them would change nothing
    double ms = 0;
};

class Tissue : public MovingScan {
  public:
    // Tools, by number. What one holds stays where it is until it lets go.
    virtual Result<PushReport> push(std::uint32_t tool, const Push& push) = 0;
    /// The beginning of a drag, of which there is one at a time.
    virtual Result<GrabReport> grab(std::uint32_t tool, const Push& place, double reach_mm) = 0;
    /// To an offset from where the drag began. @pre a drag goes on
    virtual Result<PushReport> drag_to(Vec3d offset_mm) = 0;
    virtual void let_go() noexcept = 0;  ///< ends the drag, if there is one
    virtual void release(std::uint32_t tool) noexcept = 0;
    /// Puts an eye that only looks into the tissue's way: relaxation keeps out of it.
    /// @param radius_mm  0: it is gone
    virtual void place_eye(std::uint32_t /*tool*/, Vec3d /*place_mm*/, double /*radius_mm*/) {}
    virtual bool has_eye(std::uint32_t /*tool*/) const { return false; }
    virtual bool is_touched_by(std::uint32_t tool) const = 0;
    virtual bool is_touched() const = 0;
    /// On the tool [N], where the model knows newtons.
    virtual std::optional<Vec3d> force_n(std::uint32_t tool) = 0;

    /// Goes on by itself for a while: the smallest part of its motion that is recorded.
    /// @returns LimitExceeded where memory runs out
    virtual Result<Sweep> sweep() = 0;
    /// What time that stands for [ms]; 0: none, it may be as fast as it can.
    virtual double sweep_time_ms() const = 0;
    virtual Status reset() = 0;

    // What was done, in steps: from begin_group() to end_group(), which says how many old ones are
    // forgotten for it; −1: all, and this one too, since it is too large or memory runs out.
    virtual void begin_group(const std::string& name) = 0;
    virtual int end_group() noexcept = 0;
    virtual int undo_steps() const = 0;
    virtual Status undo() = 0;
    virtual Status redo() = 0;

    /// Makes of what is there what load_state() would make of its file. @pre !is_touched()
    virtual Status rest() = 0;
    virtual Status save_state(const std::filesystem::path& path) const = 0;
    virtual Status load_state(const std::filesystem::path& path) = 0;
    virtual std::uint64_t hash() const = 0;

    // The model itself; null: it is another one.
    virtual ChainMail* chainmail() { return nullptr; }
    virtual SpringDeformation* springs() { return nullptr; }
};

}  // namespace pliant
#pragma GCC visibility pop
