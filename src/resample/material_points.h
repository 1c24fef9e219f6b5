// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The map between material points and their present positions, in voxels:
//
//   now(X) = X + u(X), u trilinear between the elements       rest(now(X)) = X
//
// The inverse walks from cell to cell: Newton's step in a cell that doesn't hold the point leads to
// a neighbour. Where that goes in a circle (tissue beside strongly sheared air), all cells that can
// hold the point are tried, the nearest first.

#pragma once

#include <array>
#include <optional>

#include "field/field.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// For one thread. Keeps a reference to the field, which must not change meanwhile.
class MaterialPoints {
  public:
    explicit MaterialPoints(const Field& field);

    /// Present position of a material point. Cuts are ignored.
    Vec3d now(Vec3d rest);
    /// Material point at a present position. Of several, where space is folded, one near the last
    /// result's displacement.
    /// @returns nullopt if a cut or a carving has left a gap there
    std::optional<Vec3d> rest(Vec3d now);

    /// Number of points so far for which the walk failed.
    int searches() const { return m_searches; }

  private:
    struct Block {
        Vec3i coord{0, 0, 0};
        bool is_loaded = false;
        bool is_at_rest = true;                     ///< in all eight bricks
        std::array<const FieldBrick*, 8> bricks{};  ///< at + (c & 1, c >> 1 & 1, c >> 2)
    };

    /// Present positions of a cell's corners, relative to its lowest element at rest.
    /// @returns false if the cell is at rest
    bool corners(Vec3i cell, std::array<Vec3d, 8>& points);
    bool is_whole(Vec3i cell) const;
    void load(Vec3i brick);
    std::optional<Vec3d> in_cell(Vec3i cell, Vec3d now);
    std::optional<Vec3d> walk(Vec3d now, Vec3d from);
    std::optional<Vec3d> search(Vec3d now);

    const Field& m_field;
    int m_size;
    Vec3d m_scale;                             ///< voxels per unit
    Vec3d m_u_min{0, 0, 0}, m_u_max{0, 0, 0};  ///< bounds of all displacements [voxels]
    bool m_is_at_rest;
    Block m_block;
    Vec3d m_offset{0, 0, 0};  ///< now − rest of the last result
    int m_searches = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
