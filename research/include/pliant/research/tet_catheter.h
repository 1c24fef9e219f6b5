// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The catheter of [VesselPbd2016], a body of tetrahedra, in a vessel, to compare it with the rod of
// CatheterScene: the same wall, contact, sub-steps and hand. docs/method/vessel.md has its model.
//
// @code
//   auto catheter = TetCatheter::create(wall, {});
//   catheter->step({.insert_mm_s = 100}, arena);
// @endcode

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/mesh.h>
#include <pliant/models/catheter.h>
#include <pliant/models/pbd.h>
#include <pliant/result.h>

#include <cstdint>
#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// Thread safety: concurrent reads.
class TetCatheter {
  public:
    /// All of the wall moves, whatever the settings say. The tip's GJ decreases with its EI.
    /// @returns InvalidArgument that names the setting, also if the tetrahedra can't have this
    ///          ratio of GJ to EI
    static Result<TetCatheter> create(const VesselWall& wall,
                                      const CatheterSettings& settings) noexcept;
    ~TetCatheter();
    TetCatheter(TetCatheter&&) noexcept;
    TetCatheter& operator=(TetCatheter&&) noexcept;

    /// Advances by one time step.
    /// @returns LimitExceeded if a position is no longer finite or memory runs out; the state is
    ///          then undefined
    Status step(const CatheterCommand& command, const TaskArena& arena) noexcept;

    /// Inserted length, force, contact, depth, wall_moved_mm, volume and inverted tetrahedra, those
    /// of the catheter included. Needs a pass over the wall.
    CatheterMeasures measures() const;
    double depth_mm() const;  ///< penetration of the ghost surface; negative: distance
    std::span<const Vec3d> wire_positions() const;  ///< [mm, LPS], along the axis, the tip last
    std::int32_t first_inserted() const;            ///< index of the last node inside the guide
    Rotation tip_frame() const;  ///< the third axis points ahead, the tip bends about the others
    TetMesh mesh() const;        ///< in the present shape, including the part in the guide
    const PbdBody& body() const;

  private:
    struct Impl;
    explicit TetCatheter(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
