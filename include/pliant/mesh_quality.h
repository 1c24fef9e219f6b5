// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Quality and boundary of tetrahedral meshes, and points embedded in them.

#pragma once

#include <pliant/mesh_distance.h>
#include <pliant/tasks.h>

#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Faces of one tetrahedron only, outward, with the mesh's node numbers, in the order of the cells.
/// @param[out] cells  tetrahedron of each face; may be null
std::vector<std::array<std::int32_t, 3>> boundary_faces(const TetMesh& mesh,
                                                        std::vector<std::int32_t>* cells = nullptr);
/// Boundary as a separate mesh. @param[out] nodes  the tetrahedral mesh's node for each; may be
/// null
TriangleMesh boundary_triangles(const TetMesh& mesh, std::vector<std::int32_t>* nodes = nullptr);
/// Extracts triangles, with the nodes that they use in their order.
TriangleMesh part_of(std::span<const Vec3d> nodes_mm,
                     std::span<const std::array<std::int32_t, 3>> triangles,
                     std::vector<std::int32_t>* nodes = nullptr);

struct TetQuality {
    std::int64_t nodes = 0, tetrahedra = 0;
    std::int64_t inverted = 0;  ///< of zero or negative volume
    double volume_mm3 = 0;
    double least_dihedral_deg = 180, largest_dihedral_deg = 0;
    double least_radius_ratio = 1;  ///< 3 · inscribed / circumscribed radius, 1 where regular
    double mean_radius_ratio = 0;
    double shortest_edge_mm = 0, longest_edge_mm = 0;
    std::int64_t pieces = 0;
    std::int64_t crowded_faces = 0;  ///< shared by three or more tetrahedra
    SurfaceTopology boundary;
};
/// @pre the cells name nodes that exist
TetQuality tet_quality(const TetMesh& mesh);
/// Checks that a mesh suits simulation: no inverted cells, and a closed manifold boundary.
/// @returns InvalidArgument that names the fault
Status check_quality(const TetQuality& quality);
/// Readable text, one line per figure, without a newline at the end.
std::string describe(const TetQuality& quality);

/// Removes unused nodes.
TetMesh with_used_nodes(const TetMesh& mesh);
/// Removes cells at edges and nodes where the boundary touches itself, until it is a manifold.
/// @returns number of removed cells
std::int64_t make_manifold(TetMesh& mesh);

/// A point embedded in a tetrahedron: the weighted mean of its corners.
struct Embedded {
    std::int32_t tetrahedron = 0;
    std::array<double, 4> weights{};  ///< sum 1; some are negative if the point is slightly outside
};
constexpr Vec3d place_of(const Embedded& e, const TetMesh& mesh) {
    Vec3d sum{0, 0, 0};
    for (std::size_t n = 0; n < 4; ++n)
        sum = sum +
              e.weights[n] * mesh.nodes_mm[std::size_t(mesh.cells[std::size_t(e.tetrahedron)][n])];
    return sum;
}
/// Finds the tetrahedron that contains each point, or the nearest one; the first of several.
/// @pre the mesh has cells, none inverted or flat
std::vector<Embedded> embed(std::span<const Vec3d> points_mm, const TetMesh& mesh,
                            const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
