// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Moves the scan around a vessel with the vessel's wall. The displacement of a voxel near the wall
// is a weighted mean over the nearby wall nodes. It fades out with the distance and is zero beyond
// `reach_mm`. The deformation is a control lattice (control_lattice.h), so the deformed volume, its
// fields and pictures come as with every tissue.
//
//   auto carried = CarriedScan::create(volume, wall.mesh, {}, arena);
//   carried->update(scene.wall_places());
//   Result<Deformed> deformed = deform_volume(carried->scan());

#pragma once

#include <pliant/control_lattice.h>
#include <pliant/mesh.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

struct CarriedScanSettings {
    double reach_mm = 20;  ///< distance from the wall's nodes
    double cell_mm = 3;    ///< edge of a cell of the control lattice, rounded to whole voxels, at
                           ///< least one
};

class CarriedScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument if the wall lies outside of the scan or a setting is invalid
    static Result<CarriedScan> create(const Volume& volume, const TetMesh& wall,
                                      const CarriedScanSettings& settings,
                                      const TaskArena& arena) noexcept;
    ~CarriedScan();
    CarriedScan(CarriedScan&&) noexcept;
    CarriedScan& operator=(CarriedScan&&) noexcept;

    /// Moves the scan with the wall's nodes.
    /// @param wall_places  current positions of all wall nodes [mm, LPS]
    /// @returns InvalidArgument if their number is wrong, LimitExceeded if memory runs out; then
    ///          nothing has changed
    Status update(std::span<const Vec3d> wall_places) noexcept;
    const ControlLattice& scan() const;

  private:
    struct Impl;
    explicit CarriedScan(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
