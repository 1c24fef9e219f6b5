// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The midpoint rule along each ray, in steps of at most half a voxel: exact where the scan is even.

#include <pliant/fluoroscopy.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/camera.h"
#include "render/canvas.h"
#include "render/field.h"
#include "render/volume_or_air.h"

namespace pliant {
namespace {

constexpr double kSampleVoxels = 0.5;        ///< voxels
constexpr double kMedianOdds = 0.55 / 0.45;  ///< of black to white at the median: 45 % grey
constexpr double kWindow = 4;                ///< width of the curve, in line integral
constexpr int kMeterRays = 7;                ///< along each side of the central third

Endoscope source_of(const Fluoroscopy& s, int width, int height) {
    const Vec3d ahead = norm(s.look) > 0 ? normalized(s.look) : Vec3d{0, 1, 0};
    const double half_height_mm = 0.5 * s.width_mm * height / width;
    return {
        .eye_mm = s.centre_mm - s.source_mm * ahead,
        .look = ahead,
        .up = s.up,
        .field_of_view_deg = 2 * std::atan(half_height_mm / s.source_mm) * 180 / std::numbers::pi,
        .barrel_distortion = 0};
}

/// Where a ray is between the outermost voxel centres: as a span of its length; else empty.
struct Stretch {
    double begin, end;
};
Stretch stretch_in(Vec3i size, Vec3d origin, Vec3d direction) {
    Stretch span{0, 1e300};
    for (int a = 0; a < 3; ++a) {
        const double last = size[a] - 1;
        if (direction[a] == 0) {
            if (origin[a] < 0 || origin[a] > last) return {0, 0};
            continue;
        }
        const double t0 = -origin[a] / direction[a], t1 = (last - origin[a]) / direction[a];
        span.begin = std::max(span.begin, std::min(t0, t1));
        span.end = std::min(span.end, std::max(t0, t1));
    }
    return span;
}

/// @param direction  [voxels per mm]
template <class Field>
double water_along(const Field& field, Vec3d origin, Vec3d direction) {
    const Stretch span = stretch_in(field.size(), origin, direction);
    const double length = span.end - span.begin;
    if (!(length > 0)) return 0;
    const double count = std::ceil(length * norm(direction) / kSampleVoxels), step = length / count;
    double sum = 0;
    for (double n = 0; n < count; ++n) {
        const double hu = field.sample(origin + (span.begin + (n + 0.5) * step) * direction);
        sum += std::max(0.0, 1 + hu / 1000);
    }
    return sum * step;
}

/// Median over a grid of rays through the central third of the picture, without those that miss
/// the scan [mm of water]; 0 if all miss.
double metered_water_mm(const Volume& scan, const Fluoroscopy& settings, int width, int height) {
    const Volume& volume = render::volume_or_air(scan);
    const Endoscope source = source_of(settings, width, height);
    const render::Camera camera(source, width, height);
    const Vec3d eye = voxel_from_world(volume.grid, source.eye_mm);
    std::vector<double> lengths;
    render::with_field(volume, [&](const auto& field) {
        for (int i = 0; i < kMeterRays; ++i)
            for (int j = 0; j < kMeterRays; ++j) {
                const auto at = [](int n) { return (1 + (n + 0.5) / kMeterRays) / 3; };
                const Vec3d ray = camera.direction(width * at(i), height * at(j));
                const Vec3d direction = voxel_from_world(volume.grid, source.eye_mm + ray) - eye;
                const double water = water_along(field, eye, direction);
                if (water > 1) lengths.push_back(water);
            }
    });
    if (lengths.empty()) return 0;
    const auto middle = lengths.begin() + std::ptrdiff_t(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

}  // namespace

std::vector<float> water_lengths_mm(const Volume& scan, const Fluoroscopy& settings, int width,
                                    int height, const TaskArena& arena) {
    const Volume& volume = render::volume_or_air(scan);
    const Endoscope source = source_of(settings, width, height);
    const render::Camera camera(source, width, height);
    const Grid& grid = volume.grid;
    const Vec3d eye = voxel_from_world(grid, source.eye_mm);
    std::vector<float> lengths(std::size_t(width) * std::size_t(height));
    render::with_field(volume, [&](const auto& field) {
        arena.for_each(height, 4, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t y = begin; y < end; ++y)
                for (int x = 0; x < width; ++x) {
                    const Vec3d ray = camera.direction(x + 0.5, double(y) + 0.5);
                    const Vec3d direction = voxel_from_world(grid, source.eye_mm + ray) - eye;
                    lengths[std::size_t(y) * std::size_t(width) + std::size_t(x)] =
                        float(water_along(field, eye, direction));
                }
        });
    });
    return lengths;
}

Image fluoroscopy_view(const Volume& volume, const Fluoroscopy& settings, int width, int height,
                       const TaskArena& arena) {
    const std::vector<float> lengths = water_lengths_mm(volume, settings, width, height, arena);
    const double exposure = settings.exposure_water_mm
                                ? *settings.exposure_water_mm
                                : metered_water_mm(volume, settings, width, height);
    Image image = render::make_image(width, height, {0, 0, 0});
    for (std::size_t n = 0; n < lengths.size(); ++n) {
        const double excess =
            settings.contrast * settings.water_per_mm * (double(lengths[n]) - exposure);
        const double light = 1 / (1 + kMedianOdds * std::exp(4 * excess / kWindow));
        const auto grey = std::uint8_t(255 * std::clamp(light, 0.0, 1.0) + 0.5);
        image.pixels[n] = {grey, grey, grey};
    }
    return image;
}

}  // namespace pliant
