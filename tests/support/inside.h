// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// On which side of a vessel's ghost surface a point is, by all of its triangles, one by one; and a
// bent vessel to ask that of.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/vessel.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "mesh/triangle_distance.h"

namespace pliant::test {

/// Distance of a point from the surface; below 0: beyond it. Where several triangles are as near,
/// the one that is seen most from above says the side.
inline double inside_by(Vec3d place, std::span<const Vec3d> nodes, const TriangleMesh& surface) {
    double least = 1e9, side = 0;
    for (const auto& t : surface.cells) {
        const Vec3d a = nodes[std::size_t(t[0])], b = nodes[std::size_t(t[1])],
                    c = nodes[std::size_t(t[2])];
        const Vec3d d = place - mesh::nearest_on_triangle(place, a, b, c).position;
        const double height = dot(d, normalized(cross(b - a, c - a)));
        if (norm(d) < least - 1e-9) {
            least = norm(d);
            side = height;
        } else if (norm(d) < least + 1e-9 && std::abs(height) > std::abs(side)) {
            side = height;
        }
    }
    return side < 0 ? -least : least;
}

/// Along z, then round a part of a circle towards x, then straight on; a point every 2 mm.
struct BentWay {
    double inner_mm, from_mm, to_mm;  ///< z of where the first straight part begins and ends
    double radius_mm, angle_rad;
    double last_mm;  ///< of the second straight part
};
inline std::vector<CentrePoint> bent_way(const BentWay& w) {
    std::vector<CentrePoint> way;
    for (double z = w.from_mm; z < w.to_mm; z += 2) way.push_back({{0, 0, z}, w.inner_mm});
    for (int n = 0; n <= 24; ++n) {
        const double angle = w.angle_rad * n / 24;
        way.push_back(
            {{w.radius_mm * (1 - std::cos(angle)), 0, w.to_mm + w.radius_mm * std::sin(angle)},
             w.inner_mm});
    }
    const Vec3d last = way.back().position_mm,
                ahead{std::sin(w.angle_rad), 0, std::cos(w.angle_rad)};
    for (double s = 2; s < w.last_mm; s += 2) way.push_back({last + s * ahead, w.inner_mm});
    return way;
}

}  // namespace pliant::test
