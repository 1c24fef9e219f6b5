// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Suggests a first view of a scan: deep inside a lumen, along its longest free path.
//
// Lung is below a wall's threshold too. So in CT the lumen is first searched in pure air; only if
// there is none, below the threshold. The air around the patient is the last choice.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <pliant/data/scan_values.h>

#include "render/camera.h"
#include "render/lumen.h"
#include "render/volume_rays.h"

namespace pliant {
namespace {

constexpr double kPureAirHu = -925;  // lung is about −850, air −1000
constexpr double kLungHu = -820;  // noisy lung reaches this every few millimetres, air never does
// Lengths in a body; see length_scale.
constexpr double kMinRadiusMm = 2;  // minimum radius for an endoscope
constexpr double kWideMm = 8;       // larger radii give no higher score
constexpr double kHallMm = 15;      // from here on it is a hall rather than a tube
constexpr double kFarMm = 60;       // a sufficient free path
constexpr int kMaxPositions = 300;
constexpr int kLooks = 240;
constexpr int kFinalists = 12;  // positions for the fine search
constexpr int kFinalDirections = 1500;

struct Stage {
    double threshold_hu;  ///< of the lumen
    double wall_hu;       ///< wall that ends the free path
    bool allow_outside;
};

std::vector<Stage> stages(double iso_hu, Polarity polarity) {
    const bool ct = polarity == Polarity::Rising && iso_hu > kLungHu && iso_hu < 0;
    std::vector<Stage> list;
    for (bool outside : {false, true}) {
        if (ct) list.push_back({kPureAirHu, kLungHu, outside});
        list.push_back({iso_hu, iso_hu, outside});
    }
    return list;
}

struct View {
    double score = 0;
    Vec3d direction{0, 0, 0};
};

struct Position {
    std::size_t cell;
    double radius_mm;
    View view = {};
    double preference = 1;  ///< factor of its score, 0…1
};

/// Local maxima of the distance to the wall, widest first, at a minimum distance from each other.
std::vector<Position> deep_positions(const render::CoarseVolume& coarse,
                                     const std::vector<float>& distance_mm, double scale) {
    const double wide_mm = scale * kWideMm;
    std::vector<Position> peaks;
    const Box3i box{{0, 0, 0}, coarse.size};
    for (std::size_t i = 0; i < distance_mm.size(); ++i) {
        const float here = distance_mm[i];
        if (!(double(here) >= scale * kMinRadiusMm)) continue;
        const Vec3i p = coarse.cell(i);
        bool peak = true;
        for (int k = 0; k < 27 && peak; ++k) {
            const Vec3i q{p.x + k % 3 - 1, p.y + k / 3 % 3 - 1, p.z + k / 9 - 1};
            if (contains(box, q) && distance_mm[coarse.index(q)] > here) peak = false;
        }
        // Without any wall the distance is infinite.
        if (peak) peaks.push_back({i, std::min(double(here), 1e3), {}});
    }
    std::stable_sort(peaks.begin(), peaks.end(), [&](const Position& a, const Position& b) {
        return std::min(a.radius_mm, wide_mm) > std::min(b.radius_mm, wide_mm);
    });
    std::vector<Position> positions;
    const Vec3d s = coarse.spacing_mm;
    for (const Position& peak : peaks) {
        const Vec3i p = coarse.cell(peak.cell);
        const bool crowded =
            std::any_of(positions.begin(), positions.end(), [&](const Position& other) {
                const Vec3i d = coarse.cell(other.cell) - p;
                return norm({d.x * s.x, d.y * s.y, d.z * s.z}) < std::min(peak.radius_mm, wide_mm);
            });
        if (!crowded) positions.push_back(peak);
        if (positions.size() >= std::size_t(kMaxPositions)) break;
    }
    return positions;
}

/// Specks of noise have wide and closed views, too, but are smaller than a lumen.
void prefer_large_parts(const std::vector<std::uint32_t>& sizes, std::vector<Position>& positions) {
    constexpr double kSpeck = 0.01;  // of the largest part
    std::uint32_t largest = 1;
    for (const Position& position : positions) largest = std::max(largest, sizes[position.cell]);
    for (Position& position : positions)
        position.preference *= std::min(1.0, double(sizes[position.cell]) / (kSpeck * largest));
}

/// The air around a patient is closed in by blankets and the table, which are thin.
void prefer_bodies(const render::CoarseVolume& coarse, double tissue_hu, double scale,
                   std::vector<Position>& positions, const TaskArena& arena) {
    constexpr double kBodyMm = 15, kInside = 0.75;  // of the best position's share
    std::vector<double> shares(positions.size());
    arena.for_each(std::int64_t(positions.size()), 8, [&](auto begin, auto end) {
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
            shares[i] = render::share_behind_tissue(coarse, coarse.cell(positions[i].cell),
                                                    tissue_hu, scale * kBodyMm);
    });
    const double best = shares.empty() ? 0 : *std::max_element(shares.begin(), shares.end());
    for (std::size_t i = 0; i < positions.size() && best > 0; ++i)
        positions[i].preference *= std::clamp(std::pow(shares[i] / (kInside * best), 4), 1e-3, 1.0);
}

/// Candidate directions; for each the indices of the directions in its picture, and in the middle
/// of the picture.
struct Directions {
    std::vector<Vec3d> all;
    std::vector<std::vector<std::size_t>> around, middle;
};

Directions make_directions(int count) {
    constexpr double kAround = 0.86, kMiddle = 0.97;  // cosines of some 30° and 14°
    Directions d;
    d.all = render::sphere_directions(count);
    d.around.resize(d.all.size());
    d.middle.resize(d.all.size());
    for (std::size_t i = 0; i < d.all.size(); ++i)
        for (std::size_t k = 0; k < d.all.size(); ++k) {
            const double cosine = dot(d.all[i], d.all[k]);
            if (cosine > kAround) d.around[i].push_back(k);
            if (cosine > kMiddle) d.middle[i].push_back(k);
        }
    return d;
}

View best_view(const render::VolumeRays& rays, Vec3d eye_mm, double radius_mm, double iso_hu,
               Polarity polarity, const Directions& directions) {
    const double scale = length_scale(rays.volume.grid);
    const double far_mm = scale * kFarMm, wide_mm = scale * kWideMm, hall_mm = scale * kHallMm;
    std::vector<double> free(directions.all.size(), 0.0);
    int walls = 0;
    for (std::size_t i = 0; i < directions.all.size(); ++i) {
        const auto t = rays.hit_distance(eye_mm, directions.all[i], iso_hu, polarity);
        if (!t) continue;  // the ray leaves the volume
        ++walls;
        free[i] = *t;
    }
    // The end of a lumen is a good view, a hole at the scan's border isn't.
    constexpr double kHole = 0.4;
    constexpr double kDownwards = 1.2;  // prefers views towards the feet, as in most endoscopies
    const auto closed = [&](const std::vector<std::size_t>& indices) {
        const auto count = std::count_if(indices.begin(), indices.end(),
                                         [&](std::size_t k) { return free[k] > 0; });
        return double(count) / double(indices.size());
    };
    View best;
    double longest = 0;
    for (std::size_t i = 0; i < free.size(); ++i) {
        double sum = 0;  // over the middle of the picture, because of gaps
        for (std::size_t k : directions.middle[i]) sum += std::min(free[k], far_mm);
        const double mean = sum / double(directions.middle[i].size());
        if (kDownwards * mean <= longest) continue;
        const double length = mean * std::pow(closed(directions.around[i]), 2) *
                              (closed(directions.middle[i]) < 1 ? kHole : 1) *
                              (directions.all[i].z < -0.3 ? kDownwards : 1);
        if (length <= longest) continue;
        longest = length;
        best.direction = directions.all[i];
    }
    const double enclosed = double(walls) / double(directions.all.size());
    const double width = std::min(radius_mm / wide_mm, 1.0) * std::min(hall_mm / radius_mm, 1.0);
    best.score = enclosed * enclosed * width * longest / far_mm;
    return best;
}

/// Scores all positions, and searches around the best ones with more directions.
std::optional<Endoscope> search(const render::VolumeRays& rays, const render::CoarseVolume& coarse,
                                std::vector<Position> positions, double iso_hu, Polarity polarity) {
    Endoscope endoscope;
    endoscope.iso_hu = iso_hu;
    endoscope.polarity = polarity;
    endoscope.fog_distance_mm *= length_scale(rays.volume.grid);
    for (const auto& [count, kept] : {std::pair{kLooks, kFinalists}, {kFinalDirections, 1}}) {
        const Directions directions = make_directions(count);
        const auto eye = [&](const Position& position) {
            return world_from_voxel(rays.volume.grid,
                                    voxel_of_cell(coarse, rays.volume.grid, position.cell));
        };
        rays.arena.for_each(std::int64_t(positions.size()), 2, [&](auto begin, auto end) {
            for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
                positions[i].view = best_view(rays, eye(positions[i]), positions[i].radius_mm,
                                              iso_hu, polarity, directions);
                positions[i].view.score *= positions[i].preference;
            }
        });
        std::stable_sort(
            positions.begin(), positions.end(),
            [](const Position& a, const Position& b) { return a.view.score > b.view.score; });
        if (positions.size() > std::size_t(kept)) positions.resize(std::size_t(kept));
        if (positions.empty() || !(positions[0].view.score > 0)) return std::nullopt;
        endoscope.eye_mm = eye(positions[0]);
        endoscope.look = positions[0].view.direction;
    }
    endoscope.up = render::natural_up(endoscope.look);
    return endoscope;
}

}  // namespace

