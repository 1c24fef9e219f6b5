// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fast marching runs twice from the one end to the other, and the path is traced back
// (docs/method/lumen_path.md). The first run is slowed down only right beside walls: it
// finds the shortest route. A cost that attracts the path to wide regions would instead leave a
// bronchus through a hole in its wall, which scans have, and cross the lung. The second run has
// this cost, but is confined to the route's neighbourhood.

#include <pliant/render.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/errors.h"
#include "base/text.h"
#include "path/descent.h"
#include "path/march.h"
#include "render/voxel_field.h"
#include "volume/value_unit.h"

namespace pliant {
namespace {

constexpr int kPower = 2;          // exponent of 1 / distance to the wall
constexpr int kRouteVoxels = 2;    // walls farther away don't affect the route
constexpr int kCentreVoxels = 32;  // walls farther away don't affect the centring
constexpr int kCentreRounds = 8;   // maximum
constexpr double kWorthIt = 1.01;  // relative growth of the clearance that justifies another round
constexpr int kSmoothRounds = 12;  // in steps of half a voxel: a width of some 1.2 voxels
constexpr double kTellWithinMm = 30;  // search radius around an end in the tissue, for the message

struct NearVoxel {
    Vec3i voxel;
    double distance_mm;
};

/// Lumen voxel nearest to a position in voxel space.
std::optional<NearVoxel> nearest_lumen(const Volume& volume, const render::LumenSide& lumen,
                                       Vec3d position, double within_mm) {
    const Vec3d s = volume.grid.spacing_mm;
    std::optional<NearVoxel> best;
    Vec3i begin, end;
    for (int a = 0; a < 3; ++a) {
        const double last = volume.grid.size[a] - 1;
        begin[a] = int(std::ceil(std::clamp(position[a] - within_mm / s[a], 0.0, last)));
        end[a] = int(std::floor(std::clamp(position[a] + within_mm / s[a], 0.0, last))) + 1;
    }
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x) {
                const Vec3d d{(x - position.x) * s.x, (y - position.y) * s.y,
                              (z - position.z) * s.z};
                const double distance = norm(d);
                if (distance > within_mm || (best && distance >= best->distance_mm) ||
                    !lumen.contains(double(volume.at({x, y, z}))))
                    continue;
                best = NearVoxel{{x, y, z}, distance};
            }
    return best;
}

/// Moves one end of the path into the lumen, in voxel space.
Result<Vec3d> place_end(const render::LumenTiles& tiles, const std::string& name, Vec3d point_mm,
                        double reach_mm) {
    const Volume& volume = tiles.volume();
    if (!is_finite(point_mm))
        return about(name, ErrorCode::InvalidArgument, "expected finite numbers");
    Vec3d position = voxel_from_world(volume.grid, point_mm);
    for (int a = 0; a < 3; ++a) {
        const double last = volume.grid.size[a] - 1;
        if (!(position[a] >= -0.5 && position[a] <= last + 0.5))
            return about(name, ErrorCode::InvalidArgument,
                         "expected a position in the scan, found " + short_text(point_mm));
        position[a] = std::clamp(position[a], 0.0, last);
    }
    if (!render::clear_corners(tiles, position).empty()) return position;
    const auto near =
        nearest_lumen(volume, tiles.lumen(), position, std::max(kTellWithinMm, reach_mm));
    if (near && near->distance_mm <= reach_mm) {
        const Vec3d at{double(near->voxel.x), double(near->voxel.y), double(near->voxel.z)};
        // Beside a NaN voxel, a lumen voxel has no clear corner.
        if (render::clear_corners(tiles, at).empty())
            return about(
                name, ErrorCode::InvalidArgument,
                "expected a position among finite voxel values, found " + short_text(point_mm));
        return at;
    }
    const std::string how_far = near ? short_text(near->distance_mm) + " mm from the nearest lumen"
                                     : "with no lumen within " + short_text(kTellWithinMm) + " mm";
    return about(name, ErrorCode::InvalidArgument,
                 "expected a position in the lumen, found " + short_text(point_mm) +
                     " in the tissue, " + how_far + " at " + short_text(tiles.lumen().iso_hu) +
                     value_unit(tiles.volume()));
}

/// Removes points as far as the lumen and the spacing allow.
std::vector<Vec3d> thinned(const render::LumenTiles& tiles, const std::vector<Vec3d>& points,
                           double spacing_mm) {
    const Grid& grid = tiles.volume().grid;
    const auto apart = [&](Vec3d a, Vec3d b) {
        return norm(world_from_voxel(grid, b) - world_from_voxel(grid, a));
    };
    std::vector<Vec3d> kept{points.front()};
    for (std::size_t at = 0; at + 1 < points.size();) {
        std::size_t next = at + 1;
        double way = apart(points[at], points[next]);
        for (std::size_t n = next + 1; n < points.size(); ++n) {
            way += apart(points[n - 1], points[n]);
            if (way > spacing_mm) break;
            if (render::is_clear(tiles, points[at], points[n])) next = n;
        }
        kept.push_back(points[next]);
        at = next;
    }
    return kept;
}

/// Distance to the nearest crossing of the wall between neighbours, by exhaustive search of nearby
/// voxels.
/// @param at_least, at_most  known bounds of it [mm]
double wall_distance_at(const Volume& volume, const render::LumenSide& lumen, Vec3d position,
                        double at_least, double at_most) {
    const Vec3d s = volume.grid.spacing_mm;
    Vec3i begin, end;
    for (int a = 0; a < 3; ++a) {
        const double last = volume.grid.size[a] - 1;
        begin[a] = int(std::clamp(position[a] - at_most / s[a], 0.0, last));
        end[a] = int(std::ceil(std::clamp(position[a] + at_most / s[a], 0.0, last))) + 1;
    }
    double nearest = at_most;
    const double longest = std::max({s.x, s.y, s.z});
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x) {
                const Vec3i p{x, y, z};
                const Vec3d off{(x - position.x) * s.x, (y - position.y) * s.y,
                                (z - position.z) * s.z};
                const double far = norm(off);
                if (far + longest < at_least || far - longest > nearest) continue;
                const double v = double(volume.at(p));
                for (int a = 0; a < 3; ++a) {
                    Vec3i q = p;
                    if (++q[a] >= end[a]) continue;
                    const double w = double(volume.at(q));
                    if (lumen.contains(v) == lumen.contains(w)) continue;
                    Vec3d d = off;
                    d[a] += (lumen.iso_hu - v) / (w - v) * s[a];
                    nearest = std::min(nearest, norm(d));
                }
            }
    return nearest;
}

