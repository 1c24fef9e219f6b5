// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wall around any lumen that is known by its signed distance d, negative inside: the solid
// 0 < d < thickness, without what lies beyond the ends.

#pragma once

#include <pliant/vessel_wall.h>

namespace pliant::vessel {

struct LumenShape {
    LevelFunction distance_mm;  ///< negative inside, changes as distances do
    Vec3d begin_mm, end_mm;     ///< a box around it
    std::vector<VesselEnd> ends;
};

Result<VesselWall> make_wall(const LumenShape& lumen, const WallSettings& settings,
                             const TaskArena& arena);

/// The least number of edges from one set of nodes to another; −1 where there is no way.
int edges_between(const TetMesh& mesh, const std::vector<bool>& from, const std::vector<bool>& to);

/// The openings of a surface, each as its nodes in the order that a lid has which faces the same
/// way.
/// @returns InvalidArgument where openings touch
Result<std::vector<std::vector<std::int32_t>>> openings_of(const TriangleMesh& surface);
/// What a surface and lids on its openings enclose; positive where it faces inwards.
double enclosed_with_lids_mm3(const TriangleMesh& surface);

Error wrong(const std::string& what);

}  // namespace pliant::vessel
