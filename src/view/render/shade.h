// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light and normals of many pixels at once, in vectors. Bit-identical to RealLook and to
// VolumeRays::normal, one pixel at a time.

#pragma once

#include <pliant/render.h>

#include <span>

#include "render/lining.h"

namespace pliant::render {

/// A pixel's wall.
struct LookHit {
    double t;  ///< distance from the eye [mm]
    Vec3d point_mm;
    Vec3d normal;     ///< unit
    Vec3d direction;  ///< of the ray, unit
};

/// The scan's voxels and their position in the world.
struct ScanView {
    const Volume& volume;
    const Mat3d& voxel_from_world;  ///< for vectors
};

/// All that the light of a wall depends on.
struct LookInput {
    ScanView scan;
    double iso_hu;
    bool is_rising;
    LiningColours colours;
    Vec3d lamps[2];
    double exposure;
    double voxel_mm;  ///< step behind the wall
};

/// Whether these kernels read a scan: at least two voxels in each row.
inline bool is_vectorised(const Volume& volume) {
    return volume.grid.size.x > 1;
}

/// Computes the light of walls at hits, linear, 0…1, as RealLook::shade does for one.
/// @param rest  offset of each hit's tissue from its position at rest [mm]; empty: none has moved
/// @pre is_vectorised(input.scan.volume)
void shade_hits(const LookInput& input, std::span<const LookHit> hits, std::span<const Vec3f> rest,
                Vec3d* light);

/// Computes unit normals at hits, as VolumeRays::normal does for one.
/// @param[in,out] hits  their normals are written
/// @pre is_vectorised(scan.volume)
void find_normals(const ScanView& scan, Polarity polarity, std::span<LookHit> hits);

}  // namespace pliant::render
