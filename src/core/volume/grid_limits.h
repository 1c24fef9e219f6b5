// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Grids that are accepted, from a file or from a host.

#pragma once

#include <pliant/core/vec.h>

#include <cmath>
#include <cstdint>

namespace pliant {

/// Longest axis, and most voxels, that are read [voxels].
inline constexpr std::int64_t kMaxAxisSize = 1 << 16;
inline constexpr std::int64_t kMaxVoxelCount = std::int64_t(1) << 32;
/// Distances between voxel centres that are accepted [mm].
inline constexpr double kMinSpacingMm = 1e-6;
inline constexpr double kMaxSpacingMm = 1e4;
/// Farthest position that is accepted [mm].
inline constexpr double kMaxOriginMm = 1e8;
/// Cosine between axes that pass as perpendicular: 0.06 degrees.
inline constexpr double kMaxSkew = 1e-3;

/// Whether the axes are perpendicular, to within the rounding of numbers in a file.
inline bool is_perpendicular(const Mat3d& direction) {
    const auto& c = direction.columns;
    for (int a = 0; a < 3; ++a) {
        if (!(std::abs(norm(c[a]) - 1) <= kMaxSkew)) return false;
        if (!(std::abs(dot(c[a], c[(a + 1) % 3])) <= kMaxSkew)) return false;
    }
    return true;
}

}  // namespace pliant
