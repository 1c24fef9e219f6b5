// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// For one threshold: how far a ray may leap from each fine brick. A brick that holds the threshold
// is marked; any other says on which side of it it lies, and how many bricks away, in the maximum
// norm, the nearest marked one is. A ray may then pass all bricks that are nearer at once:
//
//   2 2 2 2 2        from the brick in the middle, two bricks away from the marked one (0),
//   2 1 1 1 2        the ray goes straight to where it leaves the 3 × 3 bricks around
//   2 1 0 1 2
//
// One byte per brick of 8³ cells. It is made from the bricks' ranges for each picture: some tens of
// microseconds for a scan of 256³ voxels, so a change of the threshold costs nothing that is felt.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/bricks.h"

namespace pliant::render {

/// The least value of the voxels' type that is ≥ iso: v ≥ threshold is v ≥ iso, exactly.
/// @returns nothing if all or no values are, so that there is nothing to cross
template <class T>
std::optional<T> threshold_of(double iso);

struct LeapMap {
    static constexpr std::uint8_t kAbove = 128;  ///< bit: values ≥ threshold
    static constexpr int kFarthest = 127;        ///< distances end here

    Vec3i size{0, 0, 0};  ///< bricks along i, j, k
    /// i fastest; 0: holds the threshold; else the distance, with kAbove. Four bytes more, so that
    /// 32 bits can be read at each.
    std::vector<std::uint8_t> codes;
};

template <class T>
LeapMap make_leap_map(const BrickLevel<T>& fine, T threshold);

extern template std::optional<std::int16_t> threshold_of(double);
extern template std::optional<float> threshold_of(double);
extern template LeapMap make_leap_map(const BrickLevel<std::int16_t>&, std::int16_t);
extern template LeapMap make_leap_map(const BrickLevel<float>&, float);

}  // namespace pliant::render
