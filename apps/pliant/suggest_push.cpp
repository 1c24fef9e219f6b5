// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "suggest_push.h"

#include <pliant/chainmail.h>
#include <pliant/render.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace pliant::app {
namespace {

// Lengths in a body; see length_scale.
constexpr double kPushMm = 6, kRadiusMm = 4;
constexpr double kIntoWallMm = 1;  ///< from the visible surface to tissue that can be grabbed
constexpr double kNearestMm = 8, kFarthestMm = 60;
constexpr int kDirections = 160;

struct Candidate {
    PushOption push;
    double ahead;  ///< cosine of the angle to the viewing direction
};

/// Evenly distributed directions on the sphere (golden spiral).
Vec3d direction(int n) {
    const double z = 1 - (2 * n + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    const double turn = 2 * std::numbers::pi * n / std::numbers::phi;
    return {r * std::cos(turn), r * std::sin(turn), z};
}

/// Visible walls, those straight ahead first.
std::vector<Candidate> walls_in_view(const Volume& volume, const Endoscope& view,
                                     const TaskArena& arena) {
    const double scale = length_scale(volume.grid);
    const RayCaster caster(volume, arena);
    const Vec3d look = normalized(view.look);
    std::vector<Candidate> candidates;
    for (int n = 0; n < kDirections; ++n) {
        const Vec3d way = direction(n);
        const double ahead = dot(way, look);
        if (ahead < 0.3) continue;
        const auto hit = caster.first_hit(view.eye_mm, way, view.iso_hu, view.polarity);
        if (!hit || hit->distance_mm < scale * kNearestMm || hit->distance_mm > scale * kFarthestMm)
            continue;
        candidates.push_back(
            {{hit->point_mm - scale * kIntoWallMm * hit->normal, -scale * kPushMm * hit->normal},
             ahead});
    }
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.ahead > b.ahead; });
    return candidates;
}

/// Fraction of the push that the tissue allows; 0 if it can't be tested.
double step_fraction(const Volume& volume, const ChainMailSettings& settings,
                     const PushOption& push, const TaskArena& arena) {
    auto tissue = ChainMail::create(volume, settings, arena);
    if (!tissue) return 0;
    const auto report = tissue->push({.point_mm = push.point_mm,
                                      .push_mm = push.push_mm,
                                      .sphere_radius_mm = suggested_radius_mm(volume.grid)});
    return report ? report->step_fraction : 0;
}

/// Rounds to tenths of a millimetre, or less in a small specimen, for typing.
PushOption rounded(const PushOption& push, double scale) {
    const double parts = 10 * std::pow(10, -std::floor(std::log10(scale)));
    const auto short_one = [&](Vec3d v) {
        return Vec3d{std::round(parts * v.x) / parts, std::round(parts * v.y) / parts,
                     std::round(parts * v.z) / parts};
    };
    return {short_one(push.point_mm), short_one(push.push_mm)};
}

}  // namespace

double suggested_radius_mm(const Grid& grid) {
    // A sphere of fewer voxels makes a blocky dent.
    constexpr double kVoxels = 4.0 / 3;
    const Vec3d s = grid.spacing_mm;
    return std::max(length_scale(grid) * kRadiusMm, kVoxels * std::max({s.x, s.y, s.z}));
}

std::optional<PushOption> suggest_push(const Volume& volume, const ValueDefaults& values,
                                       double iso, Polarity polarity, const TaskArena& arena) {
    const auto view = find_endoscope(volume, iso, polarity, arena);
    if (!view) return std::nullopt;
    ChainMailSettings settings;
    suit_materials(values, settings);
    std::optional<PushOption> best;
    double best_fraction = 0.05;
    for (const Candidate& candidate : walls_in_view(volume, *view, arena)) {
        const PushOption push = rounded(candidate.push, length_scale(volume.grid));
        const double fraction = step_fraction(volume, settings, push, arena);
        if (fraction <= best_fraction) continue;
        best = push;
        best_fraction = fraction;
        if (fraction == 1) break;
    }
    return best;
}

}  // namespace pliant::app
