// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local growth of tissue at a position of the lattice at rest: det ∂φ/∂X of the trilinear map of
// the cell around it. It is the map that the resampler inverts, so the number belongs to the
// displayed tissue, and a voxel's number changes only when its own cell does.
//
// Positions come from single precision. For one that lies on a face, to within rounding, the cell
// on the high side counts; if that is torn or beyond the border, the one on the low side.

#pragma once

#include <array>

#include "resample/snapshot.h"

namespace pliant {

class SourceJacobian {
  public:
    /// Keeps references; for one thread.
    SourceJacobian(const Field& field, const Snapshot& snapshot);

    /// @param position  position at rest [voxels]. @returns 1 if there is no whole cell
    double at(Vec3d position);

  private:
    struct Corner {
        const BrickRecord* record;
        int element;  ///< index in its brick
    };
    using Corners = std::array<Corner, 8>;

    Corners corners_of(Vec3i cell);
    bool is_whole(Vec3i cell, const Corners& corners) const;
    double in_cell(const Corners& corners, Vec3d t) const;
    double beside_gaps(Vec3i cell, Vec3d t);

    const Field& m_field;
    const Snapshot& m_snapshot;
    int m_size;
    Vec3d m_scale;  ///< voxels per unit
    bool m_may_have_gaps;
    Vec3i m_brick{0, 0, 0};
    bool m_is_loaded = false;
    std::array<const BrickRecord*, 8> m_records{};  ///< of m_brick and its upper neighbours
};

}  // namespace pliant
