// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "catheter/open_ends.h"

#include <algorithm>

#include "catheter/near_wall.h"
#include "vessel/wall.h"

namespace pliant::catheter {
namespace {

/// Number of the vessel's end nearest to an opening, from 1 on; without ends the opening's index.
std::int32_t number_of(const std::vector<VesselEnd>& ends, Vec3d hub, std::size_t opening) {
    if (ends.empty()) return std::int32_t(opening) + 1;
    const auto nearest =
        std::min_element(ends.begin(), ends.end(), [&](const auto& a, const auto& b) {
            return norm(a.centre_mm - hub) < norm(b.centre_mm - hub);
        });
    return std::int32_t(nearest - ends.begin()) + 1;
}

/// Six times the volume of a tetrahedron: positive if d is in front of a b c.
double side_of(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
    return dot(cross(b - a, c - a), d - a);
}

}  // namespace

Result<OpenEnds> OpenEnds::create(const VesselWall& wall) {
    const auto openings = vessel::openings_of(wall.ghost);
    if (!openings) return openings.error();
    OpenEnds ends;
    for (const auto& loop : *openings) {
        Lid lid{{}, {0, 0, 0}, 0, 0};
        // The ghost surface faces the lumen, and so do its lids.
        for (auto n = loop.rbegin(); n != loop.rend(); ++n)
            lid.rim.push_back(wall.ghost.nodes_mm[std::size_t(*n)]);
        for (const Vec3d& p : lid.rim)
            lid.hub = lid.hub + (1.0 / double(lid.rim.size())) * (p - lid.rim[0]);
        lid.hub = lid.hub + lid.rim[0];
        for (const Vec3d& p : lid.rim) lid.reach_mm = std::max(lid.reach_mm, norm(p - lid.hub));
        lid.end = number_of(wall.ends, lid.hub, ends.m_lids.size());
        ends.m_lids.push_back(std::move(lid));
    }
    return ends;
}

/// Number of outward crossings minus inward crossings.
int OpenEnds::crossings(const Lid& lid, Vec3d from, Vec3d to) {
    if (norm(0.5 * (from + to) - lid.hub) > lid.reach_mm + 0.5 * norm(to - from)) return 0;
    int out = 0;
    for (std::size_t n = 0; n < lid.rim.size(); ++n) {
        const Vec3d a = lid.hub, b = lid.rim[n], c = lid.rim[(n + 1) % lid.rim.size()];
        const bool front = side_of(a, b, c, to) > 0;
        if (front == (side_of(a, b, c, from) > 0)) continue;
        // The line passes all three edges of the triangle on the same side.
        const bool ab = side_of(from, to, a, b) > 0, bc = side_of(from, to, b, c) > 0,
                   ca = side_of(from, to, c, a) > 0;
        if (ab == bc && bc == ca) out += front ? 1 : -1;
    }
    return out;
}

void OpenEnds::follow(const Wire& wire) noexcept {
    m_is_beyond.assign(std::size_t(wire.segments()), 0);
    m_left = 0;
    int out = 0;
    for (std::int32_t s = wire.first(); s < wire.segments(); ++s) {
        const SegmentOutside segment = outside_of(wire, s);
        const int before = out;
        for (const Lid& lid : m_lids) {
            const int through = crossings(lid, segment.begin, segment.end);
            if (through > 0) m_left = lid.end;
            out = std::max(0, out + through);
        }
        m_is_beyond[std::size_t(s)] = before > 0 && out > 0;
    }
    if (out == 0) m_left = 0;
}

}  // namespace pliant::catheter
