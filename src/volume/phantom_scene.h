// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A phantom before it is sampled: layers of paint, each a shape with a value, later ones covering
// earlier ones, on a ground of air.
//
// A voxel takes of each layer the part of its footprint that the shape fills. The footprint is a
// box along the grid's axes: the voxel itself for test bodies, where an edge shall be as sharp as
// the grid allows; two voxels wide for anatomy, as a scanner sees it. Two is also the least width
// at which the iso surface of the trilinear interpolant lies exactly on a plane edge wherever the
// edge passes between the voxels; with one it is off by up to a twelfth of a voxel, which shows as
// steps in the endoscope's light.
//
// Where a surface crosses the footprint, the shape is looked at in its eight sub-boxes; in each the
// surface is taken as a plane, whose share of a box is known exactly. So plane edges are exact for
// any spacing and direction; a box whose distances are far from a plane's is looked at once more in
// its parts, so that sheets down to half a voxel keep their weight within a seventh.

#pragma once

#include "volume/phantom_shapes.h"

#include <pliant/phantom.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant::phantom {

struct Layer {
    Field distance;    ///< signed [mm]
    Field hu;          ///< value inside [HU]
    double slope = 1;  ///< the distance changes by at most this per mm
};

struct Scene {
    std::vector<Layer> layers;
    double footprint_voxels = 2;

    void add(Field distance, Field hu, double slope = 1) {
        layers.push_back({std::move(distance), std::move(hu), slope});
    }
};

/// A phantom's shapes and what is known about it.
struct Model {
    Vec3d extent_mm{0, 0, 0};
    Scene scene;
    std::vector<PhantomLandmark> landmarks;
    KeyValues key_values;
};

/// Share of the unit cube around 0 in which value + gradient·u < 0.
double plane_share(double value, Vec3d gradient);

/// Fills the voxels of a grid. The result doesn't depend on the number of threads.
/// @param[out] voxels  voxel_count(grid) values [HU]
void sample_scene(const Scene& scene, const Grid& grid, const TaskArena& arena,
                  const Progress& progress, std::span<std::int16_t> voxels);

/// From origin along direction, the first point within reach_mm where the distance is ≤ 0, or the
/// end of the reach.
Vec3d walk_to_surface(const Field& distance, Vec3d origin_mm, Vec3d direction, double reach_mm);

Model make_cube_model();
Model make_layers_model();
Model make_airway_model();
Model make_sinus_model();
Model make_vessel_model();
Model make_knee_model();

}  // namespace pliant::phantom
