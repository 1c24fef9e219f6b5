// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rays in the world and the voxels they meet: what a RayCaster holds, for the files that draw.

#pragma once

#include <pliant/render.h>

#include <variant>

#include "render/bricks.h"

namespace pliant::render {

struct VolumeRays {
    VolumeRays(const Volume& scan, const TaskArena& threads);

    /// First crossing: distance only. @param direction  world, unit
    std::optional<double> hit_distance(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                       Polarity polarity) const;
    /// Unit normal of the field at a world point, against the way from the lumen into the wall.
    /// @param direction  of the ray, unit; the normal never points along it
    Vec3d normal(Vec3d point_mm, Vec3d direction, Polarity polarity) const;
    /// Value at a world point [HU].
    double sample(Vec3d point_mm) const;

    Vec3d to_voxel(Vec3d point_mm) const {
        return vector_to_voxel(point_mm - volume.grid.origin_mm);
    }
    Vec3d vector_to_voxel(Vec3d v_mm) const {
        const Vec3d l = lattice_from_world * v_mm, s = volume.grid.spacing_mm;
        return {l.x / s.x, l.y / s.y, l.z / s.z};
    }

    const Volume& volume;
    const TaskArena& arena;
    Mat3d lattice_from_world;
    std::variant<Bricks<std::int16_t>, Bricks<float>> bricks;
};

}  // namespace pliant::render

namespace pliant {

struct RayCaster::Impl {
    render::VolumeRays rays;
};

}  // namespace pliant
