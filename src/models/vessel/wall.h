// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wall around a lumen given by its signed distance d, negative inside: the solid 0 < d <
// thickness, without the parts beyond the ends.

#pragma once

#include <pliant/models/vessel.h>

namespace pliant::vessel {

struct LumenShape {
    LevelFunction distance_mm;  ///< negative inside, with a Lipschitz constant of 1
    Vec3d begin_mm, end_mm;     ///< bounding box
    std::vector<VesselEnd> ends;
};

Result<VesselWall> make_wall(const LumenShape& lumen, const WallSettings& settings,
                             const TaskArena& arena);

/// Extracts the lumen's surface between its ends, facing the lumen.
/// @param lattice  the wall's; settings.ghost_mm replaces its cell size
Result<TriangleMesh> ghost_of(const LumenShape& lumen, const WallSettings& settings,
                              StuffingSettings lattice, const TaskArena& arena);
/// Removes triangles connected to a rim by a single node, and small fragments.
void tidy_rims(TriangleMesh& surface);
/// Whether a ghost node is farther from its tetrahedron than the tetrahedron's longest edge.
bool is_beside(const Embedded& position, Vec3d ghost_node, const TetMesh& wall);
/// Trims a ghost surface at the ends to the wall's extent, and embeds its nodes in the wall.
/// Weights that are rounding errors become 0.
/// @param[out] ghost, positions
void ride_on(const TetMesh& wall, const std::vector<VesselEnd>& ends, double thickness_mm,
             double cell_mm, const TaskArena& arena, TriangleMesh& ghost,
             std::vector<Embedded>& positions);

/// Distance from the nearest end's cut [mm]: negative beyond an end, in its neighbourhood.
double outside_of_ends(const std::vector<VesselEnd>& ends, double thickness_mm, Vec3d x);
/// Removes pieces behind an end's cut, but never the largest piece.
void remove_cut_off(TetMesh& mesh, const std::vector<VesselEnd>& ends, double thickness_mm);

/// Minimum number of edges from one set of nodes to another; −1 if they aren't connected.
int edges_between(const TetMesh& mesh, const std::vector<bool>& from, const std::vector<bool>& to);

/// Openings of a surface, each as its nodes in the order of a lid with the surface's orientation.
/// @returns InvalidArgument if openings touch
Result<std::vector<std::vector<std::int32_t>>> openings_of(const TriangleMesh& surface);
/// Adds lids to the openings of a surface: fans around the means of their nodes.
/// @returns InvalidArgument if openings touch
Result<TriangleMesh> with_lids(const TriangleMesh& surface);
/// Winding number by the solid angles of all triangles [VanOosterom1983]; for closed surfaces of
/// either orientation.
bool is_inside(const TriangleMesh& closed, Vec3d x);
/// Volume enclosed by a surface and lids on its openings; positive if it faces inwards.
double enclosed_with_lids_mm3(const TriangleMesh& surface);

Error wrong(const std::string& what);

}  // namespace pliant::vessel
