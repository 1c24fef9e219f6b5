// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation in slices: sweeps over the bricks, one colour of elements after the other.
//
// A *pass* moves the elements of one colour; two passes are a sweep. What a pass does to an element
// depends on its neighbours only, which have the other colour, so neither the order of bricks nor
// their size or the number of threads matters. A brick is left out of a pass where nothing that it
// depends on has changed since it stood still: it would stand still again. Bricks of the two
// chessboard colours take turns within a pass, so that nobody reads a row while it is written.
//
// Between slices the place in the pass is kept. As long as the lattice's clock has not moved, the
// next slice goes on there; else it begins anew, at the brick where the last one stopped, so that
// slices too short for a whole pass reach every brick in the end.

#pragma once

#include <pliant/chainmail_relax.h>
#include <pliant/tasks.h>

#include <chrono>
#include <memory>
#include <vector>

#include "chainmail/lattice.h"
#include "chainmail/plastic.h"
#include "chainmail/relax_links.h"
#include "chainmail/tool_contact.h"

namespace pliant {

class Relaxation {
  public:
    Relaxation(Lattice& lattice, const PlasticRest& rest, const TaskArena& arena);

    /// Gets ready for a slice; nothing moves.
    void begin(const RelaxOptions& options);
    /// Whether run may allocate: for links that bricks don't have yet, for cells around tools, or
    /// for the lattice's observer. Else it can't fail.
    bool needs_memory() const;
    /// The slice. @pre begin with the same options
    RelaxReport run(const RelaxOptions& options);
    /// After a failure, with the lattice restored to its state before begin: the next slice goes
    /// on where that one was to begin.
    void roll_back() noexcept;

  private:
    using Clock = std::chrono::steady_clock;
    /// Where the next slice goes on.
    struct Place {
        std::size_t cursor = 0;         ///< place in m_bricks where the pass goes on
        bool is_cut_short = false;      ///< in the middle of a pass
        Vec3i stopped_at{0, 0, 0};      ///< brick at the cursor, at the end of the last slice
        int colour = 0;                 ///< of the pass
        int quiet_passes = 0;           ///< that changed nothing, one after the other
        Fixed step = 0, last_step = 0;  ///< largest of this pass and of the one before
        Fixed sweep_step = 0;
    };
    /// What the bricks stood still under.
    struct Conditions {
        double over_relaxation = 0;
        std::vector<RelaxTool> tools;
        std::vector<Vec3i> held;
        ToolContact contact;
    };
    /// What a brick needs beside its displacements, made when it is first swept.
    struct Workspace {
        std::shared_ptr<const BrickLinks> links;
        std::vector<std::uint8_t> held;
        PlasticPull pull;
        bool changed[2] = {true, true};  ///< by its last pass of each colour
        bool has_old_bounds = false;     ///< of the displacements, u_min and u_max
        Fixed step = 0;                  ///< largest of its last pass
    };

    bool goes_on() const;
    void begin_anew();
    void make_lists();
    void wake_all();
    void list_bricks();
    void forget_dropped() noexcept;
    std::size_t bricks_per_look() const;
    std::size_t place_of(Vec3i coord) const;
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
    std::uint64_t m_clock = 0;  ///< the lattice's at the end of the last slice
    bool m_has_begun = false;
    bool m_has_lists = false;
    Place m_at;
    Conditions m_under;
    // As they were before begin.
    Place m_was_at;
    Conditions m_was_under;
    bool m_went_on = false, m_is_under_others = false;
    std::vector<Vec3i> m_around_tools;  ///< elements that keep tissue out between them, held too
    std::vector<std::unique_ptr<Workspace>> m_workspaces;  ///< by brick index
    std::vector<int> m_bricks;    ///< the even ones of the chessboard, then the odd ones
    std::size_t m_first_odd = 0;  ///< place in m_bricks
    int m_finished_sweeps = 0;    ///< of this slice
    std::vector<int> m_wanted;    ///< of the piece of a pass between two looks at the time
};

}  // namespace pliant
