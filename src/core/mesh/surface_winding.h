// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Winding number of a closed surface around a point: 1 inside, 0 outside [VanOosterom1983]. Unlike
// the side of the nearest triangle, it is robust to self-intersecting surfaces.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

namespace pliant::mesh {

/// @param x  [node], positions
inline double surface_winding(std::span<const std::array<std::int32_t, 3>> triangles,
                              std::span<const Vec3d> x, Vec3d p) {
    double sum = 0;
    for (const auto& t : triangles) {
        const Vec3d a = x[std::size_t(t[0])] - p, b = x[std::size_t(t[1])] - p,
                    c = x[std::size_t(t[2])] - p;
        const double u = norm(a), v = norm(b), w = norm(c);
        sum += std::atan2(dot(a, cross(b, c)),
                          u * v * w + dot(a, b) * w + dot(b, c) * u + dot(c, a) * v);
    }
    return sum / (2 * std::numbers::pi);
}

}  // namespace pliant::mesh
