// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A part of an organ as an elastic body in sliding contact with its image.
//
// In units of its shear modulus the displacement u minimises
//
//   <m (2 |dev(ε − r)|² + κ tr(ε − r)² + β |∇∇(u − a)|²)> + w <(n · u − g)²>,
//   κ = 2 (1 + ν) / (3 (1 − 2 ν)),
//
// where <> are means over the part and over the constraints, m is the relative modulus. a is
// the affine map to the rest shape: the centroids coincide, each axis is scaled by the ratio of the
// standard deviations of the voxels. r is the strain of a, and an eigenstrain if the prior of lungs
// is used; where moduli differ, it is divided by m <1/m>: tissue under one stress. With
// s = (V_to / V_from)^(1/3) − 1, and y, z in standard deviations from the centroid, y to the back
// and z to the head,
//
//   r = ∇a + s (0.5 y − 0.2 z) I − 0.4 s (e_y e_zᵀ + e_z e_yᵀ).
//
// u has cubic B-splines; matching and solving alternate with a growing w.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <memory>
#include <vector>

#include "morph/parts.h"
#include "morph/slide.h"

namespace pliant::morph {

struct ElasticSettings {
    double poisson_ratio = 0, bending_mm2 = 1000;
    double back = 0;  ///< 1 or −1: y grows to the back or to the front, with the prior; 0: without
    std::vector<double> slide_weights;  ///< w by round [1/mm²]
};

/// Displacement of a body: cubic B-splines on a lattice of control points.
class BodyField {
  public:
    Vec3d at(Vec3d x) const;
    Mat3d gradient(Vec3d x) const;

  private:
    friend BodyField move_body(const Part& part, const ElasticSettings& settings);

    Vec3d m_low{0, 0, 0};
    double m_spacing = 1;
    Vec3i m_count{4, 4, 4};
    std::vector<Vec3d> m_coefficients;
};

/// @throws std::bad_alloc
BodyField move_body(const Part& part, const ElasticSettings& settings);

}  // namespace pliant::morph
