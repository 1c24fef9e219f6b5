// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptics/walls.h"

#include <algorithm>

namespace pliant {
namespace {

constexpr double kBump_mm = 0.5;  ///< a plane that would cut off other walls by more is discarded
constexpr double kTouch_mm = 1e-9;

/// The directions of a cube's faces, edges and corners.
std::vector<Vec3d> directions() {
    std::vector<Vec3d> all;
    for (int n = 0; n < 27; ++n)
        if (n != 13) all.push_back(normalized(Vec3d{n % 3 - 1., n / 3 % 3 - 1., n / 9 - 1.}));
    return all;
}

}  // namespace

Walls::Walls(const Volume& volume, const TaskArena& arena)
    : m_caster(volume, arena), m_rays(directions()), m_distances(m_rays.size()) {}

/// Hits, the nearest first.
std::vector<RayHit> Walls::hits(const ChainMailFeelSettings& s, Vec3d position_mm) {
    std::vector<RayHit> walls;
    const double within = s.reach_mm + s.tool_radius_mm;
    if (const auto nearest = m_caster.nearest_surface(position_mm, within, s.iso_hu, s.polarity))
        walls.push_back(*nearest);
    else
        return walls;
    m_caster.first_hits(position_mm, m_rays, s.iso_hu, s.polarity, m_distances);
    std::vector<RayHit> others;
    for (std::size_t r = 0; r < m_rays.size(); ++r)
        if (m_distances[r] < within)
            if (const auto hit = m_caster.first_hit(position_mm, m_rays[r], s.iso_hu, s.polarity))
                others.push_back(*hit);
    std::stable_sort(others.begin(), others.end(), [](const RayHit& a, const RayHit& b) {
        return a.distance_mm < b.distance_mm;
    });
    walls.insert(walls.end(), others.begin(), others.end());
    return walls;
}

HapticModel Walls::around(const ChainMailFeelSettings& settings, Vec3d proxy_mm) {
    HapticModel model;
    const std::vector<RayHit> walls = hits(settings, proxy_mm);
    for (const RayHit& wall : walls) {
        if (model.plane_count == HapticModel::kMaxPlanes) break;
        const HapticPlane plane{wall.point_mm + settings.tool_radius_mm * wall.normal, wall.normal};
        const bool is_nearest = &wall == &walls.front();
        const auto is_cut_off = [&](const RayHit& other) {
            return dot(wall.normal, other.point_mm - wall.point_mm) < -kBump_mm;
        };
        if (!is_nearest && (dot(plane.normal, proxy_mm - plane.point_mm) < 0 ||
                            std::any_of(walls.begin(), walls.end(), is_cut_off)))
            continue;
        model.planes[model.plane_count++] = plane;
    }
    if (model.plane_count > 0) model.friction = settings.friction;
    return model;
}

WallContact Walls::contact(const HapticModel& planes, Vec3d tool_mm, double radius_mm) {
    WallContact contact;
    contact.entry_mm = nearest_free_position(planes, tool_mm);
    const double depth = norm(contact.entry_mm - tool_mm);
    if (depth > kTouch_mm) {
        contact.depth_mm = depth;
        contact.normal = (1 / depth) * (contact.entry_mm - tool_mm);
        contact.surface_mm = contact.entry_mm - radius_mm * contact.normal;
    } else {
        // Before contact, the nearest wall is the candidate.
        contact.normal = planes.planes[0].normal;
        contact.surface_mm = planes.planes[0].point_mm - radius_mm * contact.normal;
    }
    return contact;
}

}  // namespace pliant
