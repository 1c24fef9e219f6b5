// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// By how much tissue grew at any place of the lattice at rest: det ∂φ/∂X of the trilinear map of
// the cell around it. It is the map that the resampler inverts, so the number belongs to what is
// shown, and a voxel's changes only when its own cell does.
//
// Places come from single precision. Where one lies on a face, to within rounding, the cell on the
// high side counts; where that is torn or beyond the border, the one on the low side.

#pragma once

#include <array>

#include "resample/snapshot.h"

namespace pliant {

class SourceJacobian {
  public:
    /// Keeps references; for one thread.
    SourceJacobian(const Lattice& lattice, const Snapshot& snapshot);

    /// @param place  at rest [voxels]. @returns 1 where there is no whole cell
    double at(Vec3d place);

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

    const Lattice& m_lattice;
    const Snapshot& m_snapshot;
    int m_size;
    Vec3d m_scale;  ///< voxels per unit
    bool m_may_have_gaps;
    Vec3i m_brick{0, 0, 0};
    bool m_is_loaded = false;
    std::array<const BrickRecord*, 8> m_records{};  ///< of m_brick and those behind it
};

}  // namespace pliant
