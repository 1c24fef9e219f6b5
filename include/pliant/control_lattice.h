// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan that hangs in a coarse lattice of control nodes [Choi2004, 4.2.2]: every voxel keeps its
// place in the cell that it lies in at rest, and goes where the cell's eight nodes carry it.
//
//     o---------o---------o      o control nodes, on voxel centres, `cell` voxels apart
//     | . . . . | . . . . |      . voxels: u = Σ (trilinear weight) · (displacement of the node)
//     | . . . . | . . . . |
//     o---------o---------o
//
// What moves the nodes is not known here. Their displacements are written to a lattice of the
// scan's own elements, and from there the volume, its fields and pictures come as with ChainMail.
// Nothing is lost by that: a control cell is a whole number of voxels long, so each voxel cell lies
// in one control cell, and the trilinear map of the large one is that of the small one.

#pragma once

#include <pliant/resample.h>

#include <array>
#include <memory>
#include <optional>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

struct ControlGrid {
    Vec3i first{0, 0, 0};  ///< the voxel of node 0
    Vec3i cell{8, 8, 8};   ///< voxels from one node to the next
    Vec3i size{2, 2, 2};   ///< nodes along i, j, k; i fastest
};

/// A place of the material: the control cell that holds it.
struct ControlPlace {
    std::array<std::int32_t, 8> nodes{};  ///< corner c is at + (c & 1, c >> 1 & 1, c >> 2)
    Vec3d at{0, 0, 0};                    ///< in the cell, 0…1 along i, j, k
};

class ControlLattice : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument where the nodes aren't all voxels of the scan
    static Result<std::unique_ptr<ControlLattice>> create(const Volume& volume,
                                                          const ControlGrid& grid,
                                                          const TaskArena& arena) noexcept;
    ~ControlLattice() override;

    /// Moves the elements to where the nodes now are; only cells with a node that moved since are
    /// looked at. Voxels outside of the control lattice never move.
    /// @param displacements_mm  of all nodes [mm, LPS]
    /// @returns with nothing changed, InvalidArgument for displacements that are no number or above
    ///          500 mm along an axis, LimitExceeded where memory runs out
    Status place(std::span<const Vec3d> displacements_mm) noexcept;

    /// The material that is at a place now [mm, LPS]; where cells overlap, that of the first.
    std::optional<ControlPlace> find(Vec3d point_mm) const;
    /// Whether some control cell would be folded, or nearly: at one of its corners less than
    /// `share` of the volume is left. @pre as many displacements as nodes
    bool folds(std::span<const Vec3d> displacements_mm, double share = 0) const;

    const ControlGrid& grid() const;
    std::int32_t node_count() const;
    Vec3d node_mm(std::int32_t node) const;  ///< at rest [mm, LPS]

    const Volume& volume() const override;
    const Lattice& lattice() const override;
    const TaskArena& arena() const override;

  private:
    struct Impl;
    explicit ControlLattice(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
