// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation: the elastic return of pushed tissue, in as many slices of time as there are.
//
// A push leaves links at their limits. Relaxation lowers the elastic energy
//
//   E = Σ over links of weight_ij · |e_j − e_i|²,   e = displacement − imprint,
//
// element by element, each only as far as its links, its movement limit and the tools allow. So the
// lattice is valid after every single move, and relaxation may stop at any time:
//
//   while (!closed) {
//       draw(tissue);
//       auto report = tissue.relax({.budget_ms = 4, .tools = {tip}, .held = touched});
//   }
//
// Slices go on where the last one stopped, as long as nothing else changed: many short ones give
// the same bits as one long one. docs/chainmail.md, "Relaxation", has the details.

#pragma once

#include <pliant/vec.h>

#include <cstdint>
#include <limits>
#include <stop_token>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A region that tissue may not enter: all points within a radius of a segment. Both ends equal: a
/// sphere. The cells around the segment stay as they are, so the resampled scan shows no tissue on
/// it that it didn't show before, however thin the tool or thick the slices.
struct RelaxTool {
    Vec3d from_mm{0, 0, 0};  ///< LPS
    Vec3d to_mm{0, 0, 0};    ///< LPS
    double radius_mm = 0;
};

struct RelaxOptions {
    /// Wall-clock time, asked for every few ten thousand elements [ms].
    double budget_ms = std::numeric_limits<double>::infinity();
    /// Sweeps over everything that still moves.
    int max_sweeps = std::numeric_limits<int>::max();
    /// Asked for as often as the time: another thread may end the slice.
    std::stop_token stop{};
    /// An element that is outside of a tool doesn't enter it; one that is inside goes no deeper.
    std::vector<RelaxTool> tools{};
    std::vector<Vec3i> held{};  ///< elements that stay where they are: those that a tool holds
    /// Each element goes this many times the way to its place of least energy, 1…1.95. 1 is the
    /// plain method; larger is faster, and energy still never rises.
    double over_relaxation = 1.9;
    /// Fills in the energies of the report: two looks at all that moved, outside of the budget.
    bool measure_energy = false;
};

struct RelaxReport {
    int sweeps = 0;                ///< that this slice finished
    bool settled = false;          ///< nothing moves any more
    double largest_step_mm = 0;    ///< along an axis, of any element, in the last finished sweep
    double energy_before_mm2 = 0;  ///< [mm² · weight]; a link of offset 0.2 weighs 640
    double energy_after_mm2 = 0;
    double relax_ms = 0;
    int forgotten_steps = 0;           ///< oldest steps that this one pushed out of the history
    std::int64_t workspace_bytes = 0;  ///< kept until settled, beside the bricks
};

}  // namespace pliant
#pragma GCC visibility pop
