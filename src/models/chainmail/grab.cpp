// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/grab.h"

#include <algorithm>
#include <cmath>

#include "field/cell_block.h"
#include "field/tetrahedra.h"
#include "lattice/near_cells.h"

namespace pliant {
namespace {

constexpr double kOnFace = 1e-9;  ///< tolerance of barycentric coordinates

Vec3i floored(Vec3d v) {
    return {int(std::floor(v.x)), int(std::floor(v.y)), int(std::floor(v.z))};
}

std::vector<Vec3i> corners_of(Vec3i lowest) {
    std::vector<Vec3i> corners;
    for (int c = 0; c < 8; ++c) corners.push_back(lowest + Vec3i{c & 1, c >> 1 & 1, c >> 2});
    return corners;
}

std::optional<Vec3i> find_in_block(const CellBlock& block, Vec3d point, Vec3d scale) {
    const Vec3i first = block.first_element();
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x) {
                const auto points = deformed_corners(block, block.corners(x, y, z), scale);
                const Vec3i cell = first + Vec3i{x, y, z};
                const Vec3d local = point - Vec3d{double(cell.x), double(cell.y), double(cell.z)};
                if (locate_in_tetrahedra(points, local, kOnFace)) return cell;
            }
    return std::nullopt;
}

bool holds(const Lattice& lattice, Vec3i coord, Vec3d point, Vec3d scale) {
    Vec3<Fixed> lowest, highest;
    bound_block(lattice, coord, lowest, highest);
    const Vec3i first = lattice.brick_size() * coord;
    for (int a = 0; a < 3; ++a) {
        if (point[a] < first[a] + scale[a] * lowest[a] - kOnFace) return false;
        if (point[a] > first[a] + lattice.brick_size() + scale[a] * highest[a] + kOnFace)
            return false;
    }
    return true;
}

/// A ball in the deformed lattice.
struct Ball {
    Vec3d centre;  ///< continuous voxel index
    double radius_mm;
    Vec3d spacing_mm;

    double away_mm(int axis, int e, Fixed u) const {
        return (e - centre[axis]) * spacing_mm[axis] + mm_from_units(u);
    }

    /// Whether an element of a brick can be in it. @param brick  null: at rest
    bool may_hold(Vec3i first, int size, const Brick* brick) const {
        Vec3d nearest{0, 0, 0};
        for (int a = 0; a < 3; ++a) {
            const double lowest = away_mm(a, first[a], brick ? brick->u_min[a] : Fixed{0});
            const double highest =
                away_mm(a, first[a] + size - 1, brick ? brick->u_max[a] : Fixed{0});
            nearest[a] = std::max({lowest, -highest, 0.0});
        }
        return norm(nearest) <= radius_mm;
    }

    /// Visits the elements of a brick and a box that are in it.
    template <class Visit>
    void visit(Vec3i first, int size, const Brick* brick, const Box3i& box,
               const Visit& visit) const {
        Vec3i begin, end;
        for (int a = 0; a < 3; ++a) {
            begin[a] = std::max(first[a], box.begin[a]);
            end[a] = std::min(first[a] + size, box.end[a]);
        }
        for (int z = begin.z; z < end.z; ++z)
            for (int y = begin.y; y < end.y; ++y) {
                const int row = size * (y - first.y + size * (z - first.z)) - first.x;
                for (int x = begin.x; x < end.x; ++x) {
                    const auto n = std::size_t(row + x);
                    const Vec3d away{away_mm(0, x, brick ? brick->u[0][n] : Fixed{0}),
                                     away_mm(1, y, brick ? brick->u[1][n] : Fixed{0}),
                                     away_mm(2, z, brick ? brick->u[2][n] : Fixed{0})};
                    if (dot(away, away) <= radius_mm * radius_mm) visit({x, y, z});
                }
            }
    }
};

}  // namespace

std::optional<std::vector<Vec3i>> grab_cell(const Lattice& lattice, Vec3d point) {
    const Vec3i rest_cell = floored(point);
    const auto corners = corners_of(rest_cell);
    const bool at_rest = std::all_of(corners.begin(), corners.end(), [&](Vec3i e) {
        return lattice.displacement_at(e) == Vec3<Fixed>{0, 0, 0};
    });
    if (at_rest) return corners;
    const Vec3i reach = largest_movement(lattice);
    const Vec3i low = lattice.brick_of(rest_cell - reach);
    const Vec3i high = lattice.brick_of(rest_cell + reach);
    const Vec3d scale = voxels_per_unit(lattice.grid());
    CellBlock block;
    // In a folded lattice several cells can hold the point: the choice must not depend on the
    // bricks.
    std::optional<Vec3i> lowest;
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                if (!holds(lattice, {x, y, z}, point, scale)) continue;
                block.load(lattice, {x, y, z});
                const auto cell = find_in_block(block, point, scale);
                if (cell && (!lowest || comes_before(*cell, *lowest))) lowest = cell;
            }
    if (!lowest) return std::nullopt;
    return corners_of(*lowest);
}

std::vector<Vec3i> grab_sphere(const Lattice& lattice, Vec3d centre, double radius_mm,
                               const TissueValues& tissue) {
    const Vec3i reach = largest_movement(lattice);
    const Ball ball{centre, radius_mm, lattice.grid().spacing_mm};
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int size = lattice.grid().size[a];
        const double radius = radius_mm / ball.spacing_mm[a] + reach[a];
        box.begin[a] = int(std::clamp(std::floor(centre[a] - radius), 0.0, double(size)));
        box.end[a] = int(std::clamp(std::ceil(centre[a] + radius) + 1, 0.0, double(size)));
    }
    std::vector<Vec3i> grabbed;
    if (is_empty(box)) return grabbed;
    const Vec3i low = lattice.brick_of(box.begin);
    const Vec3i high = lattice.brick_of(box.end - Vec3i{1, 1, 1});
    const auto take = [&](Vec3i e) {
        if (tissue.hold(lattice.value_at(e)) && !lattice.is_void(e)) grabbed.push_back(e);
    };
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const int found = lattice.find_brick({x, y, z});
                const Brick* brick = found < 0 ? nullptr : &lattice.brick(found);
                const Vec3i first = lattice.brick_size() * Vec3i{x, y, z};
                if (ball.may_hold(first, lattice.brick_size(), brick))
                    ball.visit(first, lattice.brick_size(), brick, box, take);
            }
    return grabbed;
}

}  // namespace pliant
