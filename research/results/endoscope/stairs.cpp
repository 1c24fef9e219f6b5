// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Walls at eight distances in one picture, as the sectors of a spiral staircase seen from above,
// with a common exposure and frontal views.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "colours.h"

namespace pliant::results {
namespace {

constexpr std::array<double, 8> kSteps_mm{8, 11, 15, 20, 27, 36, 48, 60};
constexpr int kSide = 100, kLong = 70;  // voxels of 1 mm
constexpr double kEye_mm = 2;

/// Sector 0…7 of a direction about the view, and the angle to its middle line [sectors, −½…½].
std::pair<std::size_t, double> sector_of(double x, double z) {
    const double turn = std::atan2(z, x) / (2 * std::numbers::pi) + 0.5;
    const double at = std::min(turn * double(kSteps_mm.size()), 7.999999);
    // Neighbours in the picture have different distances: 8, 27, 11, 36, …
    const auto n = std::size_t(at);
    return {n % 2 * 4 + n / 2, at - std::floor(at) - 0.5};
}

Volume make_stairs() {
    Volume v;
    v.grid.size = {kSide, kLong, kSide};
    std::vector<std::int16_t> voxels(voxel_count(v.grid));
    for (int k = 0; k < kSide; ++k)
        for (int j = 0; j < kLong; ++j)
            for (int i = 0; i < kSide; ++i) {
                const auto n = sector_of(i - kSide / 2.0, k - kSide / 2.0).first;
                const double behind = j - kEye_mm - kSteps_mm[n];
                voxels[voxel_index(v.grid, {i, j, k})] =
                    std::int16_t(-1000 + 1040 * std::clamp(behind + 0.5, 0.0, 1.0));
            }
    v.voxels = std::move(voxels);
    return v;
}

double median(std::vector<double>& values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

std::vector<Stair> light_on_stairs(const TaskArena& arena) {
    const Volume volume = make_stairs();
    const RayCaster caster(volume, arena);
    Endoscope e;
    e.eye_mm = {kSide / 2.0, kEye_mm, kSide / 2.0};
    e.look = {0, 1, 0};
    e.up = {0, 0, 1};
    e.field_of_view_deg = 60;
    e.barrel_distortion = 0;
    e.style = Style::Real;
    e.field_stop = FieldStop::Full;
    constexpr int kPixels = 512;
    const Image image = caster.endoscope_view(e, kPixels, kPixels);
    std::array<std::vector<double>, kSteps_mm.size()> distances, lights;
    for (int j = 0; j < kPixels; ++j)
        for (int i = 0; i < kPixels; ++i) {
            const double u = (2 * i + 1.0) / kPixels - 1, v = (2 * j + 1.0) / kPixels - 1;
            if (std::hypot(u, v) > 0.45 || std::hypot(u, v) < 0.2) continue;  // no vignette
            const auto hit = caster.pick(e, kPixels, kPixels, i + 0.5, j + 0.5);
            if (!hit || hit->normal.y > -0.98) continue;
            const auto [n, off] =
                sector_of(hit->point_mm.x - e.eye_mm.x, hit->point_mm.z - e.eye_mm.z);
            if (std::abs(off) > 0.25 || std::abs(hit->point_mm.y - kEye_mm - kSteps_mm[n]) > 1)
                continue;
            const Rgb8 c = image.pixels[std::size_t(j) * kPixels + std::size_t(i)];
            distances[n].push_back(hit->distance_mm);
            lights[n].push_back(light_before_tone(c.r));
        }
    std::vector<Stair> stairs;
    for (std::size_t n = 0; n < kSteps_mm.size(); ++n)
        if (lights[n].size() > 100) stairs.push_back({median(distances[n]), median(lights[n])});
    return stairs;
}

}  // namespace pliant::results
