// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Passes rays from one eye to the vector kernel, and undecided ones to the scalar version.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/beam.h"
#include "render/camera.h"
#include "render/caster.h"
#include "render/volume_rays.h"

namespace pliant::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool is_usable(Vec3d direction) {
    const double size = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    return size > 0 && size < kInfinity;
}

}  // namespace

EyeRays::EyeRays(const VolumeRays& rays, Vec3d eye_mm, double iso_hu, Polarity polarity)
    : m_rays(rays), m_eye_mm(eye_mm), m_iso_hu(iso_hu), m_polarity(polarity) {
    with_field(rays.volume, [&]<class T>(const VoxelField<T>&) {
        const auto& bricks = *std::get_if<Bricks<T>>(&rays.bricks);
        const auto threshold = threshold_of<T>(iso_hu);
        m_hits_nothing = !threshold || bricks.cells.x == 0 || !is_finite(eye_mm);
        if (!m_hits_nothing) m_leaps = make_leap_map(bricks.fine, *threshold);
    });
}

template <class T>
void EyeRays::cast(std::span<const Vec3d> directions, double* distances) const {
    const Volume& volume = m_rays.volume;
    const auto& voxels = *std::get_if<VoxelArray<T>>(&volume.voxels);
    const BeamInput<T> input{.voxels = voxels.data(),
                             .size = volume.grid.size,
                             .leaps = &m_leaps,
                             .threshold = *threshold_of<T>(m_iso_hu),
                             .iso = m_iso_hu,
                             .rising = m_polarity == Polarity::Rising,
                             .eye = m_rays.to_voxel(m_eye_mm),
                             .voxel_from_world = m_rays.voxel_from_world};
    cast_beams(input, directions, distances);
}

void EyeRays::hit_distances(std::span<const Vec3d> directions, double* distances) const {
    const auto count = std::ptrdiff_t(directions.size());
    if (m_hits_nothing) {
        std::fill(distances, distances + count, kInfinity);
        return;
    }
    if (!std::all_of(directions.begin(), directions.end(), is_usable)) {
        for (std::ptrdiff_t i = 0; i < count; ++i) {
            const auto one = directions.subspan(std::size_t(i), 1);
            distances[i] = kInfinity;
            if (is_usable(one[0])) hit_distances(one, distances + i);
        }
        return;
    }
    if (m_rays.volume.is_16_bit())
        cast<std::int16_t>(directions, distances);
    else
        cast<float>(directions, distances);
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        if (!std::isnan(distances[i])) continue;
        const Vec3d direction = directions[std::size_t(i)];
        const double per_mm = 1 / norm(direction);  // as in first_hit, for the same decision
        const auto t = m_rays.hit_distance(m_eye_mm, per_mm * direction, m_iso_hu, m_polarity);
        distances[i] = t ? *t * per_mm : kInfinity;
    }
}

}  // namespace pliant::render

namespace pliant {

std::vector<Vec3d> view_directions(const Endoscope& endoscope, int width, int height) {
    width = std::max(width, 1);
    height = std::max(height, 1);
    const render::Camera camera(endoscope, width, height);
    std::vector<Vec3d> directions;
    directions.reserve(std::size_t(width) * std::size_t(height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) directions.push_back(camera.direction(x + 0.5, y + 0.5));
    return directions;
}

void RayCaster::first_hits(Vec3d eye_mm, std::span<const Vec3d> directions, double iso_hu,
                           Polarity polarity, std::span<double> distances) const {
    constexpr std::int64_t kGrain = 1024;  // rays
    const render::EyeRays rays(m_impl->rays, eye_mm, iso_hu, polarity);
    m_impl->rays.arena.for_each(
        std::int64_t(directions.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
            rays.hit_distances(directions.subspan(std::size_t(begin), std::size_t(end - begin)),
                               distances.data() + begin);
        });
}

}  // namespace pliant