LumenPath path_along(render::LumenTiles& tiles, const std::vector<Vec3d>& points) {
    const Grid& grid = tiles.volume().grid;
    LumenPath path;
    for (const Vec3d& p : points) {
        const Vec3i near{int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))};
        const Vec3d at{double(near.x), double(near.y), double(near.z)};
        const Vec3d x = world_from_voxel(grid, p);
        const double off = norm(world_from_voxel(grid, at) - x);
        // A lumen voxel stores the distance to the wall; a tissue voxel is beyond it.
        path.radius_mm.push_back(wall_distance_at(tiles.volume(), tiles.lumen(), p,
                                                  tiles.wall_mm(near) - off,
                                                  tiles.wall_mm(near) + off));
        path.points_mm.push_back(x);
        if (path.points_mm.size() > 1) path.length_mm += norm(x - path.points_mm.end()[-2]);
    }
    return path;
}

void seed(render::March& march, render::LumenTiles& tiles, Vec3d position) {
    const Vec3d s = tiles.volume().grid.spacing_mm;
    for (const Vec3i& voxel : render::clear_corners(tiles, position)) {
        const Vec3d d{(voxel.x - position.x) * s.x, (voxel.y - position.y) * s.y,
                      (voxel.z - position.z) * s.z};
        if (tiles.tile_of(voxel)) march.seed(voxel, norm(d) * march.cost(tiles.wall_mm(voxel)));
    }
}

/// Finds the shortest path that keeps some distance from the walls if possible.
Result<std::vector<Vec3d>> find_route(render::LumenTiles& tiles, Vec3d from, Vec3d to,
                                      const LumenPathSettings& settings) {
    render::March march(tiles, kPower);
    const auto goals = render::clear_corners(tiles, from);
    march.aim_at(goals.front(), march.cost(tiles.far_mm()));
    seed(march, tiles, to);
    const auto end = march.run(goals, settings.give_up);
    const auto limit = [](const std::string& what) {
        return about("to", ErrorCode::LimitExceeded, "the way is not found " + what);
    };
    if (tiles.is_full() || end == render::MarchEnd::Full)
        return limit("among the " + std::to_string(settings.max_voxels) +
                     " voxels that may be looked at; expected ends nearer to each other, or a "
                     "threshold at which the lumen is closed in");
    if (end == render::MarchEnd::GivenUp) return limit("in the time that it may take");
    const bool came = std::any_of(goals.begin(), goals.end(),
                                  [&](Vec3i goal) { return std::isfinite(tiles.arrival(goal)); });
    auto points = came ? render::descend(tiles, from, to) : std::vector<Vec3d>{};
    if (points.empty())
        return about("to", ErrorCode::NotFound,
                     "expected a position in the lumen of the other end, found no way at " +
                         short_text(settings.iso_hu) + value_unit(tiles.volume()));
    return points;
}

