// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation in slices: sweeps over the bricks, one colour of elements after the other.
//
// A *pass* moves the elements of one colour; two passes are a sweep. The move of an element in a
// pass depends on its neighbours only, which have the other colour. So the result is independent of
// the order of bricks, their size and the number of threads. A pass skips a brick if nothing on
// which it depends has changed since it last stood still. Bricks of the two chessboard colours
// alternate within a pass, so that no row is read while it is written.
//
// Elements at rest stay.
//
// Between slices the position in the pass is stored. As long as the lattice's clock has not
// advanced, the next slice continues there. Otherwise it starts a new pass, at the brick where the
// last one stopped, so that even slices too short for a whole pass eventually reach every brick.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/relax.h>

#include <chrono>
#include <memory>
#include <vector>

#include "lattice/lattice.h"
#include "relax/plastic.h"
#include "relax/relax_links.h"
#include "relax/tool_contact.h"

namespace pliant {

class Relaxation {
  public:
    Relaxation(Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

    /// Prepares a slice; nothing moves.
    void begin(const RelaxOptions& options);
    /// Whether run may allocate: for missing links of bricks, for cells around tools, or for the
    /// lattice's observer. Otherwise it can't fail.
    bool needs_memory() const;
    /// Runs the slice. @pre begin with the same options
    RelaxReport run(const RelaxOptions& options);
    /// Rolls back after a failure, with the lattice restored to its state before begin: the next
    /// slice continues where the failed one was to begin.
    void roll_back() noexcept;
    /// Forgets the position in the pass: the next slice begins like the first one.
    void start_over() noexcept;

  private:
    using Clock = std::chrono::steady_clock;
    /// State from which the next slice continues.
    struct Pass {
        std::size_t cursor = 0;         ///< position in m_bricks at which the pass continues
        bool is_cut_short = false;      ///< in the middle of a pass
        Vec3i stopped_at{0, 0, 0};      ///< brick at the cursor, at the end of the last slice
        int colour = 0;                 ///< of the pass
        int quiet_passes = 0;           ///< number of consecutive passes without a change
        Fixed step = 0, last_step = 0;  ///< largest step of this pass and of the previous one
        Fixed sweep_step = 0;
    };
    /// Conditions under which the bricks stood still.
    struct Conditions {
        double over_relaxation = 0;
        std::vector<RelaxTool> tools;
        std::vector<Vec3i> held;
        ToolContact contact;
    };
    /// Data of a brick beside its displacements, created when it is first swept.
    struct Workspace {
        std::shared_ptr<const BrickLinks> links;
        std::vector<std::uint8_t> held;
        PlasticPull pull;
        bool changed[2] = {true, true};  ///< by its last pass of each colour
        bool has_old_bounds = false;     ///< of the displacements: u_min and u_max are old
        Fixed step = 0;                  ///< largest step of its last pass
    };

    bool goes_on() const;
    void begin_anew();
    void make_lists();
    void wake_all();
    void list_bricks();
    void forget_dropped() noexcept;
    std::size_t bricks_per_look() const;
    std::size_t index_of(Vec3i coord) const;
    void make_all_links();
    void hold_around_tools();
    void mark_held();
    bool run_pass(const RelaxOptions& options, Clock::time_point end);
    void finish_pass();
    void update_bounds(int index);
    void relax_brick(int index, int colour, double over_relaxation);
    bool is_wanted(int index, int colour) const;
    void snap_to_rest();
    void release_workspace();
    std::int64_t workspace_bytes() const;
    Workspace& workspace(int index) { return *m_workspaces[std::size_t(index)]; }
    const Workspace& workspace(int index) const { return *m_workspaces[std::size_t(index)]; }

    Lattice& m_lattice;
    const PlasticRest& m_rest;
    const TaskArena& m_arena;
    std::unique_ptr<BrickLinksMaker> m_maker;
    std::uint64_t m_links_version = 0;
    std::uint64_t m_clock = 0;  ///< the lattice's clock at the end of the last slice
    bool m_has_begun = false;
    bool m_has_lists = false;
    Pass m_at;
    Conditions m_under;
    // State before begin.
    Pass m_was_at;
    Conditions m_was_under;
    bool m_went_on = false, m_is_under_others = false;
    std::vector<Vec3i> m_around_tools;  ///< held elements between which tissue could pass a tool
    std::vector<std::unique_ptr<Workspace>> m_workspaces;  ///< by brick index
    std::vector<int> m_bricks;    ///< the even bricks of the chessboard, then the odd ones
    std::size_t m_first_odd = 0;  ///< position in m_bricks
    int m_finished_sweeps = 0;    ///< of this slice
    std::int64_t m_relaxed = 0;   ///< bricks of this slice
    std::vector<int> m_wanted;    ///< bricks of a pass between two checks of the time
};

}  // namespace pliant
