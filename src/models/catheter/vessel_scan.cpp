// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The value of a voxel depends on its distance to the wall's boundary, and outside of the wall on
// its side of the ghost surface, closed with lids.

#include <pliant/mesh.h>
#include <pliant/models/catheter.h>

#include <algorithm>
#include <cmath>

#include "base/errors.h"
#include "resample/filled_scan.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

constexpr double kMargin_mm = 25, kVoxel_mm = 1;
constexpr int kMaxVoxels = 256;
constexpr double kLumenHu = 300, kWallHu = 90, kTissueHu = 40, kPatternHu = 20;
constexpr double kPattern_mm = 12;

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    const double part = x / kPattern_mm - std::floor(x / kPattern_mm);
    return 4 * std::abs(part - 0.5) - 1;
}

/// Distances to the wall and to the lumen.
class Around {
  public:
    static Result<Around> create(const VesselWall& wall) {
        auto boundary = SurfaceDistance::create(boundary_triangles(wall.mesh));
        if (!boundary) return boundary.error();
        auto closed = vessel::with_lids(wall.ghost);
        if (!closed) return closed.error();
        for (auto& t : closed->cells) std::swap(t[1], t[2]);  // the ghost surface faces the lumen
        auto lumen = SurfaceDistance::create(std::move(*closed));
        if (!lumen) return lumen.error();
        return Around(std::move(*boundary), std::move(*lumen));
    }

    struct Position {
        double wall_mm, lumen_mm;  ///< negative inside
        bool is_far(double reach_mm) const {
            return std::abs(wall_mm) > reach_mm && std::abs(lumen_mm) > reach_mm;
        }
    };
    Position at(Vec3d p) const { return {m_boundary.signed_mm(p), m_lumen.signed_mm(p)}; }

  private:
    Around(SurfaceDistance boundary, SurfaceDistance lumen)
        : m_boundary(std::move(boundary)), m_lumen(std::move(lumen)) {}
    SurfaceDistance m_boundary, m_lumen;
};

double value_at(Vec3d p, const Around::Position& position, double voxel) {
    const double around = position.lumen_mm < 0
                              ? kLumenHu
                              : kTissueHu + kPatternHu * wave(p.x) * wave(p.y) * wave(p.z);
    const double share = std::clamp(0.5 - position.wall_mm / voxel, 0.0, 1.0);
    return std::round(share * kWallHu + (1 - share) * around);
}

Result<Volume> fill_scan(const VesselWall& wall, const TaskArena& arena) {
    const auto around = Around::create(wall);
    if (!around) return around.error();
    Volume volume;
    volume.grid = grid_around(wall.mesh.nodes_mm, kMargin_mm, kVoxel_mm, kMaxVoxels);
    volume.key_values = {{"iso_hu", "200"}, {"polarity", "falling"}};
    const double voxel = volume.grid.spacing_mm.x;
    volume.voxels = filled(
        volume.grid, arena, [&](Vec3d p) { return around->at(p); },
        [&](Vec3d p, const Around::Position& position) { return value_at(p, position, voxel); });
    return volume;
}

}  // namespace

Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept {
    return attempt([&] { return fill_scan(wall, arena); });
}

}  // namespace pliant
