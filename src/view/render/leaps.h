// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Empty-space skipping for one threshold. A brick that contains the threshold is marked. Every
// other brick stores its side of the threshold, and the chessboard distance to the nearest marked
// brick. A ray can then leap over all nearer bricks at once:
//
//   2 2 2 2 2        in the middle brick of distance two, the ray
//   2 1 1 1 2        leaps to its exit from the surrounding
//   2 1 0 1 2        3 × 3 bricks (0: marked)
//
// One byte per brick of 8³ cells, computed from the bricks' ranges for each picture. That takes
// some tens of microseconds for a scan of 256³ voxels, so changes of the threshold are free.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/bricks.h"

namespace pliant::render {

/// The smallest value of the voxels' type that is ≥ iso: v ≥ threshold is equivalent to v ≥ iso.
/// @returns nullopt if all or no values are ≥ iso, so that there are no crossings
template <class T>
std::optional<T> threshold_of(double iso);

struct LeapMap {
    static constexpr std::uint8_t kAbove = 128;  ///< bit: values ≥ threshold
    static constexpr int kFarthest = 127;        ///< distances are clamped to this

    Vec3i size{0, 0, 0};  ///< bricks along i, j, k
    /// i fastest; 0: contains the threshold; otherwise the distance, with kAbove. Padded by four
    /// bytes, so that 32 bits can be read at each element.
    std::vector<std::uint8_t> codes;
};

template <class T>
LeapMap make_leap_map(const BrickLevel<T>& fine, T threshold);

extern template std::optional<std::int16_t> threshold_of(double);
extern template std::optional<float> threshold_of(double);
extern template LeapMap make_leap_map(const BrickLevel<std::int16_t>&, std::int16_t);
extern template LeapMap make_leap_map(const BrickLevel<float>&, float);

}  // namespace pliant::render
