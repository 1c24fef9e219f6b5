// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Automatic exposure, metered over the picture.

#pragma once

#include "render/camera.h"
#include "render/volume_rays.h"

namespace pliant::render {

inline constexpr double kLampSize_mm = 3;  ///< a wall that touches the lens isn't infinitely bright

/// Factor of light: 1/(d² + kLampSize_mm²), times it, is about 1 where the picture is as bright as
/// it is on average. Metered on 11 × 11 rays in the round field. Between that of a wall at 5 mm and
/// at 45 mm: beyond them lamps dim no further, or can do no more [mm²].
double metered_exposure(const EyeRays& rays, const Camera& camera);

}  // namespace pliant::render
