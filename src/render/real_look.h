// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shading of the style "real": the picture of a camera at the end of an endoscope.
//
//        lamp   lens   lamp        two lamps beside the lens, inverse-square falloff, a shadow each
//          \     |     /
//           \    |    /            wall: colour of the scan a little behind it, blood vessels and
//      ______\___|___/______       patches anchored to the tissue at rest, light through the
//        ~ ~ ~ ~ ~ ~ ~ ~ ~         tissue (wrapped diffuse, per channel), a film of liquid (GGX)
//
// The exposure adapts to the picture; a tone curve and a round field stop are applied last. The
// page's shader (viewer/src/shaders/real.glsl) computes the same.

#pragma once

#include <pliant/render.h>

#include "render/camera.h"
#include "render/lining.h"
#include "render/noise_tile.h"
#include "render/volume_rays.h"

namespace pliant::render {

class RealLook {
  public:
    RealLook(const VolumeRays& rays, const EyeRays& eye_rays, const Endoscope& endoscope,
             const Camera& camera);

    /// Light of a wall at a ray's hit, linear, 0…1, after the tone curve.
    /// @param normal, direction  unit vectors
    Vec3d shade(double t, Vec3d point_mm, Vec3d normal, Vec3d direction) const;

    /// Transmission of the field stop and the vignette at a position of the picture [halves of its
    /// height, from its centre].
    double field(double u, double v) const;

    double exposure() const { return m_exposure; }

  private:
    /// A closed cut: not visible in the voxels, only in the field of raw tissue.
    struct Slit {
        double depth;   ///< 0…1: darkness
        Vec3d towards;  ///< direction to the slit along the wall, longest at its lips
    };
    /// Position and normal of a wall for its light.
    struct Face {
        Vec3d point_mm;
        Vec3d normal;
    };
    struct Coat {
        Vec3d colour;
        Vec3d normal;  ///< normal of the wall, bent at the lips of a slit
        Vec3d film;    ///< normal of the film of liquid
        double wetness;
    };

    Coat coat(double t, Vec3d point_mm, Vec3d normal) const;
    /// Face of raw tissue. Carving takes out whole voxels, which leaves terraces: the normal is
    /// that of the share of tissue within a few voxels, and the position is where that share is
    /// half.
    Face raw_face(Vec3d point_mm, Vec3d normal, Vec3d direction, double raw) const;
    Slit slit_at(Vec3d point_mm, Vec3d normal, double raw) const;
    double value_behind(Vec3d point_mm, Vec3d normal, double voxels) const;
    double excess(Vec3d point_mm) const;
    double openness(Vec3d point_mm, Vec3d normal) const;
    double lit(Vec3d point_mm, Vec3d normal, Vec3d to_lamp, double far_mm) const;

    const VolumeRays& m_rays;
    const Endoscope& m_endoscope;
    LiningColours m_colours;
    const NoiseTile& m_noise;
    Vec3d m_lamps[2];
    Vec3d m_voxel_axes[3];  ///< a step along each axis of the grid [mm]
    double m_spacing_mm;    ///< of the voxels, geometric mean
    double m_voxel_mm;      ///< step behind the wall
    double m_exposure;
    double m_radius;  ///< of the field [halves of the picture's height]
};

}  // namespace pliant::render
