// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes as plain values: hexahedra, tetrahedra, triangles. Nodes are places in the world, elements
// name their corners. Hexahedra have VTK's corner order:
//
//        7───────6        local axes   face   its corners, outward by the right hand
//       /|      /|         t            0     −r: 0 4 7 3
//      4───────5 |         | s          1     +r: 1 2 6 5
//      | 3─────|─2         |/           2     −s: 0 1 5 4
//      |/      |/          0── r        3     +s: 3 7 6 2
//      0───────1                        4     −t: 0 3 2 1
//                                       5     +t: 4 5 6 7
//
//   const HexMesh block = hex_mesh({.size = {10, 10, 10}, .spacing_mm = {1, 1, 1}});
//   if (const Status s = check_mesh(block); !s) …s.error().message
//   write_vtu("block.vtu", block, {{{"displacement_mm", u}}});

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct HexMesh {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 8>> cells;
};

struct TetMesh {
    std::vector<Vec3d> nodes_mm;
    /// Positive: the last corner sees the other three counter-clockwise from behind, (b−a)×(c−a)
    /// points to it.
    std::vector<std::array<std::int32_t, 4>> cells;
};

struct TriangleMesh {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 3>> cells;
};

/// A box of nodes along the world's axes, i fastest: what large regular solids are made of.
struct HexLattice {
    Vec3i size{2, 2, 2};  ///< nodes along x, y, z; cells are one fewer
    Vec3d spacing_mm{1, 1, 1};
    Vec3d origin_mm{0, 0, 0};  ///< of node (0, 0, 0)
};

constexpr std::int64_t node_count(const HexLattice& l) {
    return std::int64_t(l.size.x) * l.size.y * l.size.z;
}
constexpr std::int64_t cell_count(const HexLattice& l) {
    return std::int64_t(l.size.x - 1) * (l.size.y - 1) * (l.size.z - 1);
}
/// @pre ijk is inside
constexpr std::int32_t node_index(const HexLattice& l, Vec3i p) {
    return p.x + l.size.x * (p.y + l.size.y * p.z);
}
constexpr std::int32_t cell_index(const HexLattice& l, Vec3i p) {
    return p.x + (l.size.x - 1) * (p.y + (l.size.y - 1) * p.z);
}
Vec3d node_place_mm(const HexLattice& lattice, std::int32_t node);
std::array<std::int32_t, 8> cell_corners(const HexLattice& lattice, std::int32_t cell);

/// @returns InvalidArgument that names the field; at most 2³⁰ nodes
Status check_lattice(const HexLattice& lattice);

// The lattice must be one that check_lattice accepts.

/// Nodes and cells keep their numbers.
HexMesh hex_mesh(const HexLattice& lattice);
/// Six tetrahedra per cell around the diagonal from corner 0 to corner 6, so that neighbours fit.
TetMesh tet_mesh(const HexLattice& lattice);
/// A sheet in the plane z = 0 where each inner node has six neighbours [Choi2004, 4.1]: rows of
/// equilateral triangles, every second row shifted by half of a side.
/// @pre columns, rows ≥ 2
TriangleMesh triangle_sheet(int columns, int rows, double side_mm);

/// One of a hexahedron's six quadrilaterals, see above.
struct HexFace {
    std::int32_t cell = 0;
    int face = 0;
    friend constexpr bool operator==(const HexFace&, const HexFace&) = default;
};
inline constexpr int kHexFaceCorners[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                              {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// Faces that belong to one cell only, in the cells' order.
std::vector<HexFace> boundary_faces(const HexMesh& mesh);
/// The boundary, each quadrilateral as two triangles; unused nodes are left out.
TriangleMesh boundary_triangles(const HexMesh& mesh);

/// For each node the number of its connected piece, from 0 in the order of their first nodes;
/// nodes that no cell uses are pieces of their own. @pre check_cells accepts the mesh
std::vector<std::int32_t> pieces(const HexMesh& mesh);
std::vector<std::int32_t> pieces(const TetMesh& mesh);
std::vector<std::int32_t> pieces(const TriangleMesh& mesh);

/// Flatter elements are refused: determinant at a corner (of triangles: the cross product) over the
/// product of the lengths of the edges there.
inline constexpr double kFlattestCorner = 1e-6;

/// Whether each cell can be worked with: its nodes exist, are finite and distinct, and it is
/// neither inverted nor flat. @returns InvalidArgument that names the cell and node
Status check_cells(const HexMesh& mesh);
Status check_cells(const TetMesh& mesh);
Status check_cells(const TriangleMesh& mesh);

/// The same, and that each node is used and all is one piece.
Status check_mesh(const HexMesh& mesh);
Status check_mesh(const TetMesh& mesh);
Status check_mesh(const TriangleMesh& mesh);

/// Vectors or numbers at the nodes or in the cells, for a file.
struct VtuVectors {
    std::string name;
    std::span<const Vec3d> values;
};
struct VtuNumbers {
    std::string name;
    std::span<const double> values;
};
struct VtuFields {
    std::vector<VtuVectors> node_vectors{};
    std::vector<VtuNumbers> cell_numbers{};
};

/// VTK's XML file of an unstructured grid, which ParaView and 3D Slicer open: numbers as 64-bit
/// floats, appended in base64. Appears whole or not at all.
/// @returns InvalidArgument for a field whose length is wrong or a cell with an unknown node,
///          Unwritable
Status write_vtu(const std::filesystem::path& path, const HexMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TetMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TriangleMesh& mesh,
                 const VtuFields& fields = {});

}  // namespace pliant
#pragma GCC visibility pop
