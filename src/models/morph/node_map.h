// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// φ(X) = X + u(X) with u at the nodes of a lattice, trilinear in each cell, constant beyond.
//
// det ∂φ/∂X of a cell is a polynomial of second degree in each coordinate. It is at least the
// smallest of its 27 Bernstein coefficients [Johnen2013]. Beyond the lattice u depends on fewer
// coordinates, as in a cell whose nodes move alike along the others: a layer of such cells around
// the lattice has the same determinants as all of the outside. So the bound holds in all of space.
// u is bounded, and a bound above 0 makes φ quasiregular and of degree 1: φ is one to one.
//
// All positions are in nodes, along the lattice's axes.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant::morph {

class NodeMap {
  public:
    /// @param displacements_mm  of all nodes, LPS
    NodeMap(const Grid& nodes, std::span<const Vec3d> displacements_mm);

    const Grid& grid() const { return m_grid; }
    /// u at a point [mm, LPS].
    Vec3d displacement_mm(Vec3d point_mm) const;
    /// φ⁻¹ of a point [mm, LPS]. @pre the least determinant is above 0
    /// @param guess_mm  of φ⁻¹(p) − p
    Vec3d inverse_mm(Vec3d point_mm, Vec3d guess_mm) const;

    struct Cell {
        Vec3i lowest;  ///< −1 beyond the lattice
        double bound;  ///< of its determinant
    };
    /// Cells whose bound is below a limit, those around the lattice too. @param[out] least  of all
    std::vector<Cell> cells_below(double limit, double& least, const TaskArena& arena) const;

    /// As find_source.h asks.
    bool corners(Vec3i cell, std::array<Vec3d, 8>& points) const;

  private:
    Vec3d node(Vec3i at) const;

    Grid m_grid;
    std::vector<Vec3d> m_u;  ///< [nodes]
};

/// Lower bound of det ∂φ/∂X in a cell, from its images of (c & 1, c >> 1 & 1, c >> 2).
double least_determinant(const std::array<Vec3d, 8>& corners);

}  // namespace pliant::morph
