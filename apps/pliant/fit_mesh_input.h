// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files and places of `pliant fit --mesh`: the mesh, its regions, held and loaded nodes,
// measurements.

#pragma once

#include <pliant/models/fit_mesh.h>

#include <string>
#include <vector>

#include "options.h"

namespace pliant::app {

struct FitMeshInput {
    FitMesh fit;
    std::vector<int> labels;  ///< [region]; one region without a label: empty
    std::string name;         ///< of the mesh's file, without its folder
    /// Mesh's number of each node of the file, −1 if unused; empty for a filled surface, whose file
    /// doesn't have the nodes.
    std::vector<std::int32_t> node_of;
};

/// Reads everything but the creep curve.
/// @returns an error that names the option and the file
Result<FitMeshInput> read_fit_mesh(const FitOptions& options, const TaskArena& arena);

/// Reads time_s,node,dx,dy,dz [s, mm], with the file's numbers of nodes.
Result<std::vector<CreepSample>> read_creep(const std::string& file, const FitMeshInput& input);

/// Reads node,dx,dy,dz or x,y,z,dx,dy,dz [mm]. @param nodes_mm  of the mesh, for node numbers
Result<std::vector<FitMeasurement>> read_measurements(const std::string& file,
                                                      const std::vector<Vec3d>& nodes_mm);

}  // namespace pliant::app
