// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The walls around a tool, as planes that bound its centre: tangents of the iso surface, offset by
// the tool's radius. They are the nearest one, and hits of rays in 26 directions that don't cut off
// another wall.

#pragma once

#include <pliant/render.h>
#include <pliant/view/haptics.h>

#include <span>
#include <vector>

namespace pliant {

/// Contact with the plane that the tool has crossed, or the nearest plane if it has crossed none.
struct WallContact {
    Vec3d entry_mm{0, 0, 0};    ///< entry point of the tool's centre
    Vec3d surface_mm{0, 0, 0};  ///< surface point below it
    Vec3d normal{0, 0, 1};
    double depth_mm = 0;  ///< 0: no plane is crossed
};

class Walls {
  public:
    /// Keeps references: volume and arena must outlive it.
    Walls(const Volume& volume, const TaskArena& arena);

    /// Model with planes and friction only.
    HapticModel around(const ChainMailFeelSettings& settings, Vec3d proxy_mm);
    /// Contact of a tool at `tool` with the planes of around(). @pre there are planes
    static WallContact contact(const HapticModel& planes, Vec3d tool_mm, double radius_mm);
    /// Tells that the volume has changed in these boxes.
    void update(std::span<const Box3i> boxes) { m_caster.update(boxes); }
    const RayCaster& caster() const { return m_caster; }

  private:
    std::vector<RayHit> hits(const ChainMailFeelSettings& settings, Vec3d position_mm);

    RayCaster m_caster;
    std::vector<Vec3d> m_rays;
    std::vector<double> m_distances;
};

}  // namespace pliant
