// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// View of a point on the tissue. Rays leave the point in all directions; positions for the eye are
// sampled on each free ray. The best position is at an endoscope's usual distance, sees the surface
// from the front, is against the push or beside it, and has room around it.

#include <algorithm>
#include <cmath>

#include <pliant/data/scan_values.h>

#include "render/camera.h"
#include "render/lumen.h"
#include "render/volume_rays.h"

namespace pliant {
namespace {

constexpr int kDirections = 600;
// Lengths in a body; see length_scale.
constexpr double kDistancesMm[] = {24, 20, 29, 16, 35, 12, 45, 9, 6};
constexpr double kClearanceMm = 3;           // between the eye and any wall
constexpr double kDepthsMm[] = {4, 12, 30};  // of the target in the tissue
constexpr double kAirwayHu = -900;           // smaller: airway lumen; larger: possibly lung
constexpr double kSurfaceMm = 0.01;          // offset from the surface at the start of a ray

struct Viewpoint {
    Vec3d eye_mm;
    double score;
};

struct Aim {
    const render::VolumeRays& rays;
    Vec3d target_mm;
    Vec3d push;  // unit, or zero
    double iso_hu;
    Polarity polarity;
    double scale;  ///< of lengths

    bool in_tissue(Vec3d point_mm) const {
        return (rays.sample(point_mm) >= iso_hu) == (polarity == Polarity::Rising);
    }
    std::optional<double> wall(Vec3d from_mm, Vec3d direction) const {
        return rays.hit_distance(from_mm, direction, iso_hu, polarity);
    }
    std::optional<double> way_out(Vec3d from_mm, Vec3d direction) const {
        return rays.hit_distance(
            from_mm, direction, iso_hu,
            polarity == Polarity::Rising ? Polarity::Falling : Polarity::Rising);
    }
};

/// @param distance_mm  divided by the scale
double distance_score(double distance_mm) {
    constexpr double kNear = 18, kFar = 30;
    if (distance_mm < kNear) return distance_mm / kNear;
    return distance_mm > kFar ? kFar / distance_mm : 1;
}

/// Maximal at some 50° from the direction against the push, where the motion is visible from the
/// side.
double direction_score(Vec3d away, Vec3d push) {
    const double against = -dot(away, push);
    if (against < 0) return 0.7 * (1 + against) * (1 + against);
    return 1 - 0.5 * std::abs(against - 0.6);
}

/// Share of samples on the ray that are certainly free: in CT, air rather than lung.
double free_score(const Aim& aim, Vec3d eye_mm) {
    if (aim.polarity != Polarity::Rising || aim.iso_hu <= kAirwayHu || aim.iso_hu >= 0) return 1;
    constexpr int kSteps = 8;
    int free = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double share = 0.3 + 0.7 * i / (kSteps - 1);
        const Vec3d position = aim.target_mm + share * (eye_mm - aim.target_mm);
        free += aim.rays.sample(position) < kAirwayHu ? 1 : 0;
    }
    return 0.2 + 0.8 * free / kSteps;
}

void add_candidates(const Aim& aim, Vec3d away, double depth_mm, std::vector<Viewpoint>& found) {
    double begin = 0;
    if (aim.in_tissue(aim.target_mm)) {
        const auto out = aim.way_out(aim.target_mm, away);
        if (!out || *out > depth_mm) return;
        begin = *out + aim.scale * kSurfaceMm;
    }
    const Vec3d first = aim.target_mm + begin * away;
    const auto next_wall = aim.wall(first, away);
    const double end = next_wall ? begin + *next_wall : 1e9;
    for (double usual : kDistancesMm) {
        const double distance = aim.scale * usual;
        if (begin + distance > end - aim.scale * kClearanceMm) continue;
        const Vec3d eye = first + distance * away;
        const auto seen = aim.wall(eye, -away);
        const double facing =
            seen ? -dot(aim.rays.normal(eye - *seen * away, -away, aim.polarity), -away) : 0.5;
        const double score = distance_score(usual) * direction_score(away, aim.push) *
                             (0.25 + 0.75 * facing) * free_score(aim, eye);
        found.push_back({eye, score});
    }
}

bool has_room(const Aim& aim, Vec3d eye_mm, const std::vector<Vec3d>& directions) {
    return std::none_of(directions.begin(), directions.end(), [&](Vec3d d) {
        const auto t = aim.wall(eye_mm, d);
        return t && *t < aim.scale * kClearanceMm;
    });
}

std::optional<Vec3d> find_eye(const Aim& aim) {
    const auto directions = render::sphere_directions(kDirections);
    const auto around = render::sphere_directions(60);
    for (double depth : kDepthsMm) {
        std::vector<Viewpoint> found;
        for (Vec3d away : directions) add_candidates(aim, away, aim.scale * depth, found);
        std::stable_sort(found.begin(), found.end(),
                         [](const Viewpoint& a, const Viewpoint& b) { return a.score > b.score; });
        for (const Viewpoint& c : found)
            if (has_room(aim, c.eye_mm, around)) return c.eye_mm;
    }
    return std::nullopt;
}

}  // namespace

Endoscope aim_endoscope(const Volume& volume, Vec3d target_mm, Vec3d push_mm, double iso_hu,
                        Polarity polarity, const TaskArena& arena) {
    constexpr double kOutsideMm = 30;
    const render::VolumeRays rays(volume, arena);
    const double length = norm(push_mm);
    const Vec3d push = length > 0 ? (1 / length) * push_mm : Vec3d{0, 0, 0};
    const double scale = length_scale(volume.grid);
    Endoscope endoscope;
    endoscope.fog_distance_mm *= scale;
    endoscope.iso_hu = iso_hu;
    endoscope.polarity = polarity;
    if (const auto eye = find_eye({rays, target_mm, push, iso_hu, polarity, scale}))
        endoscope.eye_mm = *eye;
    else if (const auto lumen = find_endoscope(volume, iso_hu, polarity, arena))
        endoscope.eye_mm = lumen->eye_mm;
    else
        endoscope.eye_mm = target_mm - scale * kOutsideMm * (length > 0 ? push : Vec3d{0, 1, 0});
    const Vec3d look = target_mm - endoscope.eye_mm;
    if (norm(look) > 0) endoscope.look = normalized(look);
    endoscope.up = render::natural_up(endoscope.look);
    return endoscope;
}

}  // namespace pliant