/// Lower bound of the distance to the wall at a position, from the voxels around it.
double room_at(render::LumenTiles& tiles, Vec3d position) {
    const Vec3d s = tiles.volume().grid.spacing_mm;
    double room = 0;
    for (int n = 0; n < 8; ++n) {
        const Vec3i q{int(std::floor(position.x)) + (n & 1),
                      int(std::floor(position.y)) + (n >> 1 & 1),
                      int(std::floor(position.z)) + (n >> 2 & 1)};
        if (!tiles.is_inside(q)) continue;
        const Vec3d d{(q.x - position.x) * s.x, (q.y - position.y) * s.y, (q.z - position.z) * s.z};
        room = std::max(room, tiles.wall_mm(q) - norm(d));
    }
    return room;
}

void open_ball(render::LumenTiles& tiles, Vec3d position, double radius_mm) {
    const Grid& grid = tiles.volume().grid;
    Vec3i begin, end;
    for (int a = 0; a < 3; ++a) {
        const double voxels = radius_mm / grid.spacing_mm[a], last = grid.size[a] - 1;
        begin[a] = int(std::ceil(std::clamp(position[a] - voxels, 0.0, last)));
        end[a] = int(std::floor(std::clamp(position[a] + voxels, 0.0, last))) + 1;
    }
    const Vec3d s = grid.spacing_mm;
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x)
                if (norm({(x - position.x) * s.x, (y - position.y) * s.y,
                          (z - position.z) * s.z}) <= radius_mm)
                    tiles.open({x, y, z});
}

/// Opens the largest balls in the lumen around a path's points, and small ones in between, so that
/// the whole path is open. @returns mean of their radii
double open_around(render::LumenTiles& tiles, const std::vector<Vec3d>& points) {
    const Vec3d s = tiles.volume().grid.spacing_mm;
    const double least = 1.5 * std::max({s.x, s.y, s.z});
    tiles.close();
    double sum = 0, since = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < points.size(); ++n) {
        const double room = room_at(tiles, points[n]);
        sum += room;
        if (n > 0) {
            const Vec3d d = points[n] - points[n - 1];
            since += norm({d.x * s.x, d.y * s.y, d.z * s.z});
        }
        // Balls that overlap almost completely would open no new voxels.
        if (room > least && since < 0.2 * room) {
            open_ball(tiles, points[n], least);
            continue;
        }
        since = 0;
        open_ball(tiles, points[n], std::max(room, least));
    }
    return sum / double(points.size());
}

/// Centres a path: the front marches again, fast far from walls, within balls around the path, and
/// repeats until the clearance no longer grows. Balls in the lumen don't reach through holes in its
/// wall.
void centre(render::LumenTiles& tiles, const LumenPathSettings& settings,
            std::vector<Vec3d>& points) {
    double room = 0;
    for (int round = 0; round < kCentreRounds; ++round) {
        const double now = open_around(tiles, points);
        if (tiles.is_full() || !(now > kWorthIt * room)) return;
        room = now;
        render::March march(tiles, kPower);
        const Vec3d from = points.front(), to = points.back();
        seed(march, tiles, to);
        if (march.run(render::clear_corners(tiles, from), settings.give_up) ==
            render::MarchEnd::GivenUp)
            return;
        auto next = render::descend(tiles, from, to);
        if (next.empty()) return;
        points = std::move(next);
    }
}

}  // namespace

Result<LumenPath> find_lumen_path(const Volume& volume, Vec3d from_mm, Vec3d to_mm,
                                  const LumenPathSettings& settings, const TaskArena& arena) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (!std::isfinite(settings.iso_hu))
        return about("iso", ErrorCode::InvalidArgument, "expected a finite number");
    if (!(settings.spacing_mm > 0))
        return about("spacing", ErrorCode::InvalidArgument, "expected a length > 0");
    const render::LumenSide lumen{settings.iso_hu, settings.polarity};
    render::LumenTiles route_tiles(volume, lumen, kRouteVoxels, settings.max_voxels, arena);
    const auto from = place_end(route_tiles, "from", from_mm, settings.reach_mm);
    if (!from) return from.error();
    const auto to = place_end(route_tiles, "to", to_mm, settings.reach_mm);
    if (!to) return to.error();
    auto route = find_route(route_tiles, *from, *to, settings);
    if (!route) return route.error();
    render::LumenTiles tiles(volume, lumen, kCentreVoxels, settings.max_voxels, arena);
    std::vector<Vec3d> points = std::move(*route);
    centre(tiles, settings, points);
    render::smooth_inside(tiles, kSmoothRounds, points);
    return path_along(tiles, thinned(tiles, points, settings.spacing_mm));
}

}  // namespace pliant
