// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Openings of a surface: sides of triangles that no other triangle runs along the other way, joined
// end to end.

#include <map>
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

double enclosed_with_lids_mm3(const TriangleMesh& surface) {
    double volume = enclosed_volume_mm3(surface);
    const auto openings = openings_of(surface);
    if (!openings || surface.nodes_mm.empty()) return 0;
    const Vec3d origin = surface.nodes_mm[0];
    for (const auto& loop : *openings) {
        const auto place = [&](std::size_t n) {
            return surface.nodes_mm[std::size_t(loop[n % loop.size()])] - origin;
        };
        Vec3d middle{0, 0, 0};
        for (std::size_t n = 0; n < loop.size(); ++n)
            middle = middle + (1.0 / double(loop.size())) * place(n);
        for (std::size_t n = 0; n < loop.size(); ++n)
            volume += dot(middle, cross(place(n), place(n + 1))) / 6;
    }
    return -volume;
}

}  // namespace pliant::vessel
