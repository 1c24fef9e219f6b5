// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/touched.h"

#include <algorithm>

#include "chainmail/check.h"

namespace pliant {
namespace {

Vec3i extent(const Box3i& box) {
    return box.end - box.begin;
}

VoxelMask mask_of(Box3i box) {
    const Vec3i n = extent(box);
    return {box, std::vector<std::uint8_t>(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z))};
}

/// Elements that moved, one layer of resting ones around them.
VoxelMask moved_elements(const Lattice& lattice, const Box3i& moved, const TaskArena& arena) {
    VoxelMask mask = mask_of({moved.begin - Vec3i{1, 1, 1}, moved.end + Vec3i{1, 1, 1}});
    const std::vector<int> bricks = lattice.resident_bricks();
    arena.for_each(std::int64_t(bricks.size()), 16, [&](std::int64_t b, std::int64_t e) {
        for (; b < e; ++b) {
            const Brick& brick = lattice.brick(bricks[std::size_t(b)]);
            for (int n = 0; n < lattice.elements_per_brick(); ++n) {
                const auto i = std::size_t(n);
                if ((brick.u[0][i] | brick.u[1][i] | brick.u[2][i]) == 0) continue;
                mask.flags[mask.index(lattice.element_of(brick.coord, n))] = 1;
            }
        }
    });
    return mask;
}

/// Combines each flag with its neighbour on the low (step −1) or high (step +1) side along an
/// axis; beyond the box flags are 0.
template <class Combine>
void combine_along(VoxelMask& mask, int axis, int step, const TaskArena& arena, Combine combine) {
    const Vec3i n = extent(mask.box);
    const Vec3i strides{1, n.x, n.x * n.y};
    const int u = axis == 2 ? 1 : 2, v = axis == 0 ? 1 : 0;
    // Lines along `axis`, numbered by the two other axes u (slow) and v.
    const int lines_v = n[v];
    arena.for_each(std::int64_t(n[u]) * lines_v, 4096, [&](std::int64_t b, std::int64_t e) {
        for (; b < e; ++b) {
            std::uint8_t* line = mask.flags.data() +
                                 std::size_t(b / lines_v) * std::size_t(strides[u]) +
                                 std::size_t(b % lines_v) * std::size_t(strides[v]);
            const auto stride = std::size_t(strides[axis]);
            const int count = n[axis];
            for (int k = 0; k < count; ++k) {
                // Against the direction of the neighbour, so that it is still unchanged.
                const int at = step > 0 ? k : count - 1 - k;
                const int there = at + step;
                const std::uint8_t other =
                    there >= 0 && there < count ? line[std::size_t(there) * stride] : 0;
                line[std::size_t(at) * stride] = combine(line[std::size_t(at) * stride], other);
            }
        }
    });
}

Box3i bounding_box(const VoxelMask& mask, Box3i within) {
    Box3i box{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (int z = within.begin.z; z < within.end.z; ++z)
        for (int y = within.begin.y; y < within.end.y; ++y)
            for (int x = within.begin.x; x < within.end.x; ++x) {
                if (!mask.flags[mask.index({x, y, z})]) continue;
                box.begin = {std::min(box.begin.x, x), std::min(box.begin.y, y),
                             std::min(box.begin.z, z)};
                box.end = {std::max(box.end.x, x + 1), std::max(box.end.y, y + 1),
                           std::max(box.end.z, z + 1)};
            }
    return is_empty(box) ? Box3i{} : box;
}

}  // namespace

VoxelMask changeable_voxels(const Lattice& lattice, const TaskArena& arena) {
    const Box3i moved = moved_box(lattice);
    if (is_empty(moved)) return {};
    VoxelMask all = moved_elements(lattice, moved, arena);
    // Flag of a cell, kept at its lowest corner: any corner moved.
    for (int axis = 0; axis < 3; ++axis)
        combine_along(all, axis, +1, arena, [](auto a, auto b) { return a | b; });
    // Flag of a voxel: all eight cells around it.
    for (int axis = 0; axis < 3; ++axis)
        combine_along(all, axis, -1, arena, [](auto a, auto b) { return a & b; });
    const Box3i scan = voxel_box(lattice.grid());
    Box3i inside;
    for (int a = 0; a < 3; ++a) {
        inside.begin[a] = std::max(all.box.begin[a], scan.begin[a]);
        inside.end[a] = std::min(all.box.end[a], scan.end[a]);
    }
    VoxelMask mask = mask_of(bounding_box(all, inside));
    for (int z = mask.box.begin.z; z < mask.box.end.z; ++z)
        for (int y = mask.box.begin.y; y < mask.box.end.y; ++y)
            std::copy_n(all.flags.begin() + std::ptrdiff_t(all.index({mask.box.begin.x, y, z})),
                        extent(mask.box).x,
                        mask.flags.begin() + std::ptrdiff_t(mask.index({mask.box.begin.x, y, z})));
    return mask;
}

}  // namespace pliant
