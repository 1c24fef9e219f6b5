// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rays in the world and their intersection with voxels: the data of a RayCaster, for the files that
// draw.

#pragma once

#include <pliant/render.h>

#include <span>
#include <variant>

#include "render/bricks.h"
#include "render/leaps.h"
#include "render/shade.h"

namespace pliant::render {

struct VolumeRays {
    VolumeRays(const Volume& scan, const TaskArena& threads);

    /// First crossing: distance only. @param direction  world, unit
    std::optional<double> hit_distance(Vec3d origin_mm, Vec3d direction, double iso_hu,
                                       Polarity polarity) const;
    /// Unit normal of the field at a world point, from the wall to the lumen.
    /// @param direction  of the ray, unit; the normal never points along it
    Vec3d normal(Vec3d point_mm, Vec3d direction, Polarity polarity) const;
    /// Normals at many hits, in vectors: bit-identical.
    /// @param[in,out] hits  their normals are written
    void normals(std::span<LookHit> hits, Polarity polarity) const;
    /// Value at a world point [HU].
    double sample(Vec3d point_mm) const;

    Vec3d to_voxel(Vec3d point_mm) const {
        return vector_to_voxel(point_mm - volume.grid.origin_mm);
    }
    Vec3d vector_to_voxel(Vec3d v_mm) const { return voxel_from_world * v_mm; }

    const Volume& volume;
    const TaskArena& arena;
    Mat3d voxel_from_world;  ///< for vectors
    std::variant<Bricks<std::int16_t>, Bricks<float>> bricks;
};

/// Many rays from one eye at one threshold, with shared precomputation.
class EyeRays {
  public:
    EyeRays(const VolumeRays& rays, Vec3d eye_mm, double iso_hu, Polarity polarity);

    /// First crossings of neighbouring rays, on one thread.
    /// @param directions  world; zero or invalid directions hit nothing
    /// @param[out] distances  in multiples of each direction's length; infinite: no hit
    void hit_distances(std::span<const Vec3d> directions, double* distances) const;

  private:
    template <class T>
    void cast(std::span<const Vec3d> directions, double* distances) const;

    const VolumeRays& m_rays;
    Vec3d m_eye_mm;
    double m_iso_hu;
    Polarity m_polarity;
    bool m_hits_nothing = false;
    LeapMap m_leaps;
};

}  // namespace pliant::render

namespace pliant {

struct RayCaster::Impl {
    render::VolumeRays rays;
    std::vector<std::int32_t> scratch;  // for updates
};

}  // namespace pliant
