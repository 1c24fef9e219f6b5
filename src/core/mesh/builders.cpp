// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Boxes and sheets of nodes, and the meshes between them.

#include <pliant/mesh.h>

#include <cmath>

namespace pliant {
namespace {

/// Position of corner c of a hexahedron, in cells.
constexpr Vec3i kCorner[8] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                              {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// Paths from corner 0 to corner 6 along three edges, one per order of the axes. Each path is a
/// positive tetrahedron.
constexpr int kTetrahedra[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                   {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};

std::vector<Vec3d> positions_mm(const HexLattice& lattice) {
    std::vector<Vec3d> positions(std::size_t(node_count(lattice)));
    for (std::size_t n = 0; n < positions.size(); ++n)
        positions[n] = node_position_mm(lattice, std::int32_t(n));
    return positions;
}

}  // namespace

Vec3d node_position_mm(const HexLattice& l, std::int32_t node) {
    const std::int32_t row = node / l.size.x;
    const Vec3d ijk{double(node % l.size.x), double(row % l.size.y), double(row / l.size.y)};
    return l.origin_mm +
           Vec3d{ijk.x * l.spacing_mm.x, ijk.y * l.spacing_mm.y, ijk.z * l.spacing_mm.z};
}

std::array<std::int32_t, 8> cell_corners(const HexLattice& l, std::int32_t cell) {
    const std::int32_t row = cell / (l.size.x - 1);
    const Vec3i first{cell % (l.size.x - 1), row % (l.size.y - 1), row / (l.size.y - 1)};
    std::array<std::int32_t, 8> corners;
    for (std::size_t c = 0; c < 8; ++c) corners[c] = node_index(l, first + kCorner[c]);
    return corners;
}

Status check_lattice(const HexLattice& l) {
    constexpr std::int64_t kMaxNodes = std::int64_t(1) << 30;
    std::int64_t nodes = 1;
    for (int a = 0; a < 3; ++a) {
        const std::string axis(1, "xyz"[a]);
        if (l.size[a] < 2)
            return Error{ErrorCode::InvalidArgument, "lattice: size." + axis + " is " +
                                                         std::to_string(l.size[a]) +
                                                         ", expected 2 nodes or more"};
        if (!(l.spacing_mm[a] > 0) || !std::isfinite(l.spacing_mm[a]))
            return Error{ErrorCode::InvalidArgument, "lattice: spacing_mm." + axis + " is " +
                                                         std::to_string(l.spacing_mm[a]) +
                                                         ", expected a length above 0"};
        nodes *= l.size[a];
        if (nodes > kMaxNodes)
            return Error{ErrorCode::LimitExceeded, "lattice: found more than " +
                                                       std::to_string(kMaxNodes) +
                                                       " nodes, expected that many at most"};
    }
    if (!is_finite(l.origin_mm))
        return Error{ErrorCode::InvalidArgument, "lattice: origin_mm is not finite"};
    return Ok{};
}

HexMesh hex_mesh(const HexLattice& lattice) {
    HexMesh mesh{positions_mm(lattice), {}};
    mesh.cells.resize(std::size_t(cell_count(lattice)));
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        mesh.cells[c] = cell_corners(lattice, std::int32_t(c));
    return mesh;
}

TetMesh tet_mesh(const HexLattice& lattice) {
    TetMesh mesh{positions_mm(lattice), {}};
    mesh.cells.reserve(6 * std::size_t(cell_count(lattice)));
    for (std::int32_t c = 0; c < cell_count(lattice); ++c) {
        const auto at = cell_corners(lattice, c);
        for (const auto& t : kTetrahedra)
            mesh.cells.push_back({at[std::size_t(t[0])], at[std::size_t(t[1])],
                                  at[std::size_t(t[2])], at[std::size_t(t[3])]});
    }
    return mesh;
}

}  // namespace pliant
