// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Openings of a surface: unmatched sides of triangles, joined end to end.

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "vessel/wall.h"

namespace pliant::vessel {

Result<std::vector<std::vector<std::int32_t>>> openings_of(const TriangleMesh& surface) {
    std::map<std::pair<std::int32_t, std::int32_t>, int> sides;
    for (const auto& t : surface.cells)
        for (std::size_t n = 0; n < 3; ++n) ++sides[{t[n], t[(n + 1) % 3]}];
    std::map<std::int32_t, std::int32_t> next;
    for (const auto& [side, count] : sides) {
        if (sides.contains({side.second, side.first})) continue;
        if (!next.emplace(side.second, side.first).second)
            return wrong("two openings of the surface touch in node " +
                         std::to_string(side.second) + ", expected them apart");
    }
    std::vector<std::vector<std::int32_t>> openings;
    while (!next.empty()) {
        std::vector<std::int32_t> loop;
        for (auto at = next.begin(); at != next.end(); at = next.find(loop.back())) {
            loop.push_back(at->second);
            next.erase(at);
        }
        openings.push_back(std::move(loop));
    }
    return openings;
}

Result<TriangleMesh> with_lids(const TriangleMesh& surface) {
    const auto openings = openings_of(surface);
    if (!openings) return openings.error();
    TriangleMesh closed = surface;
    for (const auto& loop : *openings) {
        const auto hub = std::int32_t(closed.nodes_mm.size());
        const Vec3d origin = surface.nodes_mm[std::size_t(loop[0])];
        Vec3d middle{0, 0, 0};
        for (const std::int32_t n : loop)
            middle =
                middle + (1.0 / double(loop.size())) * (surface.nodes_mm[std::size_t(n)] - origin);
        closed.nodes_mm.push_back(origin + middle);
        for (std::size_t n = 0; n < loop.size(); ++n)
            closed.cells.push_back({hub, loop[n], loop[(n + 1) % loop.size()]});
    }
    return closed;
}

double enclosed_with_lids_mm3(const TriangleMesh& surface) {
    const auto closed = with_lids(surface);
    return closed && !surface.cells.empty() ? -enclosed_volume_mm3(*closed) : 0;
}

bool is_inside(const TriangleMesh& closed, Vec3d x) {
    double solid_angle = 0;
    for (const auto& t : closed.cells) {
        const Vec3d a = closed.nodes_mm[std::size_t(t[0])] - x,
                    b = closed.nodes_mm[std::size_t(t[1])] - x,
                    c = closed.nodes_mm[std::size_t(t[2])] - x;
        const double la = norm(a), lb = norm(b), lc = norm(c);
        solid_angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc +
                                                               dot(b, c) * la + dot(c, a) * lb);
    }
    return std::abs(solid_angle) > 2 * std::numbers::pi;
}

}  // namespace pliant::vessel
