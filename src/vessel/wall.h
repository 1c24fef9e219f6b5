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

/// The lumen's surface between its ends, which faces the lumen.
/// @param lattice  the wall's; with settings.ghost_mm its cells are of that size
Result<TriangleMesh> ghost_of(const LumenShape& lumen, const WallSettings& settings,
                              StuffingSettings lattice, const TaskArena& arena);
/// Removes triangles that hang on a rim by a node alone, and small pieces that have come off.
void tidy_rims(TriangleMesh& surface);
/// Whether a ghost node is farther from its tetrahedron than the longest edge of that.
bool is_beside(const Embedded& place, Vec3d ghost_node, const TetMesh& wall);
/// Trims a ghost surface at the ends to where the wall has cells, and finds its nodes there.
/// Weights that are rounding errors become 0.
/// @param[out] ghost, places
void ride_on(const TetMesh& wall, const std::vector<VesselEnd>& ends, double thickness_mm,
             double cell_mm, const TaskArena& arena, TriangleMesh& ghost,
             std::vector<Embedded>& places);

/// Distance from the nearest end's cut [mm]: negative beyond an end, near to it.
double outside_of_ends(const std::vector<VesselEnd>& ends, double thickness_mm, Vec3d x);
/// Removes pieces that go on behind an end's cut, but never the largest piece.
void remove_cut_off(TetMesh& mesh, const std::vector<VesselEnd>& ends, double thickness_mm);

/// Removes pieces of less than a hundredth of the largest: islands in the lumen, and what coarse
/// cells have cut off. @returns how many
int drop_crumbs(TetMesh& mesh);

/// The least number of edges from one set of nodes to another; −1 where there is no way.
int edges_between(const TetMesh& mesh, const std::vector<bool>& from, const std::vector<bool>& to);

/// The openings of a surface, each as its nodes in the order that a lid has which faces the same
/// way.
/// @returns InvalidArgument where openings touch
Result<std::vector<std::vector<std::int32_t>>> openings_of(const TriangleMesh& surface);
/// A surface and lids on its openings: fans around the means of their nodes.
/// @returns InvalidArgument where openings touch
Result<TriangleMesh> with_lids(const TriangleMesh& surface);
/// By the solid angle of all triangles [VanOosterom1983]; for closed surfaces that face either way.
bool is_inside(const TriangleMesh& closed, Vec3d x);
/// What a surface and lids on its openings enclose; positive where it faces inwards.
double enclosed_with_lids_mm3(const TriangleMesh& surface);

Error wrong(const std::string& what);

}  // namespace pliant::vessel
