// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Depth of a catheter beyond its vessel's wall by the search of the mesh room, which knows nothing
// of contact.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/catheter.h>

#include <algorithm>
#include <utility>

#include "support/made.h"
#include "vessel/wall.h"

namespace pliant::test {

/// How far the wire's surface is beyond the ghost surface as it is now, closed with lids. Points in
/// the guide, and points nearest to a lid, don't count.
inline double depth_beyond_wall(const CatheterScene& scene) {
    const TriangleMesh now{scene.ghost_positions(), scene.wall().ghost.cells};
    TriangleMesh closed = made(vessel::with_lids(now));
    for (auto& t : closed.cells) std::swap(t[1], t[2]);  // the ghost surface faces the lumen
    const SurfaceDistance lumen = made(SurfaceDistance::create(std::move(closed)));
    const CatheterEntry& entry = scene.settings().entry;
    const auto x = scene.wire_positions();
    const auto first = std::size_t(scene.first_inserted());
    double most = -1e9;
    for (std::size_t s = first; s + 1 < x.size(); ++s)
        for (int k = 1; k <= 4; ++k) {
            const Vec3d p = (1 - k / 4.0) * x[s] + (k / 4.0) * x[s + 1];
            if (s == first && dot(p - entry.position_mm, entry.direction) < 0) continue;
            const auto nearest = lumen.nearest(p);
            if (nearest.triangle >= std::int32_t(now.cells.size())) continue;
            most = std::max(most, scene.settings().catheter.radius_mm + nearest.distance_mm);
        }
    return most;
}

}  // namespace pliant::test
