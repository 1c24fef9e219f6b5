// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes of tetrahedra from a function for positions, without copies.

#pragma once

#include <algorithm>
#include <cmath>

#include "pbd/solver.h"

namespace pliant::pbd {

/// @param position  position of a particle
template <class Position>
double volume_at(const std::array<std::int32_t, 4>& nodes, const Position& position) {
    const Vec3d corners[] = {position(nodes[0]), position(nodes[1]), position(nodes[2]),
                             position(nodes[3])};
    return tetrahedron_volume({0, 1, 2, 3}, corners);
}

template <class Position>
VolumeChange volume_change_of(const PbdParts& parts, const Position& position) {
    VolumeChange change;
    double rest_sum = 0, sum = 0, count = 0;
    const auto add = [&](const std::array<std::int32_t, 4>& nodes, double rest) {
        const double now = volume_at(nodes, position);
        const double relative = std::abs(now - rest) / rest;
        rest_sum += rest;
        sum += now;
        count += 1;
        change.mean += relative;
        change.largest = std::max(change.largest, relative);
    };
    for (const PbdVolume& v : parts.volumes) add(v.nodes, rest_volume(parts, v));
    for (const PbdSolid& s : parts.solids)
        add(s.nodes, tetrahedron_volume(s.nodes, parts.positions));
    if (count == 0) return change;
    change.total = sum / rest_sum - 1;
    change.mean /= count;
    return change;
}

}  // namespace pliant::pbd
