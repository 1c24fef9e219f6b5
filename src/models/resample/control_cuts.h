// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts of a control lattice. Everything is decided at rest, where nodes and elements lie on whole
// voxels: a link is cut if a triangle crosses it, and an element sees a node of its cell if no
// triangle crosses the line between them.
//
//     a────────b        v sees a and c. Instead of the hidden b and d it follows their ghosts,
//     │ v   ╱  │        which move like the nodes beside them on v's side: b like a, d like c.
//     │   ╱ w  │        So both sides move as if their tissue went on, and the cut can open.
//     c──╱─────d
//
// Ghosts belong to nodes, not to cells, so that tissue on one side stays continuous from cell to
// cell [Molino2004].

#pragma once

#include <pliant/resample.h>

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "field/field.h"
#include "mesh/blade.h"

namespace pliant {

class ControlCuts {
  public:
    ControlCuts() = default;
    /// @returns InvalidArgument for a corner that isn't finite, or far away
    static Result<ControlCuts> create(const Grid& scan, const ControlGrid& control,
                                      std::span<const CutTriangle> triangles_mm, int brick_size,
                                      const TaskArena& arena);

    std::span<const CutTriangle> triangles_mm() const { return m_triangles_mm; }
    /// Whether a triangle crosses the line between two points. In voxels.
    bool is_between(Vec3d from, Vec3d to) const;

    /// A hidden node as seen from the other side of a cut.
    struct Ghost {
        std::int32_t node;
        std::vector<std::int32_t> like;  ///< nodes on the element's side
    };
    const std::vector<Ghost>& ghosts() const { return m_ghosts; }
    /// Corners of an element in a crossed cell: nodes, and ghosts as node_count + index. Null in
    /// other cells. @param at  element's position in the cell [voxels]
    const std::int32_t* corners(Vec3i cell, Vec3i at) const;
    /// Flags of cut links of the field's bricks.
    const EditMap& edits() const { return m_edits; }

  private:
    struct CrossedCell {
        Vec3i cell;
        std::vector<std::int32_t> triangles;
        std::vector<std::int32_t> corners{};  ///< [element of (cell + 1)³][8]
        std::vector<std::uint8_t> edits{};    ///< [element]
    };
    struct Box {
        Position low, high;
    };

    std::int32_t node_at(Vec3i n) const;
    Vec3i position_of(std::int32_t node) const;
    Position voxel_of(Vec3i node) const;
    bool crosses_one_of(std::span<const std::int32_t> triangles, Position from, Position to) const;
    void find_cells();
    void find_ghosts();
    void look_from_elements(CrossedCell& cell) const;
    void collect_edits(int brick_size);

    ControlGrid m_control;
    std::vector<CutTriangle> m_triangles_mm;
    std::vector<Triangle> m_triangles;
    std::vector<Box> m_boxes;
    std::vector<CrossedCell> m_cells;
    std::vector<std::int32_t> m_cell_at;  ///< [cell of the lattice]: index, or −1
    std::vector<Ghost> m_ghosts;
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t>
        m_ghost_of;  ///< of a node, for a node from which it is hidden
    EditMap m_edits;
};

}  // namespace pliant
