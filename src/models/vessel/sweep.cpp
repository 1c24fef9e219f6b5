// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tube swept along a branch: rings at even steps, with rotation-minimising frames by the double
// reflection of [Wang2008], accurate to fourth order.

#include <pliant/models/vessel.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/errors.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

/// Paths from corner 0 to corner 6 of a hexahedron, as in tet_mesh: neighbours conform.
constexpr int kTetrahedra[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                   {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};

struct Ring {
    CentrePoint at;
    Vec3d along, across;
};

/// Resamples at even arc lengths; the ends are kept.
std::vector<CentrePoint> even_points(std::span<const CentrePoint> branch, double step_mm) {
    std::vector<double> length{0};
    for (std::size_t n = 1; n < branch.size(); ++n)
        length.push_back(length.back() + norm(branch[n].position_mm - branch[n - 1].position_mm));
    const auto count = std::max<std::size_t>(1, std::size_t(std::llround(length.back() / step_mm)));
    std::vector<CentrePoint> points;
    std::size_t at = 0;
    for (std::size_t n = 0; n <= count; ++n) {
        const double l = length.back() * double(n) / double(count);
        while (at + 2 < branch.size() && length[at + 1] < l) ++at;
        const double span = length[at + 1] - length[at];
        const double t = span > 0 ? std::clamp((l - length[at]) / span, 0.0, 1.0) : 0;
        const CentrePoint &a = branch[at], &b = branch[at + 1];
        points.push_back({a.position_mm + t * (b.position_mm - a.position_mm),
                          a.radius_mm + t * (b.radius_mm - a.radius_mm)});
    }
    return points;
}

std::vector<Ring> rings_of(const std::vector<CentrePoint>& points) {
    std::vector<Ring> rings;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Vec3d before = points[n == 0 ? 0 : n - 1].position_mm;
        const Vec3d after = points[std::min(n + 1, points.size() - 1)].position_mm;
        rings.push_back({points[n], normalized(after - before), {0, 0, 0}});
    }
    const Vec3d first = rings[0].along;
    const int least =
        std::abs(first.x) <= std::abs(first.y) && std::abs(first.x) <= std::abs(first.z) ? 0
        : std::abs(first.y) <= std::abs(first.z)                                         ? 1
                                                                                         : 2;
    Vec3d axis{0, 0, 0};
    axis[least] = 1;
    rings[0].across = normalized(axis - dot(axis, first) * first);
    for (std::size_t n = 1; n < rings.size(); ++n) {
        const auto reflect = [](Vec3d v, Vec3d mirror) {
            return v - (2 * dot(mirror, v) / dot(mirror, mirror)) * mirror;
        };
        const Vec3d step = rings[n].at.position_mm - rings[n - 1].at.position_mm;
        const Vec3d across = reflect(rings[n - 1].across, step);
        const Vec3d along = reflect(rings[n - 1].along, step);
        const Vec3d second = rings[n].along - along;
        const Vec3d turned = dot(second, second) > 1e-24 ? reflect(across, second) : across;
        rings[n].across = normalized(turned - dot(turned, rings[n].along) * rings[n].along);
    }
    return rings;
}

Status check(std::span<const CentrePoint> branch, const TubeSettings& s) {
    if (!(s.thickness_mm > 0) || !std::isfinite(s.thickness_mm))
        return vessel::wrong("thickness_mm is " + std::to_string(s.thickness_mm) +
                             ", expected a length above 0");
    if (!(s.ring_mm >= 0) || !std::isfinite(s.ring_mm))
        return vessel::wrong("ring_mm is " + std::to_string(s.ring_mm) +
                             ", expected a length above 0");
    if (s.layers < 1 || s.layers > 64)
        return vessel::wrong("layers is " + std::to_string(s.layers) + ", expected 1 to 64");
    if (s.sectors < 3 || s.sectors > 4096)
        return vessel::wrong("sectors is " + std::to_string(s.sectors) + ", expected 3 to 4096");
    if (branch.size() < 2)
        return vessel::wrong("the branch has " + std::to_string(branch.size()) +
                             " points, expected 2 or more");
    for (std::size_t n = 0; n < branch.size(); ++n)
        if (!is_finite(branch[n].position_mm) || !(branch[n].radius_mm > 0) ||
            !std::isfinite(branch[n].radius_mm))
            return vessel::wrong("point " + std::to_string(n) +
                                 " has no finite position or no radius above 0");
    return Ok{};
}

