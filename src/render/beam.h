// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hits of many rays that start at one eye. Neighbouring rays of a picture cross nearly the
// same cells, often dozens of rays the same cell. So it is not rays that look for cells, but cells
// that are looked up for a beam of rays at once, as in the coherent grid traversal of [Wald2006]:
//
//             ┌───┬───┬───┬───┐     The beam goes slice by slice along the axis that it follows
//         ┌╌╌╌│╌╌╌│╌╌╌│   │ / │     most. In each slice it meets a few cells, front to back. Only
//   eye ∙ <   │   │ ■ │ ■ │/  │     those whose corners lie on both sides of the threshold (■) are
//         └╌╌╌│╌╌╌│╌╌╌│╌╌╌│   │     tried, with a vector of rays at a time.
//             └───┴───┴───┴───┘
//
// Slices of bricks that don't hold the threshold are passed at once (leaps.h). What is read from
// memory is read once for the beam, and nothing has to be gathered. A beam that is wider than a few
// cells where it meets the surface is split.
//
// The scalar twin is Cast in caster.h. Both compute where a ray meets a plane by one expression,
// and the cubic in a cell in the same order, in double precision; the root is found from another
// place, and to 1e-13 of the ray's share of the cell. Each ray's answer is its own: it depends
// neither on the rays beside it nor on the width of the vectors nor on the instruction set, bit for
// bit. Where rounding could decide on which side of a face a ray turns, and for rays along an axis,
// the answer is left to the twin.

#pragma once

#include <cstdint>
#include <span>

#include "render/bricks.h"
#include "render/leaps.h"

namespace pliant::render {

/// What rays are cast at: a field at one threshold, seen from one eye.
template <class T>
struct BeamScene {
    const T* voxels;
    Vec3i size;            ///< voxels, ≥ 2 on each axis
    const LeapMap* leaps;  ///< of the field's fine bricks
    T threshold;           ///< threshold_of(iso)
    double iso;
    bool rising;
    Vec3d eye;               ///< [voxels]
    Mat3d voxel_from_world;  ///< for directions
};

/// @param directions  world; finite, with a length
/// @param[out] distances  in lengths of each direction; infinite: no hit; NaN: ask the scalar twin
void cast_beams(const BeamScene<std::int16_t>& scene, std::span<const Vec3d> directions,
                double* distances);
void cast_beams(const BeamScene<float>& scene, std::span<const Vec3d> directions,
                double* distances);

}  // namespace pliant::render
