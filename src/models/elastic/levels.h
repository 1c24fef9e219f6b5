// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Elastic equilibrium on nested lattices. The coarsest ones cover the scan, each finer one is a
// window around the tools if the whole level would be too large:
//
//   +---------------------------+
//   |  level 2                  |     Unknowns are the nodes of the finest lattice at each place.
//   |     +-----------+         |     A node on the border of a window (o) follows the coarser
//   |     o level 1   o         |     lattice, and its force acts there: one conforming
//   |     o  +-----+  o         |     discretisation, symmetric like that of a single lattice.
//   |     o  o  0  o  o         |
//   |     o  +-----+  o         |     A level's values under a window are corrections of the
//   |     +-----------+         |     multigrid cycle only.
//   +---------------------------+
//
// The solver is conjugate gradients, preconditioned by a V-cycle with Chebyshev smoothing
// [McCormick1989 for the windows; Adams2003 for the smoothing]. Cells are co-rotational
// [Mueller2004]: the rotations are brought up to date when a solution begins. It may be stopped
// after each iteration, and goes on from its result.
//
// Walls that meet across air touch: a cell of air resists further deformation from the shape on
// that a corner of it has nearly no volume, as soft tissue would. What it had before is its shape
// of no force, so that touching begins and ends without a jump.

#pragma once

#include <pliant/core/tasks.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/aligned_array.h"
#include "elastic/level.h"
#include "elastic/stiffness_map.h"
#include "elastic/sweeps.h"

namespace pliant {

struct SmootherSettings {
    int degree = 6;   ///< of the smoothing polynomial, before and after the correction
    float part = 50;  ///< eigenvalues above λ_max/part are smoothed
    int last_degree = 40;
    float last_part = 2000;
};

/// How all nodes follow some held ones that move along an axis, in the linear system of one state.
struct HeldResponse {
    struct OfLevel {
        Box3i window;
        std::array<AlignedVector<float>, 3> along;  ///< [axis][component][node] per mm
    };
    std::vector<OfLevel> levels{};  ///< empty: none
};

class ElasticLevels {
  public:
    /// @param map  must outlive the levels
    /// @param window_cells  along an edge of a window, even; a level of fewer nodes is whole
    ElasticLevels(const StiffnessMap& map, int window_cells, bool turns, const TaskArena& arena);
    ~ElasticLevels();

    /// Moves the windows so that the tools are inside. Displacements are kept.
    /// @param voxels  the centre of the finest window
    void focus(Vec3d voxel);
    /// Frees the levels of earlier windows, which are kept so that going back to a state needs no
    /// memory.
    void forget_windows() { m_spare.clear(); }
    /// Whether a voxel is well inside the finest window.
    bool is_inside(Vec3d voxel, double margin) const;
    /// Nodes of the finest lattice, as voxels; is_empty if it has no window yet.
    Box3i finest() const;

    /// Replaces the nodes that tools hold. Bone and held sides never move, and are left out.
    void hold(std::span<const HeldNode> nodes);

    /// Takes the map's changes in a box of voxels into account.
    void renew(const Box3i& voxels);

    /// Begins a solution from the present displacement: walls that touch, rotations, forces.
    /// @returns norm of the residual [µN]
    double start();
    /// One iteration. @returns norm of the residual after it [µN]; 0 if there is nothing to solve
    double iterate();
    /// Finds the response to held nodes that move, with a number of iterations for each axis.
    /// @param voxels  some of the held nodes
    void find_response(std::span<const Vec3i> voxels, int iterations, HeldResponse& response);
    /// Moves all nodes as those of the response move by a shift. @returns false, and nothing has
    /// changed, if the windows are others than the response's
    bool respond(const HeldResponse& response, Vec3d shift_mm);
    /// Internal forces [µN] on voxels that are nodes, along the lattice's axes; 0 on others. A
    /// voxel is a node of the finest lattice at its place, or none.
    std::vector<Vec3d> forces_un(std::span<const Vec3i> voxels);

    /// Displacements [mm] of count voxels along x from a voxel on, along the lattice's axes. May be
    /// called from several threads.
    void displacement_row(Vec3i first, int count, const NodeRows& to) const;
    /// Smallest box of voxels that may be displaced by more than a length along some axis.
    Box3i moved_box(double mm) const;
    /// Smooths the displacement around cells of tissue that have a corner with a determinant of the
    /// deformation gradient below a limit, until there is none.
    /// @returns whether that succeeds
    bool untangle(double limit);
    /// Whether the last call of untangle() moved nodes.
    bool was_tangled() const { return m_was_tangled; }

    double largest_mm() const;  ///< largest displacement of a node along an axis
    /// Number of voxels that are displaced by more than a length along some axis.
    std::int64_t moved_voxels(double mm) const;

    void reset();
    /// All displacements × factor. @pre no node is held
    void scale(double factor);
    // All displacements as numbers, for states.
    void copy_to(std::vector<double>& numbers) const;
    bool copy_from(std::span<const double> numbers);
    /// Moves back towards an earlier state: u += part (earlier − u).
    /// @returns largest distance from it on an axis [mm]; infinite if its windows are others, and
    ///          nothing is moved
    double go_back(std::span<const double> earlier, double part);

    std::int64_t node_count() const;
    std::int64_t bytes() const;
    SmootherSettings smoother{};

  private:
    using Levels = std::vector<std::unique_ptr<ElasticLevel>>;

    std::vector<Box3i> windows_at(Vec3d voxel) const;
    bool are_nested(std::span<const Box3i> windows) const;
    void place(std::span<const Box3i> windows);
    std::unique_ptr<ElasticLevel> take_level(int number, const Box3i& window);
    static void take_displacements(const ElasticLevel& from, ElasticLevel& to);
    void smooth(ElasticLevel& level, bool from_zero, int degree, float part,
                bool with_residual) const;
    void cycle(std::size_t n);
    template <class Change>
    void sweep(ElasticLevel& level, SweepPass pass, const Change& change) const;
    template <class Body>
    void for_planes(const ElasticLevel& level, const Body& body) const;
    template <class Part>
    double sum_over_planes(const Part& part) const;
    void gather(std::size_t n) const;
    void interpolate(const ElasticLevel& coarse, const NodeRows& from, const ElasticLevel& fine,
                     const NodeRows& to) const;
    void inject(std::size_t n);
    void follow(std::size_t n);
    void give_forces(std::size_t n, NodeRows ElasticLevel::*rows, bool to_held);
    static void slide(const ElasticLevel& level, const NodeRows& rows);
    void find_residual(Turning turning);
    bool find_touching();
    static bool read_touching(std::span<const double>& numbers, Vec3i cells,
                              std::vector<TouchingCell>& touching);
    void stiffen();

    const StiffnessMap& m_map;
    const TaskArena& m_arena;
    int m_window_cells;
    bool m_turns;
    Levels m_levels;  ///< finest first
    Levels m_spare;   ///< of earlier windows
    std::vector<HeldNode> m_held;
    bool m_was_tangled = false;
    double m_product = 0;  ///< residual · correction of the last iteration; 0: none
};

}  // namespace pliant
