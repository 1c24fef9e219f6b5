// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Surfaces of scans in the light of a distant lamp. The lamp at an endoscope's lens shows no relief
// in a frontal view of a wall; a lamp at the side does.

#pragma once

#include <pliant/render.h>

#include <functional>

namespace pliant::results {

inline constexpr Rgb8 kSkin{226, 168, 150};
inline constexpr Rgb8 kBackdrop{236, 238, 242};

/// Colour of the surface at a point in full light. @param x, y  of the pixel
using SurfaceColour = std::function<Rgb8(const RayHit& hit, int x, int y)>;

/// First hits of the camera's rays, diffuse and without shadows; pixels without a hit are pale.
/// @param towards_lamp  LPS, any length > 0
/// @param gain  of the lamp: above 1 for grazing light
/// @param colour  default: kSkin
Image lit_view(const RayCaster& caster, const Endoscope& camera, int width, int height,
               Vec3d towards_lamp, double gain = 1, const SurfaceColour& colour = {});

/// Mixes two colours. @param t  0: a, 1: b
Rgb8 mixed(Rgb8 a, Rgb8 b, double t);

}  // namespace pliant::results
