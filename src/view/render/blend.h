// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light along a ray through an emitting and absorbing medium: the volume rendering integral of
// [Max1995], front to back, in equal steps of at most half a voxel. The opacity of a step is 1 −
// exp(−extinction · step), so a uniform medium obeys the law of Beer and Lambert for every step
// size.
//
// Steps in bricks entirely below the opacity ramp are skipped. They contribute nothing, so the
// picture is bit-identical.

#pragma once

#include <pliant/render.h>

#include "render/caster.h"
#include "render/volume_rays.h"

namespace pliant::render {

struct Blended {
    Vec3d light;           ///< linear, without the background
    double transmittance;  ///< transmitted share of the background's light
};

class Blender {
  public:
    /// @param may_skip  false: makes all steps, for comparison
    Blender(const VolumeRays& rays, const TransferFunction& transfer, bool may_skip = true);

    /// @param direction  world, unit
    Blended along(Vec3d origin_mm, Vec3d direction) const;

  private:
    template <class T>
    Blended through(const VoxelField<T>& field, const VoxelRay& ray, Vec3d direction) const;
    Vec3d shaded(Vec3d colour, Vec3d gradient, Vec3d direction) const;

    const VolumeRays& m_rays;
    double m_low_hu, m_window_hu, m_extinction, m_step_mm;
    Vec3d m_dim, m_bright;
    LeapMap m_leaps;  // empty: no skipping
};

}  // namespace pliant::render
