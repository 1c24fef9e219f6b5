// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Runs a scene file's script to its end and keeps the final scene.

#pragma once

#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>

#include <span>
#include <vector>

namespace pliant::results {

struct BendRun {
    std::vector<Vec3d> wall_mm, wire_mm;  ///< nodes; of the wire only those outside of the guide
    std::vector<bool> is_held;            ///< nodes of the wall
    TetMesh catheter;                     ///< empty for a rod
    double radius_mm = 0;
    double reach_mm = 0;          ///< reach of the boxes
    CatheterMeasures measures{};  ///< at the end
    double moved_mm = 0;          ///< largest displacement of a wall node at the end
    double depth_mm = -1e9;       ///< largest penetration in any step
    std::int64_t inverted = 0;    ///< tetrahedra, largest number
    std::int32_t active = 0;      ///< tetrahedra, largest number
    double ms = 0;                ///< processor time
};
/// @param[out] hand  command of each step
BendRun run_bend(const VesselFile& file, const MadeVessel& vessel, const TaskArena& arena,
                 std::vector<CatheterCommand>* hand = nullptr);

/// Largest distance of corresponding nodes.
double farthest_mm(std::span<const Vec3d> a, std::span<const Vec3d> b);

}  // namespace pliant::results
