// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes as plain values: hexahedra, tetrahedra, triangles. Nodes are positions in the world; cells
// are lists of corners. Hexahedra have VTK's corner order:
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
    /// Positive orientation: (b−a)×(c−a) points to the last corner.
    std::vector<std::array<std::int32_t, 4>> cells;
};

struct TriangleMesh {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 3>> cells;
};

/// Box of nodes along the world's axes, i fastest, for large regular solids.
struct HexLattice {
    Vec3i size{2, 2, 2};  ///< nodes along x, y, z; one cell less
    Vec3d spacing_mm{1, 1, 1};
    Vec3d origin_mm{0, 0, 0};  ///< position of node (0, 0, 0)
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

// @pre check_lattice accepts the lattice.

/// Converts a lattice. Nodes and cells keep their numbers.
HexMesh hex_mesh(const HexLattice& lattice);
/// Splits each cell into six tetrahedra around the diagonal from corner 0 to corner 6, so that
/// neighbours conform.
TetMesh tet_mesh(const HexLattice& lattice);
/// A sheet in the plane z = 0 where each inner node has six neighbours [Choi2004, 4.1]: rows of
/// equilateral triangles, every second row shifted by half of a side.
/// @pre columns, rows ≥ 2
TriangleMesh triangle_sheet(int columns, int rows, double side_mm);

/// One of a hexahedron's six quadrilaterals; see the drawing.
struct HexFace {
    std::int32_t cell = 0;
    int face = 0;
    friend constexpr bool operator==(const HexFace&, const HexFace&) = default;
};
inline constexpr int kHexFaceCorners[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                              {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// Faces of one cell only, in the order of the cells.
std::vector<HexFace> boundary_faces(const HexMesh& mesh);
/// The boundary, each quadrilateral as two triangles; unused nodes are left out.
TriangleMesh boundary_triangles(const HexMesh& mesh);

/// For each node, the number of its connected piece, from 0 in the order of their first nodes. A
/// node without cells is a piece. @pre check_cells accepts the mesh
std::vector<std::int32_t> pieces(const HexMesh& mesh);
std::vector<std::int32_t> pieces(const TetMesh& mesh);
std::vector<std::int32_t> pieces(const TriangleMesh& mesh);

/// Flatter cells are refused. Ratio of the determinant at a corner (triangles: the cross product)
/// to the product of the lengths of the edges there.
inline constexpr double kFlattestCorner = 1e-6;

/// Checks each cell: its nodes exist, are finite and distinct, and it is neither inverted nor flat.
/// @returns InvalidArgument that names the cell and node
Status check_cells(const HexMesh& mesh);
Status check_cells(const TetMesh& mesh);
Status check_cells(const TriangleMesh& mesh);

/// Also checks that each node is used and the mesh is one piece.
Status check_mesh(const HexMesh& mesh);
Status check_mesh(const TetMesh& mesh);
Status check_mesh(const TriangleMesh& mesh);

/// Named vectors or numbers at the nodes or in the cells of a file.
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

/// Writes VTK's XML file of an unstructured grid, for ParaView and 3D Slicer: 64-bit floats,
/// appended in base64. Atomic.
/// @returns InvalidArgument for a field of the wrong length or a cell with an unknown node,
///          Unwritable
Status write_vtu(const std::filesystem::path& path, const HexMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TetMesh& mesh,
                 const VtuFields& fields = {});
Status write_vtu(const std::filesystem::path& path, const TriangleMesh& mesh,
                 const VtuFields& fields = {});

}  // namespace pliant
#pragma GCC visibility pop
