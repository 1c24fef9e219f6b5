// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks of meshes; they report the first fault in one line.

#include <pliant/mesh.h>

#include <algorithm>
#include <numeric>

namespace pliant {
namespace {

/// Corners with their neighbours along r, s and t in right-handed order.
constexpr int kHexEdges[8][4] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                 {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};

double relative(double determinant, double lengths) {
    return lengths > 0 ? determinant / lengths : 0;
}

/// 1 for perpendicular edges, 0 for coplanar ones, negative for inverted ones.
double squareness(Vec3d a, Vec3d b, Vec3d c) {
    return relative(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c));
}

double worst_corner(const HexMesh& mesh, const std::array<std::int32_t, 8>& cell) {
    double worst = 1;
    for (const auto& e : kHexEdges) {
        const auto position = [&](int n) {
            return mesh.nodes_mm[std::size_t(cell[std::size_t(e[n])])];
        };
        const Vec3d at = position(0);
        worst = std::min(worst, squareness(position(1) - at, position(2) - at, position(3) - at));
    }
    return worst;
}
double worst_corner(const TetMesh& mesh, const std::array<std::int32_t, 4>& cell) {
    const auto position = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(cell[n])]; };
    const Vec3d at = position(0);
    return squareness(position(1) - at, position(2) - at, position(3) - at);
}
double worst_corner(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& cell) {
    const auto position = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(cell[n])]; };
    const Vec3d a = position(1) - position(0), b = position(2) - position(0);
    return relative(norm(cross(a, b)), norm(a) * norm(b));
}

Error bad_mesh(const std::string& what) {
    return {ErrorCode::InvalidArgument, "mesh: " + what};
}
std::string cell_name(std::size_t cell) {
    return "cell " + std::to_string(cell);
}

template <class Mesh>
Status check_cells_of(const Mesh& mesh) {
    if (mesh.cells.empty()) return bad_mesh("found no cells, expected one or more");
    const auto node_count = std::int64_t(mesh.nodes_mm.size());
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
        if (!is_finite(mesh.nodes_mm[n]))
            return bad_mesh("node " + std::to_string(n) + " has a position that is not finite");
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        auto sorted = mesh.cells[c];
        for (const std::int32_t node : sorted)
            if (node < 0 || node >= node_count)
                return bad_mesh(cell_name(c) + " names node " + std::to_string(node) +
                                ", expected 0…" + std::to_string(node_count - 1));
        std::sort(sorted.begin(), sorted.end());
        const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
        if (twice != sorted.end())
            return bad_mesh(cell_name(c) + " names node " + std::to_string(*twice) +
                            " twice, expected distinct corners");
        const double worst = worst_corner(mesh, mesh.cells[c]);
        if (!(worst >= kFlattestCorner))
            return bad_mesh(cell_name(c) + " is " +
                            (worst < -kFlattestCorner ? "inverted" : "flat") +
                            " at a corner, expected a right-handed, convex one");
    }
    return Ok{};
}

template <class Mesh>
std::vector<std::int32_t> pieces_of(const Mesh& mesh) {
    // Union-find; the smallest node represents a piece.
    std::vector<std::int32_t> parent(mesh.nodes_mm.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t n) {
        while (parent[std::size_t(n)] != n) {
            auto& up = parent[std::size_t(n)];
            up = parent[std::size_t(up)];
            n = up;
        }
        return n;
    };
    for (const auto& cell : mesh.cells)
        for (const std::int32_t node : cell) {
            const std::int32_t a = root(cell[0]), b = root(node);
            parent[std::size_t(std::max(a, b))] = std::min(a, b);
        }
    std::vector<std::int32_t> piece(parent.size());
    std::int32_t count = 0;
    for (std::size_t n = 0; n < piece.size(); ++n) {
        const auto r = std::size_t(root(std::int32_t(n)));
        piece[n] = r == n ? count++ : piece[r];
    }
    return piece;
}

template <class Mesh>
Status check_mesh_of(const Mesh& mesh) {
    if (const Status cells = check_cells_of(mesh); !cells) return cells;
    std::vector<bool> used(mesh.nodes_mm.size(), false);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t node : cell) used[std::size_t(node)] = true;
    const auto unused = std::find(used.begin(), used.end(), false);
    if (unused != used.end())
        return bad_mesh("node " + std::to_string(unused - used.begin()) +
                        " belongs to no cell, expected each to be used");
    const auto piece = pieces_of(mesh);
    const auto other = std::find(piece.begin(), piece.end(), 1);
    if (other != piece.end())
        return bad_mesh("node " + std::to_string(other - piece.begin()) +
                        " is not connected to node 0 (there are " +
                        std::to_string(*std::max_element(piece.begin(), piece.end()) + 1) +
                        " pieces), expected one piece");
    return Ok{};
}

}  // namespace

std::vector<std::int32_t> pieces(const HexMesh& mesh) {
    return pieces_of(mesh);
}
std::vector<std::int32_t> pieces(const TetMesh& mesh) {
    return pieces_of(mesh);
}
std::vector<std::int32_t> pieces(const TriangleMesh& mesh) {
    return pieces_of(mesh);
}

Status check_cells(const HexMesh& mesh) {
    return check_cells_of(mesh);
}
Status check_cells(const TetMesh& mesh) {
    return check_cells_of(mesh);
}
Status check_cells(const TriangleMesh& mesh) {
    return check_cells_of(mesh);
}

Status check_mesh(const HexMesh& mesh) {
    return check_mesh_of(mesh);
}
Status check_mesh(const TetMesh& mesh) {
    return check_mesh_of(mesh);
}
Status check_mesh(const TriangleMesh& mesh) {
    return check_mesh_of(mesh);
}

}  // namespace pliant
