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

    RelaxReport run(const RelaxOptions& options);

  private:
    using Clock = std::chrono::steady_clock;
    /// What a brick needs beside its displacements, made when it is first swept.
    struct Workspace {
        std::shared_ptr<const BrickLinks> links;
        std::vector<std::uint8_t> held;
        PlasticPull pull;
        bool changed[2] = {true, true};  ///< by its last pass of each colour
        bool has_old_bounds = false;     ///< of the displacements, u_min and u_max
        Fixed step = 0;                  ///< largest of its last pass
    };

    void begin(const RelaxOptions& options);
    void begin_anew();
    void wake_all();
    void list_bricks();
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
    // What the bricks stood still under.
    double m_over_relaxation = 0;
    std::vector<RelaxTool> m_tools;
    std::vector<Vec3i> m_held;
    std::vector<Vec3i> m_around_tools;  ///< elements that keep tissue out between them, held too
    ToolContact m_contact;
    std::vector<std::unique_ptr<Workspace>> m_workspaces;  ///< by brick index
    std::vector<int> m_bricks;    ///< the even ones of the chessboard, then the odd ones
    std::size_t m_first_odd = 0;  ///< place in m_bricks
    std::size_t m_cursor = 0;     ///< place in m_bricks where the pass goes on
    int m_colour = 0;             ///< of the pass
    int m_quiet_passes = 0;       ///< that changed nothing, one after the other
    Vec3i m_stopped_at{0, 0, 0};  ///< brick at m_cursor, at the end of the last slice
    Fixed m_pass_step = 0, m_last_pass_step = 0, m_sweep_step = 0;
    int m_finished_sweeps = 0;  ///< of this slice
    std::vector<int> m_wanted;  ///< of the piece of a pass between two looks at the time
};

}  // namespace pliant
