// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The frame with a given third axis that is nearest to the world's frame.

#pragma once

#include <pliant/models/pbd.h>

#include <cmath>
#include <numbers>

namespace pliant::catheter {

/// @pre d isn't zero
inline Rotation frame_along(Vec3d d) {
    d = normalized(d);
    const Vec3d z{0, 0, 1}, axis = cross(z, d);
    const double sine = norm(axis), angle = std::atan2(sine, dot(z, d));
    if (sine > 1e-12) return rotation_by((angle / sine) * axis);
    return d.z > 0 ? Rotation{} : rotation_by({std::numbers::pi, 0, 0});
}

}  // namespace pliant::catheter
