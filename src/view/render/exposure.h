// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Automatic exposure, metered over the picture.

#pragma once

#include <pliant/render.h>

#include "render/camera.h"
#include "render/volume_rays.h"

namespace pliant::render {

inline constexpr double kLampSize_mm = 3;  ///< keeps the brightness of a wall at the lens finite

/// Exposure E [mm²], such that E / (d² + kLampSize_mm²) is 0.75 at the picture's average
/// brightness. Metered on 11 × 11 rays over the whole picture (Full), or on the 97 of them in the
/// round field (Round, Octagon). Clamped to the values for walls at 5 mm, the lamps' lowest power,
/// and at 45 mm, their highest.
double metered_exposure(const EyeRays& rays, const Camera& camera, FieldStop field_stop);

}  // namespace pliant::render
