// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A phantom before it is sampled: layers of paint, each a shape with a value, later ones covering
// earlier ones, on a ground of air.
//
// A voxel takes of each layer the part of its own box (spacing along the grid's axes) that the
// shape fills. In a voxel that the surface crosses, the shape is looked at in eight sub-boxes; in
// each the surface is taken as a plane, whose share of a box is known exactly. So a plane edge is
// exact for any spacing and direction, and sheets down to about a quarter of a voxel keep their
// weight.

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

}  // namespace pliant::phantom
