// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scan around a vessel goes where its wall goes: every voxel near the wall moves by a mean of
// what the wall's nodes next to it have moved, less and less with the distance, and those beyond
// `reach_mm` not at all. It is a control lattice (control_lattice.h), so the deformed volume, its
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
    double reach_mm = 20;  ///< from the wall's nodes
    double cell_mm = 3;    ///< of the control lattice: the nearest number of voxels, at least one
};

class CarriedScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument where the wall isn't in the scan or a setting is wrong
    static Result<CarriedScan> create(const Volume& volume, const TetMesh& wall,
                                      const CarriedScanSettings& settings,
                                      const TaskArena& arena) noexcept;
    ~CarriedScan();
    CarriedScan(CarriedScan&&) noexcept;
    CarriedScan& operator=(CarriedScan&&) noexcept;

    /// Where the wall's nodes are now.
    /// @returns with nothing changed, InvalidArgument for another number of them, LimitExceeded
    /// where
    ///          memory runs out
    Status update(std::span<const Vec3d> wall_places) noexcept;
    const ControlLattice& scan() const;

  private:
    struct Impl;
    explicit CarriedScan(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
