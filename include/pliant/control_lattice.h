// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan embedded in a coarse lattice of control nodes [Choi2004, 4.2.2]. Every voxel keeps its
// local coordinates in the cell that holds it at rest, and moves with the cell's eight nodes.
//
//     o---------o---------o      o control nodes, on voxel centres, `cell` voxels apart
//     | . . . . | . . . . |      . voxels: u = Σ (trilinear weight) · (displacement of the node)
//     | . . . . | . . . . |
//     o---------o---------o
//
// The model that moves the nodes is independent of this class. The nodes' displacements are written
// to a lattice of the scan's elements; from there the volume, its fields and pictures come as with
// ChainMail. This conversion is exact: a control cell is a whole number of voxels long, so each
// voxel cell lies in one control cell, and the trilinear map of the large cell is that of the small
// one.

#pragma once

#include <pliant/resample.h>

#include <array>
#include <memory>
#include <optional>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

struct ControlGrid {
    Vec3i first{0, 0, 0};  ///< voxel of node 0
    Vec3i cell{8, 8, 8};   ///< voxels from one node to the next
    Vec3i size{2, 2, 2};   ///< nodes along i, j, k; i fastest
};

/// Material point: a control cell and local coordinates in it.
struct ControlPlace {
    std::array<std::int32_t, 8> nodes{};  ///< corner c is at + (c & 1, c >> 1 & 1, c >> 2)
    Vec3d at{0, 0, 0};                    ///< local coordinates, 0…1 along i, j, k
};

class ControlLattice : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument if a node lies outside of the scan
    static Result<std::unique_ptr<ControlLattice>> create(const Volume& volume,
                                                          const ControlGrid& grid,
                                                          const TaskArena& arena) noexcept;
    ~ControlLattice() override;

    /// Moves the elements with the nodes. Visits only cells with a node that moved since the last
    /// call. Voxels outside of the control lattice never move.
    /// @param displacements_mm  of all nodes [mm, LPS]
    /// @returns InvalidArgument if a displacement isn't finite or exceeds 500 mm along an axis,
    ///          LimitExceeded if memory runs out; then nothing has changed
    Status place(std::span<const Vec3d> displacements_mm) noexcept;

    /// Material point at a position in the deformed scan [mm, LPS]. The first cell wins if cells
    /// overlap.
    std::optional<ControlPlace> find(Vec3d point_mm) const;
    /// Whether some control cell is folded or nearly so: at one of its corners, less than `share`
    /// of the volume is left. @pre as many displacements as nodes
    bool folds(std::span<const Vec3d> displacements_mm, double share = 0) const;

    const ControlGrid& grid() const;
    std::int32_t node_count() const;
    Vec3d node_mm(std::int32_t node) const;  ///< rest position [mm, LPS]

    const Volume& volume() const override;
    const Deformation& deformation() const override;
    const TaskArena& arena() const override;

  private:
    struct Impl;
    explicit ControlLattice(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
