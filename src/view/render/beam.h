// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hits of many rays from one eye. Neighbouring rays of a picture cross nearly the same cells,
// often dozens of rays the same cell. So a beam of rays traverses the cells together, as in the
// coherent grid traversal of [Wald2006]:
//
//             ┌───┬───┬───┬───┐     The beam advances slice by slice along its main axis. In each
//         ┌╌╌╌│╌╌╌│╌╌╌│   │ / │     slice it meets a few cells, front to back. Only cells whose
//   eye ∙ <   │   │ ■ │ ■ │/  │     corners lie on both sides of the threshold (■) are intersected,
//         └╌╌╌│╌╌╌│╌╌╌│╌╌╌│   │     with a vector of rays at a time.
//             └───┴───┴───┴───┘
//
// Slices of bricks without the threshold are skipped at once (leaps.h). Memory is read once per
// beam, without gather instructions. A beam that is wider than a few cells at the surface is split.
//
// The scalar version is Cast in caster.h. Both compute the intersection of a ray and a plane by the
// same expression, and the cubic in a cell in the same order, in double precision. The root search
// has a different start, and ends at 1e-13 of the ray's part in the cell. The result of a ray is
// bit-identical, independent of the rays beside it, the vector width and the instruction set. The
// scalar version decides cases in which rounding could select the side of a face, and rays along an
// axis.

#pragma once

#include <cstdint>
#include <span>

#include "render/bricks.h"
#include "render/leaps.h"

namespace pliant::render {

/// Input of a beam: a field with one threshold, seen from one eye.
template <class T>
struct BeamInput {
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
/// @param[out] distances  in multiples of each direction's length; infinite: no hit; NaN:
///                        undecided, use the scalar version
void cast_beams(const BeamInput<std::int16_t>& input, std::span<const Vec3d> directions,
                double* distances);
void cast_beams(const BeamInput<float>& input, std::span<const Vec3d> directions,
                double* distances);

}  // namespace pliant::render
