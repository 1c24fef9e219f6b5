// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/tetrahedra.h"

#include <cmath>

namespace pliant {

std::optional<CellWeights> locate_in_tetrahedra(const std::array<Vec3d, 8>& corners, Vec3d point,
                                                double tolerance) {
    constexpr double kFlat = 6e-12;  // six times the volume [voxels]
    Vec3d centre{0, 0, 0};
    for (const Vec3d& corner : corners) centre = centre + corner;
    centre = 0.125 * centre;
    const Vec3d p = point - centre;
    for (int t = 0; t < 12; ++t) {
        const auto& triangle = kCellTriangles[std::size_t(t)];
        const Vec3d a = corners[std::size_t(triangle[0])] - centre;
        const Vec3d b = corners[std::size_t(triangle[1])] - centre;
        const Vec3d c = corners[std::size_t(triangle[2])] - centre;
        const double volume = dot(a, cross(b, c));
        if (std::abs(volume) < kFlat) continue;
        const double wa = dot(p, cross(b, c)) / volume;
        const double wb = dot(a, cross(p, c)) / volume;
        const double wc = dot(a, cross(b, p)) / volume;
        const double centre_weight = 1 - wa - wb - wc;
        if (wa >= -tolerance && wb >= -tolerance && wc >= -tolerance && centre_weight >= -tolerance)
            return CellWeights{t, {centre_weight, wa, wb, wc}};
    }
    return std::nullopt;
}

}  // namespace pliant
