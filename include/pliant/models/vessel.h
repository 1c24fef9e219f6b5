// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wall of a vessel as tetrahedra of a given thickness around the lumen. The lumen's surface
// consists of triangles embedded in the tetrahedra: the ghost surface, with which catheters
// collide. For every size of the wall's cells, it is closed except at the vessel's open ends.
//
//      ───────────────── outer surface
//       /\/\/\/\/\/\/\/    tetrahedra, two or more across
//      ················· ghost: triangles that face the lumen, each node the weighted mean of a
//            lumen         tetrahedron's corners
//
// The lumen comes from a centreline with radii, from a triangle surface, or from a scan.
//
// @code
//   auto wall = wall_around_surface(surface, ends, {.thickness_mm = 1.5}, arena);
//   if (!wall) std::puts(wall.error().message.c_str());
//   else draw(wall->ghost, wall->ghost_positions);
// @endcode
//
// If memory runs out, functions that return a Result return LimitExceeded.

#pragma once

#include <pliant/core/record.h>
#include <pliant/mesh.h>
#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct CentrePoint {
    Vec3d position_mm;
    double radius_mm;
};
/// Branches of points; adjacent branches overlap.
struct Centreline {
    std::vector<std::vector<CentrePoint>> branches;
};

/// A cut through a vessel with an open wall.
struct VesselEnd {
    Vec3d centre_mm;
    Vec3d outward;  ///< unit vector
    double radius_mm;
};

struct WallSettings {
    double thickness_mm = 1.5;
    int layers = 2;  ///< minimum number of tetrahedra across the wall
    /// Edge of the wall's lattice; 0: the largest that the layers allow. If the wall fails
    /// check_wall, the lattice is refined to at least half of that size.
    double cell_mm = 0;
    double ghost_mm = 0;  ///< edge of the ghost surface's lattice; 0: the wall's
    std::int64_t max_cells = std::int64_t(1) << 25;
};

/// Rows of these settings.
SettingRows<WallSettings> wall_rows() noexcept;

struct VesselWall {
    TetMesh mesh;
    TriangleMesh ghost;                     ///< faces the lumen
    std::vector<Embedded> ghost_positions;  ///< of the ghost's nodes, in the mesh
    std::vector<VesselEnd> ends;
    int min_layers = 0;           ///< minimum number of edges from the inner to the outer surface
    double lumen_mm3 = 0;         ///< volume inside of the ghost surface and its open ends
    double cell_mm = 0;           ///< edge of the lattice; 0: no lattice
    int dropped_pieces = 0;       ///< disconnected pieces below 1 % of the wall
    std::string refined_because;  ///< fault of a larger lattice; empty: none
};

/// Checks a wall: one piece, boundary and inner surface are manifolds, the inner surface is open
/// exactly at the ends, enough layers of tetrahedra, each ghost node in the wall.
/// @returns InvalidArgument with the found and the expected value
Status check_wall(const VesselWall& wall, int layers = 1) noexcept;

/// Makes the wall around a tree of spheres along the centreline, with linearly interpolated radii.
/// It is open at each end of a branch that lies in no other branch.
/// @returns InvalidArgument that names the field or point, or the fault of the wall; LimitExceeded
Result<VesselWall> wall_around_centreline(const Centreline& centreline,
                                          const WallSettings& settings,
                                          const TaskArena& arena) noexcept;

/// Makes the wall around a surface. It is open where the surface is open. A closed surface is cut
/// off at the given ends.
/// @returns InvalidArgument if the surface isn't a manifold, a setting is out of range or the wall
///          fails check_wall; LimitExceeded
Result<VesselWall> wall_around_surface(TriangleMesh lumen, std::span<const VesselEnd> ends,
                                       const WallSettings& settings,
                                       const TaskArena& arena) noexcept;

/// Converts a file's lines to branches; radii come from its field "MaximumInscribedSphereRadius"
/// (VMTK's), "Radius" or "radius" [mm]. @returns InvalidArgument if they are missing
Result<Centreline> centreline_of(const MeshData& mesh) noexcept;

/// Open ends of a centreline, each moved inwards by this fraction of its radius.
std::vector<VesselEnd> ends_of(const Centreline& centreline, double inwards = 0);

/// Makes a wall of given tetrahedra. The ends are the openings of its inner surface.
/// @param lumen  the inner surface, open at the ends, of either orientation; without triangles: the
///               part of the boundary between sharp rims that encloses the lumen
/// @returns InvalidArgument if tetrahedra are inverted, a surface isn't a manifold, the wall isn't
///          a tube, or the inner surface lies beside the wall
Result<VesselWall> wall_of_mesh(TetMesh mesh, TriangleMesh lumen, const TaskArena& arena) noexcept;

struct TubeSettings {
    double thickness_mm = 1.5;
    int layers = 2;
    int sectors = 24;    ///< around the tube
    double ring_mm = 0;  ///< distance of rings along the tube; 0: the width of a sector
};
/// Sweeps the wall of one branch along it: rings of hexahedra, each split into six tetrahedra, with
/// minimal rotation from ring to ring [Wang2008]. The layers are straight, and the number of
/// elements is minimal.
/// @returns InvalidArgument, for a centreline that bends more sharply than the wall is wide too
Result<VesselWall> swept_tube(std::span<const CentrePoint> branch,
                              const TubeSettings& settings) noexcept;

struct RegionSettings {
    Vec3d seed_mm{0, 0, 0};
    double low = 0, high = 0;       ///< range of the lumen's values
    double smoothing_voxels = 0.8;  ///< smoothing of the region's edge: standard deviation
    /// Points of the path, if given, limit the region to a distance of within_mm: vessels are
    /// connected with the heart, and often with bone.
    std::vector<Vec3d> way_mm{};
    double within_mm = 15;
    double max_ml = 0;  ///< a larger region is refused as a leak; 0: no limit
};
struct Lumen {
    TriangleMesh surface;  ///< faces outwards
    std::vector<VesselEnd> ends;
    std::int64_t voxels = 0;
    double region_mm3 = 0;
};
/// Extracts the lumen's surface from a scan: the region connected with the seed through faces of
/// voxels with values between low and high, with a smoothed edge. The surface is closed at the
/// scan's border too; the openings there are the ends.
/// @returns InvalidArgument if the seed is outside of the value range or the scan, LimitExceeded if
///          the region is too large
Result<Lumen> lumen_of_region(const Volume& volume, const RegionSettings& settings,
                              const TaskArena& arena) noexcept;
/// Extracts the largest connected part of the voxels with one of these labels.
Result<Lumen> lumen_of_labels(const Volume& labels, std::span<const int> wanted,
                              double smoothing_voxels, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
