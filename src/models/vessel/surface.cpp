// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A surface as a lumen: oriented outwards, its openings closed with lids so that it has an inside,
// and the wall cut off at the lids.

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "mesh/box_tree.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

VesselEnd end_of(const TriangleMesh& surface, const std::vector<std::int32_t>& loop, Vec3d middle) {
    const auto position = [&](std::size_t n) {
        return surface.nodes_mm[std::size_t(loop[n % loop.size()])];
    };
    Vec3d area{0, 0, 0};
    double longest = 0;
    for (std::size_t n = 0; n < loop.size(); ++n) {
        area = area + 0.5 * cross(position(n) - middle, position(n + 1) - middle);
        longest = std::max(longest, norm(position(n) - middle));
    }
    VesselEnd end{middle, {0, 0, 1}, longest};
    if (norm(area) > 0) end.outward = normalized(area);
    // Openings are seldom flat: the cut is placed where the surface is still complete.
    double deepest = 0;
    for (std::size_t n = 0; n < loop.size(); ++n)
        deepest = std::min(deepest, dot(position(n) - middle, end.outward));
    end.centre_mm = middle + deepest * end.outward;
    return end;
}

/// Closes openings by fans to their middles. @param[out] ends  one for each
Status close_openings(TriangleMesh& surface, std::vector<VesselEnd>& ends) {
    const auto openings = vessel::openings_of(surface);
    if (!openings) return openings.error();
    for (const auto& loop : *openings) {
        Vec3d middle{0, 0, 0};
        for (const std::int32_t n : loop) middle = middle + surface.nodes_mm[std::size_t(n)];
        middle = (1.0 / double(loop.size())) * middle;
        ends.push_back(end_of(surface, loop, middle));
        const auto centre = std::int32_t(surface.nodes_mm.size());
        surface.nodes_mm.push_back(middle);
        for (std::size_t n = 0; n < loop.size(); ++n)
            surface.cells.push_back({loop[n], loop[(n + 1) % loop.size()], centre});
    }
    return Ok{};
}

Result<VesselWall> wall_around_lumen(TriangleMesh surface, std::span<const VesselEnd> ends,
                                     const WallSettings& settings, const TaskArena& arena) {
    if (const Status cells = check_cells(surface); !cells) return cells.error();
    const SurfaceTopology topology = surface_topology(surface);
    if (topology.non_manifold_edges || topology.disagreeing_edges || topology.pinched_nodes)
        return vessel::wrong("the surface has " +
                             std::to_string(topology.non_manifold_edges +
                                            topology.disagreeing_edges + topology.pinched_nodes) +
                             " edges and nodes where it branches, touches itself or changes its "
                             "side, expected a manifold");
    vessel::LumenShape lumen;
    lumen.ends.assign(ends.begin(), ends.end());
    for (std::size_t e = 0; e < lumen.ends.size(); ++e) {
        const VesselEnd& end = lumen.ends[e];
        if (!is_finite(end.centre_mm) || !is_finite(end.outward) || !(end.radius_mm > 0) ||
            !(std::abs(norm(end.outward) - 1) < 1e-6))
            return vessel::wrong("end " + std::to_string(e) +
                                 " has no unit direction or no radius above 0");
    }
    if (vessel::enclosed_with_lids_mm3(surface) > 0)  // it faces the lumen
        for (auto& t : surface.cells) std::swap(t[1], t[2]);
    if (const Status closed = close_openings(surface, lumen.ends); !closed) return closed.error();
    mesh::Bounds all;
    for (const Vec3d& p : surface.nodes_mm) all.add(p);
    lumen.begin_mm = all.low;
    lumen.end_mm = all.high;
    const auto distance = SurfaceDistance::create(std::move(surface));
    if (!distance) return distance.error();
    lumen.distance_mm = [&](Vec3d x) { return distance->signed_mm(x); };
    return vessel::make_wall(lumen, settings, arena);
}

}  // namespace

Result<VesselWall> wall_around_surface(TriangleMesh lumen, std::span<const VesselEnd> ends,
                                       const WallSettings& settings,
                                       const TaskArena& arena) noexcept {
    return attempt([&] { return wall_around_lumen(std::move(lumen), ends, settings, arena); });
}

}  // namespace pliant
