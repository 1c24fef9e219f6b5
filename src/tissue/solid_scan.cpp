// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Soft tissue in air, with a faint pattern that shows in sections how the inside moves.

#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "resample/filled_scan.h"

namespace pliant {
namespace {

constexpr double kTissueHu = 60, kPatternHu = 25;
constexpr double kMarginShare = 0.15;   ///< of the longest side
constexpr double kVoxelShare = 0.0064;  ///< likewise: some 200 voxels with the margins
constexpr double kPatternShare = 0.06;
constexpr int kMaxVoxels = 256;

/// The largest of 1, 2 and 5 times a power of ten up to a length.
double round_down(double mm) {
    const double power = std::pow(10, std::floor(std::log10(mm)));
    return (mm >= 5 * power ? 5 : mm >= 2 * power ? 2 : 1) * power;
}

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    return 4 * std::abs(x - std::floor(x) - 0.5) - 1;
}

struct Place {
    double distance_mm;  ///< negative inside
    bool is_far(double reach_mm) const { return std::abs(distance_mm) > reach_mm; }
};

Result<Volume> scan_of(const TetMesh& mesh, const TaskArena& arena) {
    if (const Status s = check_quality(tet_quality(mesh)); !s.ok()) return s.error();
    auto boundary = SurfaceDistance::create(boundary_triangles(mesh));
    if (!boundary) return boundary.error();
    Vec3d low = mesh.nodes_mm.front(), high = low;
    for (const Vec3d& p : mesh.nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low;
    const double longest = std::max({span.x, span.y, span.z});
    Volume volume;
    volume.grid = grid_around(mesh.nodes_mm, kMarginShare * longest,
                              round_down(kVoxelShare * longest), kMaxVoxels);
    const double voxel = volume.grid.spacing_mm.x, pattern = round_down(kPatternShare * longest);
    volume.voxels = filled(
        volume.grid, arena, [&](Vec3d p) { return Place{boundary->signed_mm(p)}; },
        [&](Vec3d p, const Place& place) {
            const double inside = kTissueHu + kPatternHu * wave(p.x / pattern) *
                                                  wave(p.y / pattern) * wave(p.z / pattern);
            const double share = std::clamp(0.5 - place.distance_mm / voxel, 0.0, 1.0);
            return std::round(share * inside + (1 - share) * kAirHu);
        });
    return volume;
}

}  // namespace

Result<Volume> scan_of_solid(const TetMesh& mesh, const TaskArena& arena) noexcept {
    return attempt([&] { return scan_of(mesh, arena); });
}

}  // namespace pliant
