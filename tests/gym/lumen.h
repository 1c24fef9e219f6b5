// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small lumen for endoscopes, and their random motion.

#pragma once

#include <gtest/gtest.h>
#include <pliant/data/gym.h>

#include <cmath>
#include <vector>

#include "support/random.h"

namespace pliant::test {

/// A tube of radius 6 mm along z through tissue, slightly bent, with bone on one side.
inline Volume bent_tube() {
    Volume volume;
    volume.grid = {.size = {36, 36, 40}, .spacing_mm = {0.9, 0.9, 1.1}, .origin_mm = {5, -3, 40}};
    std::vector<std::int16_t> voxels;
    for (int z = 0; z < 40; ++z)
        for (int y = 0; y < 36; ++y)
            for (int x = 0; x < 36; ++x) {
                const double r = 0.9 * std::hypot(x - 17.5 - 2 * std::sin(0.15 * z), y - 17.5);
                const double air = std::min(1.0, std::max(0.0, 0.5 * (6 - r) + 0.5));
                const double tissue = x < 6 ? 1200 : 40 + 20 * std::sin(0.7 * y);
                voxels.push_back(std::int16_t(std::lround(air * -1000 + (1 - air) * tissue)));
            }
    volume.voxels = voxels;
    return volume;
}

inline EndoscopePose start_in(const Volume& tube) {
    return {.eye_mm = world_from_voxel(tube.grid, {17.5, 17.5, 4}), .look = {0.1, 0, 1}};
}

/// Mostly ahead, in random turns.
inline std::vector<double> random_actions(Random& random, int count) {
    std::vector<double> actions;
    for (int n = 0; n < count; ++n) {
        const Vec3d turn = random.vector(2), more = random.vector(30);
        for (const double a : {8 + more.x, turn.x, turn.y, turn.z}) actions.push_back(a);
    }
    return actions;
}

template <class T>
inline std::vector<std::byte> bytes_of(std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    return {bytes.begin(), bytes.end()};
}

/// All pictures, and the hashes.
inline std::vector<std::byte> result_of_endoscopes(const EndoscopeArena& arena) {
    const EndoscopePictures p = arena.pictures();
    std::vector<std::byte> all;
    for (const auto& part : {bytes_of(p.colour), bytes_of(p.depth_mm), bytes_of(p.normals),
                             bytes_of(p.flow), bytes_of(p.visibility), bytes_of(p.scene_flow_mm)})
        all.insert(all.end(), part.begin(), part.end());
    for (int n = 0; n < arena.count(); ++n) {
        const std::uint64_t hash = arena.hash(n);
        const auto more = bytes_of(std::span<const std::uint64_t>(&hash, 1));
        all.insert(all.end(), more.begin(), more.end());
    }
    return all;
}

}  // namespace pliant::test
