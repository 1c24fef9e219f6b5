// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The piecewise map φ of a deformation and its inverse, in double precision, with a proof of
// uniqueness where it is cheap.
//
// A cell is regular if the 64 triple products of its edges along x, y and z are positive: the
// Jacobian of its trilinear map is a convex combination of them, so it is positive everywhere.
// Other cells may be folded. A cell with a void corner, or with a cut that has opened, is broken:
// it has no image.
//
// Were broken cells stretched instead of missing, φ would be continuous, and the identity far away.
// Then the signs of the Jacobian at all points that φ maps to y add up to 1. So a point y that lies
// in the box around no folded and no broken cell comes from exactly one point, in a regular cell.
// Points near broken cells are searched in all cells around them; points near folded cells count as
// ambiguous.
//
// All points here are continuous voxel indices: x at rest, y deformed.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/data/truth.h>
#include <pliant/deformation.h>
#include <pliant/volume.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "field/fixed_point.h"

namespace pliant::truth {

enum class CellState : std::uint8_t { Regular, Folded, Broken };

/// State of a cell whose links are whole.
CellState state_of_shape(const std::array<Vec3d, 8>& corners);

class ExactMap {
  public:
    /// Copies the deformation. @throws std::bad_alloc
    ExactMap(const Deformation& deformation, const TaskArena& arena);

    const Grid& grid() const { return m_grid; }
    /// All elements that may be displaced, and one more layer around them.
    const Box3i& elements() const { return m_elements; }
    std::int64_t folded_cells() const { return m_folded_cells; }

    Vec3<Fixed> units_at(Vec3i element) const {
        return contains(m_elements, element) ? m_u[index_of(element)] : Vec3<Fixed>{0, 0, 0};
    }
    bool is_void(Vec3i element) const {
        return !m_edits.empty() && contains(m_elements, element) &&
               (m_edits[index_of(element)] & kVoid) != 0;
    }
    /// φ of an element.
    Vec3d image_of(Vec3i element) const;
    /// φ of a point; nothing if its cell is broken, or void.
    std::optional<Vec3d> image_of(Vec3d x) const;
    /// The one point that φ maps to y.
    /// @param guess  nearby point, or y
    /// @param[out] x  set if the answer is Exact
    /// @returns Exact, Gap or Ambiguous
    TruthMask source_of(Vec3d y, Vec3d guess, Vec3d& x) const;
    /// Whether y lies in the box around no folded and no broken cell.
    bool is_plain(Vec3d y) const { return mark_at(y) == 0; }

    CellState state_of(Vec3i cell) const {
        return contains(m_cells, cell) ? m_states[cell_index(cell)] : CellState::Regular;
    }

  private:
    class Cells;

    static constexpr std::uint8_t kNearFolded = 1, kNearBroken = 2;
    static constexpr int kTile = 16, kBlock = 4;  ///< voxels, cells along an edge

    struct Bounds {
        Vec3d low, high;
        bool hold(Vec3d y) const;
    };

    std::size_t index_of(Vec3i e) const;
    std::size_t cell_index(Vec3i c) const;
    std::uint8_t mark_at(Vec3d y) const;
    void load(const Field& field, const TaskArena& arena);
    void find_states(const TaskArena& arena);
    bool is_broken(Vec3i cell) const;
    bool is_plainly_regular(Vec3i cell) const;
    CellState shape_of(Vec3i cell) const;
    /// Cell interface required by find_source(). @pre cell of m_cells
    bool find_corners(Vec3i cell, std::array<Vec3d, 8>& points) const;
    void mark(Vec3i cell, CellState state);
    void list_blocks(const TaskArena& arena);
    Bounds bounds_of_block(Vec3i block) const;
    TruthMask search(Vec3d y, Vec3d& x) const;

    Grid m_grid;
    Vec3d m_voxels_per_unit;
    Box3i m_elements, m_cells;
    std::vector<Vec3<Fixed>> m_u;
    std::vector<std::uint8_t> m_edits;  ///< empty: none
    std::vector<CellState> m_states;    ///< [cell of m_cells]
    std::vector<std::uint8_t> m_marks;  ///< [voxel]: the unit cube from it on; empty: none
    std::int64_t m_folded_cells = 0;
    Vec3i m_tiles{0, 0, 0}, m_blocks{0, 0, 0};
    std::vector<Bounds> m_block_bounds;                      ///< [block]
    std::vector<std::uint32_t> m_tile_begin, m_tile_blocks;  ///< blocks that reach each tile
};

}  // namespace pliant::truth
