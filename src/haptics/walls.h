// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The walls around a tool, as planes that its centre stays in front of: tangents of the iso
// surface, moved by the tool's radius. The nearest one, and those that rays in 26 directions meet
// and that don't cut off another.

#pragma once

#include <pliant/haptics_models.h>
#include <pliant/render.h>

#include <span>
#include <vector>

namespace pliant {

/// Of the planes, the place that a tool has gone beyond; or, where it is in front of all, the
/// nearest.
struct WallContact {
    Vec3d entry_mm{0, 0, 0};    ///< of the tool's centre
    Vec3d surface_mm{0, 0, 0};  ///< below it
    Vec3d normal{0, 0, 1};
    double depth_mm = 0;  ///< 0: in front of all
};

class Walls {
  public:
    /// Keeps references: volume and arena must outlive it.
    Walls(const Volume& volume, const TaskArena& arena);

    /// Planes and friction of a model, and nothing else of it.
    HapticModel around(const ChainMailFeelSettings& settings, Vec3d proxy_mm);
    /// Where a tool touches that is at `tool`, given planes of around(). @pre there are planes
    static WallContact contact(const HapticModel& planes, Vec3d tool_mm, double radius_mm);
    /// The volume has changed in these boxes.
    void update(std::span<const Box3i> boxes) { m_caster.update(boxes); }
    const RayCaster& caster() const { return m_caster; }

  private:
    std::vector<RayHit> hits(const ChainMailFeelSettings& settings, Vec3d place_mm);

    RayCaster m_caster;
    std::vector<Vec3d> m_rays;
    std::vector<double> m_distances;
};

}  // namespace pliant
