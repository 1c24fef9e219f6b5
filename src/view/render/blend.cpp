// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/blend.h"

#include <algorithm>
#include <cmath>

#include "render/camera.h"
#include "render/colour.h"

namespace pliant::render {
namespace {

constexpr double kDark = 1e-3;       // rays end below this transmittance
constexpr double kAmbient = 0.35;    // ambient light, independent of the surface's orientation
constexpr double kSteepShare = 0.1;  // of the window per millimetre: a surface

/// Length that a ray can leap from a point without meeting a brick that reaches the threshold.
/// @returns t of the end of the leap, or 0 if the point's own brick reaches it
double leap_from(const LeapMap& leaps, const VoxelRay& ray, Vec3d p) {
    Vec3i brick;
    for (int a = 0; a < 3; ++a)
        brick[a] = std::clamp(int(std::floor(p[a] / kFineCells)), 0, leaps.size[a] - 1);
    const std::uint8_t code =
        leaps.codes[std::size_t(brick.x) +
                    std::size_t(leaps.size.x) *
                        (std::size_t(brick.y) + std::size_t(leaps.size.y) * std::size_t(brick.z))];
    if (code == 0 || (code & LeapMap::kAbove) != 0) return 0;
    double end = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        const int beyond = ray.direction[a] > 0 ? brick[a] + code : brick[a] - code + 1;
        end = std::min(end, ray.meets(a, double(kFineCells) * beyond));
    }
    return end;
}

}  // namespace

Blender::Blender(const VolumeRays& rays, const TransferFunction& transfer, bool may_skip)
    : m_rays(rays),
      m_low_hu(transfer.level_hu - 0.5 * transfer.window_hu),
      m_window_hu(std::max(transfer.window_hu, 1e-6)),
      m_extinction(std::max(transfer.opacity_per_mm, 0.0)),
      m_dim(linear_from_srgb(transfer.dim)),
      m_bright(linear_from_srgb(transfer.bright)) {
    const Vec3d s = rays.volume.grid.spacing_mm;
    m_step_mm = 0.5 * std::min({s.x, s.y, s.z});
    if (!may_skip) return;
    with_field(rays.volume, [&]<class T>(const VoxelField<T>&) {
        const auto& bricks = *std::get_if<Bricks<T>>(&rays.bricks);
        const auto threshold = threshold_of<T>(m_low_hu);
        if (threshold && bricks.cells.x > 0) m_leaps = make_leap_map(bricks.fine, *threshold);
    });
}

Vec3d Blender::shaded(Vec3d colour, Vec3d gradient, Vec3d direction) const {
    const double steepness = norm(gradient);
    if (!(steepness > 0)) return colour;
    const double facing = std::abs(dot(gradient, direction)) / steepness;
    const double surface = std::min(1.0, steepness / (kSteepShare * m_window_hu));
    return (1 - surface * (1 - kAmbient) * (1 - facing)) * colour;
}

template <class T>
Blended Blender::through(const VoxelField<T>& field, const VoxelRay& ray, Vec3d direction) const {
    Blended result{{0, 0, 0}, 1};
    const Vec3i n = field.size();
    const auto span = clip(ray, {n.x - 1, n.y - 1, n.z - 1});
    if (!span) return result;
    const auto steps = std::int64_t(std::ceil((span->end - span->begin) / m_step_mm));
    const double step = (span->end - span->begin) / double(steps);
    for (std::int64_t i = 0; i < steps; ++i) {
        const Vec3d p = ray.at(span->begin + (double(i) + 0.5) * step);
        if (!m_leaps.codes.empty()) {
            const double leap = leap_from(m_leaps, ray, p);
            if (leap > 0) {  // to the last step that is certainly inside of the leap
                const double inside = (leap - span->begin) / step - 0.5;
                i = std::max(i, std::min(steps, std::int64_t(std::floor(inside - 1e-6))));
                continue;
            }
        }
        const double value = field.sample(p);
        const double share = std::clamp((value - m_low_hu) / m_window_hu, 0.0, 1.0);
        if (share == 0) continue;
        const double opacity = 1 - std::exp(-m_extinction * share * step);
        const Vec3d s = m_rays.volume.grid.spacing_mm, g = field.gradient(p);
        const Vec3d gradient =
            world_from_lattice_vector(m_rays.volume.grid, {g.x / s.x, g.y / s.y, g.z / s.z});
        const Vec3d colour = (1 - share) * m_dim + share * m_bright;
        result.light =
            result.light + result.transmittance * opacity * shaded(colour, gradient, direction);
        result.transmittance *= 1 - opacity;
        if (result.transmittance < kDark) break;
    }
    return result;
}

Blended Blender::along(Vec3d origin_mm, Vec3d direction) const {
    const VoxelRay ray =
        make_voxel_ray(m_rays.to_voxel(origin_mm), m_rays.vector_to_voxel(direction));
    return with_field(m_rays.volume,
                      [&](const auto& field) { return through(field, ray, direction); });
}

}  // namespace pliant::render

namespace pliant {

Image RayCaster::blended_view(const Endoscope& endoscope, const TransferFunction& transfer,
                              int width, int height) const {
    width = std::max(width, 1);
    height = std::max(height, 1);
    const render::Blender blender(m_impl->rays, transfer);
    const render::Camera camera(endoscope, width, height);
    const Vec3d background = render::linear_from_srgb(endoscope.fog);
    Image image{width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height))};
    m_impl->rays.arena.for_each(height, 2, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t y = begin; y < end; ++y)
            for (int x = 0; x < width; ++x) {
                const Vec3d direction = camera.direction(x + 0.5, double(y) + 0.5);
                const auto seen = blender.along(endoscope.eye_mm, direction);
                image.pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)] =
                    render::srgb_from_linear(seen.light + seen.transmittance * background);
            }
    });
    return image;
}

}  // namespace pliant
