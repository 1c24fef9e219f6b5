// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation: the elastic return of pushed tissue, divided into slices of time.
//
// A push leaves links at their limits. Relaxation lowers the elastic energy
//
//   E = Σ over links of weight_ij · |e_j − e_i|²,   e = displacement − imprint,
//
// element by element, each within its links, its movement limit and the tools. The lattice is valid
// after every single move, so relaxation may stop at any time:
//
// @code
//   while (!closed) {
//       draw(tissue);
//       auto report = tissue.relax({.budget_ms = 4, .tools = {tip}, .held = touched});
//   }
// @endcode
//
// A slice continues the previous one if nothing else changed: many short slices give the same bits
// as one long slice. docs/method/chainmail.md, "Relaxation", has the details.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/vec.h>

#include <cstdint>
#include <limits>
#include <stop_token>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A region that tissue may not enter: all points within a radius of a segment, or of a point if
/// both ends are equal. The cells around the segment don't move. So the resampled scan shows no new
/// tissue on the segment, even for thin tools and thick slices.
struct RelaxTool {
    Vec3d from_mm{0, 0, 0};  ///< LPS
    Vec3d to_mm{0, 0, 0};    ///< LPS
    double radius_mm = 0;
};

struct RelaxOptions {
    /// Wall-clock time [ms], checked every few ten thousand elements.
    double budget_ms = std::numeric_limits<double>::infinity();
    /// Sweeps over all elements that still move.
    int max_sweeps = std::numeric_limits<int>::max();
    /// Bricks to relax, each once per pass. With the number of an earlier report, a slice from the
    /// same state ends in the same one.
    std::int64_t max_bricks = std::numeric_limits<std::int64_t>::max();
    /// Checked as often as the time: another thread may end the slice.
    std::stop_token stop{};
    /// An element outside of a tool doesn't enter it. An element inside goes no deeper.
    std::vector<RelaxTool> tools{};
    std::vector<Vec3i> held{};  ///< elements that don't move, for example those that a tool holds
    /// Over-relaxation factor of the step to an element's position of minimal energy, 1…1.95. 1 is
    /// the Gauss-Seidel method; larger is faster, and the energy never rises.
    double over_relaxation = 1.9;
    /// Fills in the energies of the report. Needs two passes over all moved elements, outside of
    /// the budget.
    bool measure_energy = false;
};
SettingRows<RelaxOptions> relax_rows() noexcept;

struct RelaxReport {
    int sweeps = 0;                ///< finished sweeps
    std::int64_t bricks = 0;       ///< relaxed bricks; see RelaxOptions::max_bricks
    bool settled = false;          ///< no element moves any more
    double largest_step_mm = 0;    ///< largest move along an axis in the last finished sweep
    double energy_before_mm2 = 0;  ///< [mm² · weight]; a link of offset 0.2 weighs 640
    double energy_after_mm2 = 0;
    double relax_ms = 0;
    int forgotten_steps = 0;           ///< oldest history steps that were dropped
    std::int64_t workspace_bytes = 0;  ///< memory kept until settled, beside the bricks
};

}  // namespace pliant
#pragma GCC visibility pop