std::optional<Vec3d> find_look(const Volume& volume, Vec3d eye_mm, double iso_hu, Polarity polarity,
                               const TaskArena& arena) {
    const render::VolumeRays rays(volume, arena);
    const View view = best_view(rays, eye_mm, length_scale(volume.grid) * kWideMm, iso_hu, polarity,
                                make_directions(kFinalDirections));
    if (!(view.score > 0)) return std::nullopt;
    return view.direction;
}

Endoscope view_of_whole(const Volume& volume) {
    const Grid& g = volume.grid;
    const auto at = [&](double share) {
        return world_from_voxel(
            g, {share * (g.size.x - 1), share * (g.size.y - 1), share * (g.size.z - 1)});
    };
    Endoscope e;
    const double radius_mm = 0.5 * norm(at(1) - at(0));
    const double distance_mm = radius_mm / std::sin(e.field_of_view_deg * std::numbers::pi / 360);
    e.eye_mm = at(0.5) - distance_mm * e.look;
    e.up = render::natural_up(e.look);
    e.fog_distance_mm = 0;
    return e;
}

std::optional<Endoscope> find_endoscope(const Volume& volume, double iso_hu, Polarity polarity,
                                        const TaskArena& arena) {
    if (!check_volume(volume).ok()) return std::nullopt;
    const render::VolumeRays rays(volume, arena);
    const render::CoarseVolume coarse = render::make_coarse(volume, arena);
    for (const Stage& stage : stages(iso_hu, polarity)) {
        const auto mask =
            render::lumen_mask(coarse, stage.threshold_hu, polarity, stage.allow_outside);
        auto positions = deep_positions(coarse, render::wall_distance_mm(coarse, mask, arena),
                                        length_scale(volume.grid));
        prefer_large_parts(render::part_sizes(coarse, mask), positions);
        // Around a bright lumen all is darker, inside of a body and outside.
        if (polarity == Polarity::Rising)
            prefer_bodies(coarse, iso_hu, length_scale(volume.grid), positions, arena);
        if (auto found = search(rays, coarse, positions, stage.wall_hu, polarity)) {
            found->iso_hu = iso_hu;
            return found;
        }
    }
    return std::nullopt;
}

}  // namespace pliant
