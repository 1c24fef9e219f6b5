// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How good tetrahedra are, what bounds them, and points that ride on them.

#pragma once

#include <pliant/mesh_distance.h>
#include <pliant/tasks.h>

#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Faces that only one tetrahedron has, outward, by the mesh's own nodes, in the cells' order.
/// @param[out] cells  the tetrahedron of each; may be null
std::vector<std::array<std::int32_t, 3>> boundary_faces(const TetMesh& mesh,
                                                        std::vector<std::int32_t>* cells = nullptr);
/// The same as a mesh of its own. @param[out] nodes  the tetrahedral mesh's node of each; may be
/// null
TriangleMesh boundary_triangles(const TetMesh& mesh, std::vector<std::int32_t>* nodes = nullptr);
/// Some of a mesh's triangles, with the nodes that they use in their order.
TriangleMesh part_of(std::span<const Vec3d> nodes_mm,
                     std::span<const std::array<std::int32_t, 3>> triangles,
                     std::vector<std::int32_t>* nodes = nullptr);

struct TetQuality {
    std::int64_t nodes = 0, tetrahedra = 0;
    std::int64_t inverted = 0;  ///< of no or negative volume
    double volume_mm3 = 0;
    double least_dihedral_deg = 180, largest_dihedral_deg = 0;
    double least_radius_ratio = 1;  ///< 3 · inscribed / circumscribed radius, 1 where regular
    double mean_radius_ratio = 0;
    double shortest_edge_mm = 0, longest_edge_mm = 0;
    std::int64_t pieces = 0;
    std::int64_t crowded_faces = 0;  ///< of three tetrahedra or more
    SurfaceTopology boundary;
};
/// @pre the cells name nodes that exist
TetQuality tet_quality(const TetMesh& mesh);
/// Whether simulation can work with it: no inverted cells, and a boundary that is a closed
/// manifold.
/// @returns InvalidArgument that says what was found
Status check_quality(const TetQuality& quality);
/// For people, a line each, without a newline at the end.
std::string describe(const TetQuality& quality);

/// The same cells without nodes that none of them uses.
TetMesh with_used_nodes(const TetMesh& mesh);
/// Takes cells away where the boundary touches itself in an edge or a node, until it is a manifold.
/// @returns how many went
std::int64_t make_manifold(TetMesh& mesh);

/// A point that rides on a tetrahedron: the weighted mean of its corners.
struct Embedded {
    std::int32_t tetrahedron = 0;
    std::array<double, 4> weights{};  ///< sum 1; some negative where the point is a little outside
};
constexpr Vec3d place_of(const Embedded& e, const TetMesh& mesh) {
    Vec3d sum{0, 0, 0};
    for (std::size_t n = 0; n < 4; ++n)
        sum = sum +
              e.weights[n] * mesh.nodes_mm[std::size_t(mesh.cells[std::size_t(e.tetrahedron)][n])];
    return sum;
}
/// The tetrahedron that holds each point, or the nearest one. Of several the first.
/// @pre the mesh has cells, none inverted or flat
std::vector<Embedded> embed(std::span<const Vec3d> points_mm, const TetMesh& mesh,
                            const TaskArena& arena);

}  // namespace pliant
#pragma GCC visibility pop
