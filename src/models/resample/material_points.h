// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The map between material points of a field and their present positions, in voxels:
//
//   now(X) = X + u(X), u trilinear between the elements       rest(now(X)) = X

#pragma once

#include <array>
#include <optional>

#include "field/field.h"
#include "resample/find_source.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// The cells of a field, read brick by brick. For one thread; keeps a reference to the field.
class FieldCells {
  public:
    explicit FieldCells(const Field& field);

    // Cell interface required by find_source().
    bool corners(Vec3i cell, std::array<Vec3d, 8>& points);
    bool is_whole(Vec3i cell) const;
    DisplacementBounds bounds() const { return m_bounds; }

    /// Whether no element is displaced and no cell has a gap.
    bool is_identity() const { return m_is_at_rest && !m_field.may_have_gaps(); }

  private:
    struct Block {
        Vec3i coord{0, 0, 0};
        bool is_loaded = false;
        bool is_at_rest = true;                     ///< in all eight bricks
        std::array<const FieldBrick*, 8> bricks{};  ///< at + (c & 1, c >> 1 & 1, c >> 2)
    };

    void load(Vec3i brick);

    const Field& m_field;
    int m_size;
    Vec3d m_scale;  ///< voxels per unit
    DisplacementBounds m_bounds;
    bool m_is_at_rest;
    Block m_block;
};

/// For one thread. Keeps a reference to the field, which must not change meanwhile.
class MaterialPoints {
  public:
    explicit MaterialPoints(const Field& field) : m_cells(field) {}

    /// Present position of a material point. Cuts are ignored.
    Vec3d now(Vec3d rest);
    /// Material point at a present position, to kSourceError. Of several, where space is folded,
    /// one near the last result's displacement.
    /// @returns nullopt if a cut or a carving has left a gap there
    std::optional<Vec3d> rest(Vec3d now);

  private:
    FieldCells m_cells;
    Vec3d m_offset{0, 0, 0};  ///< now − rest of the last result
};

}  // namespace pliant
#pragma GCC visibility pop
