// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Minimum and maximum of each brick of cells, on two levels. A cell lies between eight voxels, so a
// brick of 8³ cells covers 9³ voxels; the trilinear field inside of it stays within the range.
//
//   coarse brick, 64³ cells ─┬─ fine brick, 8³ cells ─┬─ cell ─ 8 voxels
//                            ├─ …                     ├─ …
//
// A ray only enters bricks whose range contains the threshold.

#pragma once

#include <pliant/core/tasks.h>

#include <cstddef>
#include <span>
#include <vector>

#include "render/voxel_field.h"
#include "volume/boxes.h"

namespace pliant::render {

inline constexpr int kFineCells = 8;
inline constexpr int kCoarseCells = 64;

template <class T>
struct Range {
    T min, max;
};

/// One level of bricks.
template <class T>
struct BrickLevel {
    Vec3i size{0, 0, 0};           ///< bricks along i, j, k
    std::vector<Range<T>> ranges;  ///< i fastest

    const Range<T>& at(Vec3i b) const { return ranges[dense_index(b, size)]; }
};

template <class T>
struct Bricks {
    Vec3i cells{0, 0, 0};
    BrickLevel<T> fine, coarse;
};

/// @returns bricks without cells if the field is thinner than two voxels
template <class T>
Bricks<T> make_bricks(const VoxelField<T>& field, const TaskArena& arena);

/// Updates the bricks that cover changed boxes of voxels. The result equals that of make_bricks.
/// @param boxes  inside the grid
/// @param[in,out] scratch  reused by updates to avoid allocations
template <class T>
void update_bricks(Bricks<T>& bricks, const VoxelField<T>& field, std::span<const Box3i> boxes,
                   std::vector<std::int32_t>& scratch, const TaskArena& arena);

extern template void update_bricks(Bricks<std::int16_t>&, const VoxelField<std::int16_t>&,
                                   std::span<const Box3i>, std::vector<std::int32_t>&,
                                   const TaskArena&);
extern template void update_bricks(Bricks<float>&, const VoxelField<float>&, std::span<const Box3i>,
                                   std::vector<std::int32_t>&, const TaskArena&);
extern template Bricks<std::int16_t> make_bricks(const VoxelField<std::int16_t>&, const TaskArena&);
extern template Bricks<float> make_bricks(const VoxelField<float>&, const TaskArena&);

}  // namespace pliant::render
