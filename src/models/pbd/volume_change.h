// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes of tetrahedra from a function for positions, without copies.

#pragma once

#include <algorithm>
#include <cmath>

#include "pbd/solver.h"

namespace pliant::pbd {

/// @param place  position of a particle
template <class Place>
double volume_at(const std::array<std::int32_t, 4>& nodes, const Place& place) {
    const Vec3d corners[] = {place(nodes[0]), place(nodes[1]), place(nodes[2]), place(nodes[3])};
    return tetrahedron_volume({0, 1, 2, 3}, corners);
}

template <class Place>
VolumeChange volume_change_of(const PbdParts& parts, const Place& place) {
    VolumeChange change;
    double rest_sum = 0, sum = 0, count = 0;
    const auto add = [&](const std::array<std::int32_t, 4>& nodes, double rest) {
        const double now = volume_at(nodes, place);
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
