// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A phantom before sampling: a stack of layers, each a shape with a value, on a background of air.
// Later layers cover earlier ones.
//
// Each layer contributes to a voxel by the fraction of the voxel's footprint in its shape. The
// footprint is a box along the grid's axes. For test bodies it is the voxel, for the sharpest
// edges; for anatomy it is two voxels wide, as in a scanner. Two is also the smallest width at
// which the iso surface of the trilinear interpolant coincides with a plane edge at every position
// between the voxels. With one, the error is up to a twelfth of a voxel, which causes steps in the
// endoscope's shading.
//
// Where a surface crosses the footprint, the shape is evaluated in its eight sub-boxes. In each of
// them the surface is approximated by a plane, whose volume fraction in a box is exact. So plane
// edges are exact for every spacing and direction. A box with distances unlike a plane's is
// subdivided once more, so that the weight of sheets down to half a voxel is accurate within a
// seventh.

#pragma once

#include "volume/phantom_shapes.h"

#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant::phantom {

struct Layer {
    ScalarField distance;  ///< signed [mm]
    ScalarField hu;        ///< value inside [HU]
    double slope = 1;      ///< Lipschitz constant of the distance [1]
};

struct LayerStack {
    std::vector<Layer> layers;
    double footprint_voxels = 2;

    void add(ScalarField distance, ScalarField hu, double slope = 1) {
        layers.push_back({std::move(distance), std::move(hu), slope});
    }
};

/// A phantom's shapes and metadata.
struct Model {
    Vec3d extent_mm{0, 0, 0};
    LayerStack stack;
    std::vector<PhantomLandmark> landmarks;
    KeyValues key_values;
};

/// Fraction of the unit cube around 0 in which value + gradient·u < 0.
double plane_share(double value, Vec3d gradient);

/// Samples the stack on a grid. The result is independent of the number of threads.
/// @param[out] voxels  voxel_count(grid) values [HU]
void sample_layers(const LayerStack& stack, const Grid& grid, const TaskArena& arena,
                   const Progress& progress, std::span<std::int16_t> voxels);

/// Sphere tracing: the first point along the ray within reach_mm with a distance ≤ 0, or the end of
/// the reach.
Vec3d walk_to_surface(const ScalarField& distance, Vec3d origin_mm, Vec3d direction,
                      double reach_mm);

Model make_cube_model();
Model make_layers_model();
Model make_airway_model();
Model make_sinus_model();
Model make_vessel_model();
Model make_knee_model();

}  // namespace pliant::phantom