Result<VesselWall> sweep_tube(std::span<const CentrePoint> branch, const TubeSettings& settings) {
    if (const Status s = check(branch, settings); !s) return s.error();
    double length = 0, mean_radius = 0;
    for (const CentrePoint& p : branch) mean_radius += p.radius_mm / double(branch.size());
    for (std::size_t n = 1; n < branch.size(); ++n)
        length += norm(branch[n].position_mm - branch[n - 1].position_mm);
    if (!(length > 0)) return vessel::wrong("the branch has no length");
    const double step = settings.ring_mm > 0
                            ? settings.ring_mm
                            : 2 * std::numbers::pi * mean_radius / settings.sectors;
    const int around = settings.sectors, layers = settings.layers;
    if (length / step * around * (layers + 1) > 1e8)
        return Error{ErrorCode::LimitExceeded,
                     "vessel wall: a tube of more than 100000000 nodes, expected fewer"};
    const auto rings = rings_of(even_points(branch, step));

    VesselWall wall;
    const auto node = [&](std::size_t ring, int sector, int layer) {
        return std::int32_t((std::int64_t(ring) * around + sector % around) * (layers + 1) + layer);
    };
    for (const Ring& r : rings)
        for (int s = 0; s < around; ++s) {
            const double angle = 2 * std::numbers::pi * s / around;
            const Vec3d out =
                std::cos(angle) * r.across + std::sin(angle) * cross(r.along, r.across);
            for (int l = 0; l <= layers; ++l)
                wall.mesh.nodes_mm.push_back(
                    r.at.position_mm + (r.at.radius_mm + settings.thickness_mm * l / layers) * out);
        }
    std::vector<std::array<std::int32_t, 3>> inner;
    for (std::size_t r = 0; r + 1 < rings.size(); ++r)
        for (int s = 0; s < around; ++s) {
            for (int l = 0; l < layers; ++l) {
                // outwards, around, along: right-handed
                const std::int32_t at[8] = {node(r, s, l),
                                            node(r, s, l + 1),
                                            node(r, s + 1, l + 1),
                                            node(r, s + 1, l),
                                            node(r + 1, s, l),
                                            node(r + 1, s, l + 1),
                                            node(r + 1, s + 1, l + 1),
                                            node(r + 1, s + 1, l)};
                for (const auto& t : kTetrahedra)
                    wall.mesh.cells.push_back({at[t[0]], at[t[1]], at[t[2]], at[t[3]]});
            }
            // Same diagonal as in the tetrahedra, from corner 0 to corner 7.
            inner.push_back({node(r, s, 0), node(r + 1, s, 0), node(r + 1, s + 1, 0)});
            inner.push_back({node(r, s, 0), node(r + 1, s + 1, 0), node(r, s + 1, 0)});
        }
    for (std::size_t c = 0; c < wall.mesh.cells.size(); ++c) {
        const auto p = [&](std::size_t n) {
            return wall.mesh.nodes_mm[std::size_t(wall.mesh.cells[c][n])];
        };
        if (dot(p(1) - p(0), cross(p(2) - p(0), p(3) - p(0))) > 0) continue;
        const auto ring = c / (6 * std::size_t(layers) * std::size_t(around));
        return vessel::wrong("the centreline bends too sharply for its radius " +
                             std::to_string(length * double(ring) / double(rings.size() - 1)) +
                             " mm behind its start, expected a bend wider than the tube");
    }
    std::vector<std::int32_t> nodes;
    wall.ghost = part_of(wall.mesh.nodes_mm, inner, &nodes);
    // Each ghost node coincides with a node of some tetrahedron.
    std::vector<std::int32_t> owner(wall.mesh.nodes_mm.size(), -1);
    for (std::size_t c = wall.mesh.cells.size(); c-- > 0;)
        for (const std::int32_t n : wall.mesh.cells[c]) owner[std::size_t(n)] = std::int32_t(c);
    for (const std::int32_t n : nodes) {
        Embedded e{owner[std::size_t(n)], {}};
        for (std::size_t k = 0; k < 4; ++k)
            e.weights[k] = wall.mesh.cells[std::size_t(e.tetrahedron)][k] == n;
        wall.ghost_positions.push_back(e);
    }
    const Ring &first = rings.front(), &last = rings.back();
    wall.ends = {{first.at.position_mm, -first.along, first.at.radius_mm},
                 {last.at.position_mm, last.along, last.at.radius_mm}};
    wall.min_layers = layers;
    wall.lumen_mm3 = vessel::enclosed_with_lids_mm3(wall.ghost);
    return wall;
}

}  // namespace

Result<VesselWall> swept_tube(std::span<const CentrePoint> branch,
                              const TubeSettings& settings) noexcept {
    return attempt([&] { return sweep_tube(branch, settings); });
}

}  // namespace pliant
