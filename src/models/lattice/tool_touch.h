// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissue that a sphere of any size touches in the deformed scan.
//
//     +-------+-------+      The trilinear value of a cell can be tissue between its corners, and
//     |       | o     |      a sphere o can lie where no corner is in it. So a sphere touches each
//     |    (o)|       |      cell whose value is tissue somewhere in the sphere, and takes hold of
//     +-------+-------+      the cell's eight elements (the multi-move of [Draeger2005, 3.5.3]).
//
// The value in a cell is sampled on a small lattice of points over the part of the cell that the
// sphere can reach, and at the sphere's centre.

#pragma once

#include <pliant/tool.h>
#include <pliant/volume.h>

#include <vector>

#include "lattice/lattice.h"

namespace pliant {

struct Touch {
    std::vector<Vec3i> elements;  ///< corners of the touched cells, each once, sorted by z, y, x
    std::vector<Vec3d>
        inside_mm;  ///< tissue in the sphere, from its centre, along the lattice axes
    bool is_empty() const { return elements.empty(); }
};

/// The result is independent of the brick size. @param centre  continuous voxel index
Touch touch_sphere(const Lattice& lattice, const Volume& scan, Vec3d centre, double radius_mm,
                   const TissueValues& tissue);

/// Whether the resampled scan can show tissue at a point. The value there is trilinear between
/// eight voxels, each of which shows the scan at φ⁻¹ of its centre; a margin covers the resampler's
/// rounding. Points beyond the outermost voxel centres are air.
/// @param point  continuous voxel index
bool shows_tissue(const Lattice& lattice, const Volume& scan, Vec3d point,
                  const TissueValues& tissue);

/// Elements that determine the resampled scan around a point: the corners of all cells that meet
/// the point's voxels or a ball around it. Sorted.
/// @param point  continuous voxel index
std::vector<Vec3i> elements_around(const Lattice& lattice, Vec3d point, double radius_mm);

}  // namespace pliant
