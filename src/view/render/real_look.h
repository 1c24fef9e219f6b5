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
#include <pliant/resample.h>

#include <span>

#include "render/camera.h"
#include "render/shade.h"
#include "render/volume_rays.h"

namespace pliant::render {

class RealLook {
  public:
    RealLook(const VolumeRays& rays, const EyeRays& eye_rays, const Endoscope& endoscope,
             const Camera& camera);

    /// Light of walls at rays' hits, linear, 0…1, after the tone curve. Hits of neighbouring pixels
    /// are the fastest.
    /// @param[out] light  one for each hit
    void shade(std::span<const LookHit> hits, Vec3d* light) const;
    /// Light of one wall: the scalar version, bit-identical.
    Vec3d shade(const LookHit& hit) const;

    /// Transmission of the field stop and the vignette at a position of the picture [halves of its
    /// height, from its centre].
    double field(double u, double v) const;

    double exposure() const { return m_input.exposure; }

  private:
    Vec3d shade(const LookHit& hit, const RestField::Sample& moved) const;

    const VolumeRays& m_rays;
    const Endoscope& m_endoscope;
    LookInput m_input;
    double m_radius;  ///< of the field [halves of the picture's height]
};

}  // namespace pliant::render
