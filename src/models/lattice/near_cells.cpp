// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "lattice/near_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "field/cell_block.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

struct Region {
    Vec3d low, high;  ///< [voxels]

    bool meets(Vec3d lowest, Vec3d highest) const {
        for (int a = 0; a < 3; ++a)
            if (highest[a] < low[a] || lowest[a] > high[a]) return false;
        return true;
    }
    bool meets(const NearCell& cell) const {
        const Vec3d base{double(cell.lowest.x), double(cell.lowest.y), double(cell.lowest.z)};
        Vec3d lowest = cell.corners[0], highest = lowest;
        for (const Vec3d& corner : cell.corners)
            for (int a = 0; a < 3; ++a) {
                lowest[a] = std::min(lowest[a], corner[a]);
                highest[a] = std::max(highest[a], corner[a]);
            }
        return meets(base + lowest, base + highest);
    }
};

/// Bounds of the displacements in one block of cells [voxels].
struct BlockBounds {
    Vec3d lowest, highest;
};

BlockBounds bounds_of(const Lattice& lattice, Vec3i coord, Vec3d scale) {
    Vec3<Fixed> low, high;
    bound_block(lattice, coord, low, high);
    BlockBounds bounds{};
    for (int a = 0; a < 3; ++a) {
        bounds.lowest[a] = scale[a] * low[a];
        bounds.highest[a] = scale[a] * high[a];
    }
    return bounds;
}

/// Rest cells of a block, with a corner in the scan, that its displacements can carry into the
/// region.
Box3i cells_in_reach(const Lattice& lattice, Vec3i coord, const BlockBounds& bounds,
                     const Region& region) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int first = lattice.brick_size() * coord[a];
        const double begin = std::ceil(region.low[a] - bounds.highest[a] - 1);
        const double end = std::floor(region.high[a] - bounds.lowest[a]) + 1;
        const double least = std::max(first, -1);
        const double most = std::min(first + lattice.brick_size(), lattice.grid().size[a]);
        box.begin[a] = int(std::clamp(begin, least, std::max(least, most)));
        box.end[a] = int(std::clamp(end, least, std::max(least, most)));
    }
    return box;
}

class Visitor {
  public:
    Visitor(const Lattice& lattice, const Region& region,
            const std::function<void(const NearCell&)>& visit)
        : m_lattice(lattice),
          m_region(region),
          m_visit(visit),
          m_scale(voxels_per_unit(lattice.grid())) {}

    void visit_block(Vec3i coord) {
        const BlockBounds bounds = bounds_of(m_lattice, coord, m_scale);
        const Box3i cells = cells_in_reach(m_lattice, coord, bounds, m_region);
        if (is_empty(cells)) return;
        const bool rests = bounds.lowest == Vec3d{0, 0, 0} && bounds.highest == Vec3d{0, 0, 0};
        if (!rests) m_block.load(m_lattice, coord);
        const Vec3i first = m_lattice.brick_size() * coord;
        for (int z = cells.begin.z; z < cells.end.z; ++z)
            for (int y = cells.begin.y; y < cells.end.y; ++y)
                for (int x = cells.begin.x; x < cells.end.x; ++x) {
                    const Vec3i local = Vec3i{x, y, z} - first;
                    const NearCell cell{
                        {x, y, z},
                        rests ? kAtRest
                              : deformed_corners(
                                    m_block, m_block.corners(local.x, local.y, local.z), m_scale)};
                    if (m_region.meets(cell)) m_visit(cell);
                }
    }

  private:
    static constexpr std::array<Vec3d, 8> kAtRest = {
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};
    const Lattice& m_lattice;
    const Region& m_region;
    const std::function<void(const NearCell&)>& m_visit;
    Vec3d m_scale;
    CellBlock m_block;
};

/// Blocks that hold the rest position of every element that can lie in the region now.
/// @param reach  largest movement along each axis [voxels]
Box3i blocks_around(const Lattice& lattice, const Region& region, Vec3i reach) {
    Vec3i low, high;
    for (int a = 0; a < 3; ++a) {
        const int last = lattice.grid().size[a] - 1;
        low[a] = int(std::clamp(std::floor(region.low[a]) - reach[a] - 1, -1.0, double(last)));
        high[a] = int(std::clamp(std::floor(region.high[a]) + reach[a] + 1, -1.0, double(last)));
    }
    return {lattice.brick_of(low), lattice.brick_of(high) + Vec3i{1, 1, 1}};
}

}  // namespace

Vec3i largest_movement(const Lattice& lattice) {
    const Vec3d scale = voxels_per_unit(lattice.grid());
    Vec3<Fixed> most{0, 0, 0};
    lattice.for_each_brick([&](const Brick& brick) {
        for (int a = 0; a < 3; ++a) most[a] = std::max({most[a], -brick.u_min[a], brick.u_max[a]});
    });
    Vec3i largest;
    for (int a = 0; a < 3; ++a) largest[a] = int(std::ceil(scale[a] * most[a]));
    return largest;
}

void visit_near_cells(const Lattice& lattice, Vec3d low, Vec3d high,
                      const std::function<void(const NearCell&)>& visit) {
    const Region region{low, high};
    Visitor visitor(lattice, region, visit);
    const Box3i all = blocks_around(lattice, region, largest_movement(lattice));
    if (box_count(all) <= 8 * std::int64_t(lattice.resident_brick_count()) + 64) {
        for_each_in(all, [&](Vec3i coord) { visitor.visit_block(coord); });
        return;
    }
    // Fine voxels: few of the blocks within reach hold elements with large displacements.
    std::vector<Vec3i> blocks = cell_blocks(lattice);
    for_each_in(blocks_around(lattice, region, {0, 0, 0}),
                [&](Vec3i coord) { blocks.push_back(coord); });
    std::sort(blocks.begin(), blocks.end(), comes_before);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    for (const Vec3i& coord : blocks) visitor.visit_block(coord);
}

bool is_whole(const Lattice& lattice, const NearCell& cell) {
    if (!lattice.may_have_gaps()) return true;
    for (std::size_t c = 0; c < 8; ++c)
        if (lattice.is_void(cell.element(c))) return false;
    for (std::size_t c = 0; c < 8; ++c)
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t d = c | std::size_t(1) << axis;
            if (d == c || lattice.is_linked(cell.element(c), axis)) continue;
            if (lattice.displacement_at(cell.element(c)) !=
                lattice.displacement_at(cell.element(d)))
                return false;
        }
    return true;
}

}  // namespace pliant
