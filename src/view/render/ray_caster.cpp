// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conversions between world and voxels for rays; the cast itself is in caster.h.

#include "render/camera.h"
#include "render/caster.h"
#include "render/volume_or_air.h"
#include "render/volume_rays.h"

namespace pliant::render {

VolumeRays::VolumeRays(const Volume& scan, const TaskArena& threads)
    : volume(volume_or_air(scan)),
      arena(threads),
      voxel_from_world(inverse(volume.grid.direction)) {
    for (Vec3d& column : voxel_from_world.columns)
        for (int a = 0; a < 3; ++a) column[a] /= volume.grid.spacing_mm[a];
    with_field(volume,
               [&]<class T>(const VoxelField<T>& field) { bricks = make_bricks(field, arena); });
}

std::optional<double> VolumeRays::hit_distance(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                               Polarity polarity) const {
    const VoxelRay ray = make_voxel_ray(to_voxel(origin_mm), vector_to_voxel(direction));
    return with_field(volume, [&]<class T>(const VoxelField<T>& field) {
        return Cast<T>(field, *std::get_if<Bricks<T>>(&bricks), ray, iso_hu,
                       polarity == Polarity::Rising)
            .first_hit();
    });
}

Vec3d VolumeRays::normal(Vec3d point_mm, Vec3d direction, Polarity polarity) const {
    constexpr double kMinSlope = 1e-9;  // HU/mm: flatter fields have no direction
    const Vec3d ijk = to_voxel(point_mm);
    const Vec3d per_voxel =
        with_field(volume, [&](const auto& field) { return field.gradient(ijk); });
    const Vec3d s = volume.grid.spacing_mm;
    const Vec3d slope = world_from_lattice_vector(
        volume.grid, {per_voxel.x / s.x, per_voxel.y / s.y, per_voxel.z / s.z});
    const double length = norm(slope);
    if (!(length > kMinSlope)) return -direction;
    Vec3d n = (polarity == Polarity::Rising ? -1 / length : 1 / length) * slope;
    const double along = dot(n, direction);
    if (along > 0) {  // smoothing turned it past the silhouette: project it back
        n = n - along * direction;
        const double left = norm(n);
        n = left > kMinSlope ? (1 / left) * n : -direction;
    }
    return n;
}

void VolumeRays::normals(std::span<LookHit> hits, Polarity polarity) const {
    if (is_vectorised(volume)) return find_normals({volume, voxel_from_world}, polarity, hits);
    for (LookHit& hit : hits) hit.normal = normal(hit.point_mm, hit.direction, polarity);
}

double VolumeRays::sample(Vec3d point_mm) const {
    const Vec3d ijk = to_voxel(point_mm);
    return with_field(volume, [&](const auto& field) { return field.sample(ijk); });
}

}  // namespace pliant::render

namespace pliant {

RayCaster::RayCaster(const Volume& volume, const TaskArena& arena)
    : m_impl(std::make_unique<Impl>(Impl{{volume, arena}, {}})) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::first_hit(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                           Polarity polarity) const {
    const double length = norm(direction);
    if (!(length > 0) || !is_finite(direction) || !is_finite(origin_mm)) return std::nullopt;
    const Vec3d unit = (1 / length) * direction;
    const auto t = m_impl->rays.hit_distance(origin_mm, unit, iso_hu, polarity);
    if (!t) return std::nullopt;
    const Vec3d point = origin_mm + *t * unit;
    return RayHit{*t, point, m_impl->rays.normal(point, unit, polarity)};
}

std::optional<RayHit> RayCaster::pick(const Endoscope& endoscope, int width, int height, double x,
                                      double y) const {
    const render::Camera camera(endoscope, std::max(width, 1), std::max(height, 1));
    return first_hit(endoscope.eye_mm, camera.direction(x, y), endoscope.iso_hu,
                     endoscope.polarity);
}

void RayCaster::update(std::span<const Box3i> boxes) {
    render::VolumeRays& rays = m_impl->rays;
    if (&rays.volume == &render::small_air_volume()) return;
    render::with_field(rays.volume, [&]<class T>(const render::VoxelField<T>& field) {
        render::update_bricks(*std::get_if<render::Bricks<T>>(&rays.bricks), field, boxes,
                              m_impl->scratch, rays.arena);
    });
}

}  // namespace pliant
