// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hits of many rays that start at one point, a vector of rays at a time. The scalar twin is
// Cast in caster.h; what is the same here: the walk through bricks and cells in whole numbers, with
// the places where a ray meets a plane computed by one expression, and the cubic in the cell, all
// in double precision. What differs:
//
//  * Empty bricks are passed by leaps (leaps.h), many at once.
//  * Rays of a vector do the same thing together: all leap until each has come to a brick that
//    holds the threshold; all walk until each has come to a cell that holds it; then all cubics
//    are solved. Rays that were earlier wait.
//  * A ray walks from cell to cell with the voxels' own type: a cell holds the threshold if some of
//    its corners are below it and some are not.
//  * The root is found from where the chord crosses zero, and to 1e-13 of the cell's share of the
//    ray.
//
// Each ray's answer is its own: it doesn't depend on the rays beside it, on the width of the
// vectors, nor on the instruction set, bit for bit. It differs from the twin's by rounding only
// (kPacketRoundingMm in the tests).

#pragma once

#include <cstdint>
#include <span>

#include "render/bricks.h"
#include "render/leaps.h"

namespace pliant::render {

/// What rays are cast at: a field at one threshold.
template <class T>
struct PacketScene {
    const T* voxels;
    Vec3i size;            ///< voxels, ≥ 2 on each axis
    const LeapMap* leaps;  ///< of the field's fine bricks
    T threshold;           ///< threshold_of(iso)
    double iso;
    bool rising;
    bool origin_above;       ///< which side the ray's origin is on, where it is inside of the grid
    Vec3d origin;            ///< of all rays [voxels]
    Mat3d voxel_from_world;  ///< for directions
};

/// Whether a field is small enough for 32-bit offsets.
template <class T>
bool fits_packets(Vec3i size) {
    constexpr double kMostBytes = 2147483647;
    return double(sizeof(T)) * size.x * size.y * size.z <= kMostBytes;
}

/// @param directions  world
/// @param[out] distances  in lengths of each direction; infinite: no hit
/// @pre fits_packets; every direction is finite and not zero
void cast_packets(const PacketScene<std::int16_t>& scene, std::span<const Vec3d> directions,
                  double* distances);
void cast_packets(const PacketScene<float>& scene, std::span<const Vec3d> directions,
                  double* distances);

}  // namespace pliant::render
