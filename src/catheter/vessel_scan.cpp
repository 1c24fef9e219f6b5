// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each voxel's value follows from its distance to the wall's boundary, and from which side of the
// wall is the nearest: that of the ghost surface is the lumen. Where a block of voxels is far from
// the boundary, its middle tells for all of them.

#include <pliant/mesh_distance.h>
#include <pliant/mesh_quality.h>
#include <pliant/vessel_scene.h>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr double kMargin_mm = 25, kVoxel_mm = 1, kMostVoxels = 256;
constexpr double kLumenHu = 300, kWallHu = 90, kTissueHu = 40, kPatternHu = 20;
constexpr double kPattern_mm = 12;
constexpr int kBlock = 8;

/// −1…1 and back along a period; exact on every machine, which a cosine isn't.
double wave(double x) {
    const double part = x / kPattern_mm - std::floor(x / kPattern_mm);
    return 4 * std::abs(part - 0.5) - 1;
}

/// What the space around a wall is made of.
class Around {
  public:
    static Result<Around> create(const VesselWall& wall) {
        Around around;
        std::vector<std::uint8_t> is_inner(wall.mesh.nodes_mm.size(), 0);
        for (const Embedded& e : wall.ghost_places)
            for (std::size_t c = 0; c < 4; ++c)
                if (e.weights[c] > 0.999)
                    is_inner[std::size_t(wall.mesh.cells[std::size_t(e.tetrahedron)][c])] = 1;
        std::vector<std::int32_t> nodes;
        TriangleMesh boundary = boundary_triangles(wall.mesh, &nodes);
        for (const auto& cell : boundary.cells) {
            int inner = 0;
            for (const std::int32_t n : cell) inner += is_inner[std::size_t(nodes[std::size_t(n)])];
            around.m_is_ghost.push_back(inner == 3);
        }
        auto distance = SurfaceDistance::create(std::move(boundary));
        if (!distance) return distance.error();
        around.m_distance = std::make_shared<const SurfaceDistance>(std::move(*distance));
        around.m_ends = wall.ends;
        return around;
    }

    struct Place {
        double wall_mm;  ///< below 0: in the wall
        bool is_lumen;   ///< else tissue, where it isn't the wall
    };
    Place at(Vec3d p) const {
        const auto nearest = m_distance->nearest(p);
        bool lumen = m_is_ghost[std::size_t(nearest.triangle)] != 0;
        for (const VesselEnd& end : m_ends) {
            const Vec3d from = p - end.centre_mm;
            if (dot(from, end.outward) > 0 && norm(from) < 3 * end.radius_mm + kMargin_mm &&
                norm(nearest.place_mm - end.centre_mm) < 3 * end.radius_mm)
                lumen = false;
        }
        return {nearest.distance_mm, lumen};
    }

  private:
    std::shared_ptr<const SurfaceDistance> m_distance;
    std::vector<std::uint8_t> m_is_ghost;  ///< [triangle]
    std::vector<VesselEnd> m_ends;
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
    const double voxel = std::max(kVoxel_mm, std::ceil(10 * longest / (kMostVoxels - 1)) / 10);
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
        place.is_lumen ? kLumenHu : kTissueHu + kPatternHu * wave(p.x) * wave(p.y) * wave(p.z);
    const double share = std::clamp(0.5 - place.wall_mm / voxel, 0.0, 1.0);
    return std::round(share * kWallHu + (1 - share) * around);
}

}  // namespace

Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) {
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
            const bool is_far = std::abs(at_middle.wall_mm) > half_diagonal + voxel;
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

}  // namespace pliant
