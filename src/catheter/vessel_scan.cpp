// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The value of a voxel depends on its distance to the wall's boundary, and outside of the wall on
// its side of the ghost surface, closed with lids. If a block of voxels is far from both surfaces,
// its middle determines all of its values.

#include <pliant/catheter.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

constexpr double kMargin_mm = 25, kVoxel_mm = 1, kMaxVoxels = 256;
constexpr double kLumenHu = 300, kWallHu = 90, kTissueHu = 40, kPatternHu = 20;
constexpr double kPattern_mm = 12;
constexpr int kBlock = 8;

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

    struct Place {
        double wall_mm, lumen_mm;  ///< negative inside
        bool is_far(double reach_mm) const {
            return std::abs(wall_mm) > reach_mm && std::abs(lumen_mm) > reach_mm;
        }
    };
    Place at(Vec3d p) const { return {m_boundary.signed_mm(p), m_lumen.signed_mm(p)}; }

  private:
    Around(SurfaceDistance boundary, SurfaceDistance lumen)
        : m_boundary(std::move(boundary)), m_lumen(std::move(lumen)) {}
    SurfaceDistance m_boundary, m_lumen;
};

Grid grid_around(const std::vector<Vec3d>& nodes_mm) {
    Vec3d low = nodes_mm.front(), high = low;
    for (const Vec3d& p : nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low + Vec3d{2 * kMargin_mm, 2 * kMargin_mm, 2 * kMargin_mm};
    const double longest = std::max({span.x, span.y, span.z});
    const double voxel = std::max(kVoxel_mm, std::ceil(10 * longest / (kMaxVoxels - 1)) / 10);
    Grid grid;
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = int(std::ceil(span[a] / voxel)) + 1;
        grid.spacing_mm[a] = voxel;
        grid.origin_mm[a] = std::floor(low[a] - kMargin_mm);
    }
    return grid;
}

double value_at(Vec3d p, const Around::Place& place, double voxel) {
    const double around =
        place.lumen_mm < 0 ? kLumenHu : kTissueHu + kPatternHu * wave(p.x) * wave(p.y) * wave(p.z);
    const double share = std::clamp(0.5 - place.wall_mm / voxel, 0.0, 1.0);
    return std::round(share * kWallHu + (1 - share) * around);
}

Result<Volume> fill_scan(const VesselWall& wall, const TaskArena& arena) {
    const auto around = Around::create(wall);
    if (!around) return around.error();
    Volume volume;
    volume.grid = grid_around(wall.mesh.nodes_mm);
    volume.key_values = {{"iso_hu", "200"}, {"polarity", "falling"}};
    const Grid& grid = volume.grid;
    const double voxel = grid.spacing_mm.x;
    VoxelArray<std::int16_t> values(voxel_count(grid));
    Vec3i blocks;
    for (int a = 0; a < 3; ++a) blocks[a] = (grid.size[a] + kBlock - 1) / kBlock;
    const double half_diagonal = 0.5 * std::sqrt(3.0) * kBlock * voxel;
    const auto fill = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t b = begin; b < end; ++b) {
            const Vec3i block{int(b % blocks.x), int(b / blocks.x % blocks.y),
                              int(b / blocks.x / blocks.y)};
            const Vec3i first = kBlock * block;
            Vec3d middle;
            for (int a = 0; a < 3; ++a) middle[a] = first[a] + 0.5 * (kBlock - 1);
            const Around::Place at_middle = around->at(world_from_voxel(grid, middle));
            const bool is_far = at_middle.is_far(half_diagonal + voxel);
            for (int k = first.z; k < std::min(first.z + kBlock, grid.size.z); ++k)
                for (int j = first.y; j < std::min(first.y + kBlock, grid.size.y); ++j)
                    for (int i = first.x; i < std::min(first.x + kBlock, grid.size.x); ++i) {
                        const Vec3d p = world_from_voxel(grid, {double(i), double(j), double(k)});
                        const Around::Place place = is_far ? at_middle : around->at(p);
                        values[voxel_index(grid, {i, j, k})] =
                            std::int16_t(value_at(p, place, voxel));
                    }
        }
    };
    arena.for_each(std::int64_t(blocks.x) * blocks.y * blocks.z, 1, fill);
    volume.voxels = std::move(values);
    return volume;
}

}  // namespace

Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept {
    return attempt([&] { return fill_scan(wall, arena); });
}

}  // namespace pliant
