// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The wall of a vessel as tetrahedra of a given thickness around its lumen, and the lumen's surface
// as triangles that ride on them: the ghost surface, which catheters collide with. For any size of
// the wall's cells it is closed but for the vessel's open ends.
//
//      ───────────────── outer surface
//       /\/\/\/\/\/\/\/    tetrahedra, two or more across
//      ················· ghost: triangles that face the lumen, each node the weighted mean of a
//            lumen         tetrahedron's corners
//
// The lumen comes from a centreline with radii, from a triangle surface, or from a scan.
//
//   auto wall = wall_around_surface(surface, {.thickness_mm = 1.5}, arena);
//   if (!wall) …wall.error().message
//   wall->mesh, wall->ghost, wall->ghost_places
//
// Where memory runs out, functions that return a Result return LimitExceeded.

#pragma once

#include <pliant/mesh_files.h>
#include <pliant/mesh_quality.h>
#include <pliant/mesh_stuffing.h>
#include <pliant/record.h>
#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct CentrePoint {
    Vec3d place_mm;
    double radius_mm;
};
/// Branches of points; where they meet they overlap.
struct Centreline {
    std::vector<std::vector<CentrePoint>> branches;
};

/// Where a vessel is cut off and its wall is open.
struct VesselEnd {
    Vec3d centre_mm;
    Vec3d outward;  ///< unit vector
    double radius_mm;
};

struct WallSettings {
    double thickness_mm = 1.5;
    int layers = 2;  ///< tetrahedra across the wall, at least
    /// Of the lattice; 0: as large as the layers allow. A lattice whose wall fails
    /// check_wall is refined, down to half of the size that the layers allow.
    double cell_mm = 0;
    double ghost_mm = 0;  ///< of the lattice that the ghost surface is made with; 0: the wall's
    std::int64_t most_cells = std::int64_t(1) << 25;
};

/// Rows of these settings.
SettingRows<WallSettings> wall_rows() noexcept;

struct VesselWall {
    TetMesh mesh;
    TriangleMesh ghost;                  ///< faces the lumen
    std::vector<Embedded> ghost_places;  ///< of its nodes, on the mesh
    std::vector<VesselEnd> ends;
    int least_layers = 0;         ///< no path from the inner to the outer surface has fewer edges
    double lumen_mm3 = 0;         ///< volume that the ghost surface and its open ends enclose
    double cell_mm = 0;           ///< of the lattice that it was made with; 0: without one
    int dropped_pieces = 0;       ///< smaller than a hundredth of the wall, and not connected to it
    std::string refined_because;  ///< fault of a larger lattice; empty: the first one held
};

/// Whether a wall holds: one piece, a boundary and an inner surface that are manifolds, openings of
/// the inner surface at the ends and nowhere else, as many layers of tetrahedra, each ghost node on
/// the wall.
/// @returns InvalidArgument with the value found and the value expected
Status check_wall(const VesselWall& wall, int layers = 1) noexcept;

/// Around a tree of spheres that move along the centreline, their radii changing evenly in between.
/// Open at each end of a branch that lies in no other branch.
/// @returns InvalidArgument that names the field or point, or says why the wall doesn't hold;
///          LimitExceeded
Result<VesselWall> wall_around_centreline(const Centreline& centreline,
                                          const WallSettings& settings,
                                          const TaskArena& arena) noexcept;

/// Around a surface. Where it is open the wall is open too; where it is closed, at the ends given,
/// which cut off what lies beyond them.
/// @returns InvalidArgument where the surface is no manifold, for settings out of range or where
///          the wall fails check_wall; LimitExceeded
Result<VesselWall> wall_around_surface(TriangleMesh lumen, std::span<const VesselEnd> ends,
                                       const WallSettings& settings,
                                       const TaskArena& arena) noexcept;

/// A file's lines as branches, its field "MaximumInscribedSphereRadius" (VMTK's), "Radius" or
/// "radius" as their radii [mm]. @returns InvalidArgument where there are no such
Result<Centreline> centreline_of(const MeshData& mesh) noexcept;

/// The ends of a centreline, each moved inwards by this part of its radius.
std::vector<VesselEnd> ends_of(const Centreline& centreline, double inwards = 0);

struct TubeSettings {
    double thickness_mm = 1.5;
    int layers = 2;
    int sectors = 24;    ///< around
    double ring_mm = 0;  ///< between rings along the tube; 0: as long as a sector is wide
};
/// The wall of one branch, swept along it: rings of hexahedra, each six tetrahedra, turned as
/// little as possible from ring to ring [Wang2008]. Straight layers, and as few elements as
/// possible.
/// @returns InvalidArgument, also where the centreline bends more sharply than the wall is wide
Result<VesselWall> swept_tube(std::span<const CentrePoint> branch,
                              const TubeSettings& settings) noexcept;

struct RegionSettings {
    Vec3d seed_mm{0, 0, 0};
    double low = 0, high = 0;       ///< values that belong to the lumen
    double smoothing_voxels = 0.8;  ///< of the region's edge: standard deviation
    /// Nothing farther than this from the way belongs to it, where a way is given: vessels hang
    /// together with the heart, and often with bone.
    std::vector<Vec3d> way_mm{};
    double within_mm = 15;
    double most_ml = 0;  ///< a larger region is refused as one that leaks; 0: any size
};
struct Lumen {
    TriangleMesh surface;  ///< faces outwards
    std::vector<VesselEnd> ends;
    std::int64_t voxels = 0;
    double region_mm3 = 0;
};
/// The lumen's surface in a scan: what is connected with the seed through faces of voxels whose
/// values are between low and high, its edge smoothed. Closed, also at the scan's border; those
/// places are the ends.
/// @returns InvalidArgument where the seed isn't in the window or the scan, LimitExceeded where the
///          region is larger than it may be
Result<Lumen> lumen_of_region(const Volume& volume, const RegionSettings& settings,
                              const TaskArena& arena) noexcept;
/// The same of voxels with one of these labels: the largest part that hangs together.
Result<Lumen> lumen_of_labels(const Volume& labels, std::span<const int> wanted,
                              double smoothing_voxels, const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
