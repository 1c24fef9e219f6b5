// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sliding contact of a surface with its image: pairs of points, both ways, whose gap along the
// normal of the image closes.
//
//      FROM moved  x + u(x) ●───┐ gap along m
//                               ▼
//      TO  ────────────────●────────────   y, normal m: the nearest in position and normal

#pragma once

#include <pliant/core/vec.h>

#include <cstddef>
#include <span>
#include <vector>

#include "morph/parts.h"

namespace pliant::morph {

/// Constraint of a point of Part::from: normal · u = gap.
struct Slide {
    std::size_t point;  ///< of Part::from
    Vec3d normal;
    double gap;  ///< [mm]
};

/// The surface at FROM as it has moved so far.
struct Moved {
    std::vector<Vec3d> points, normals;
};

/// Nearest points of the image for all points of the surface, then nearest points of the surface
/// for a sample of the image.
std::vector<Slide> slides_of(const Part& part, const Moved& moved);

/// Mean distance of the moved points along the normals of the nearest points of the image [mm].
double surface_residual_mm(const Part& part, const Moved& moved);

/// Unit normal of a surface that a map with the gradient I + ∂u/∂x has moved.
Vec3d moved_normal(const Mat3d& gradient, Vec3d normal);

}  // namespace pliant::morph
