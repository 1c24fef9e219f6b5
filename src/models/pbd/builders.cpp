// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/pbd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pbd/solver.h"

namespace pliant {
namespace {

using Face = std::array<std::int32_t, 3>;

/// Faces of one tetrahedron only, outward by the right-hand rule.
std::vector<Face> boundary_of(const TetMesh& mesh) {
    constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    struct Entry {
        Face sorted, face;
    };
    std::vector<Entry> entries;
    entries.reserve(4 * mesh.cells.size());
    for (const auto& cell : mesh.cells)
        for (const auto& f : kFaces) {
            const Face face{cell[std::size_t(f[0])], cell[std::size_t(f[1])],
                            cell[std::size_t(f[2])]};
            Face sorted = face;
            std::sort(sorted.begin(), sorted.end());
            entries.push_back({sorted, face});
        }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.sorted < b.sorted; });
    std::vector<Face> boundary;
    for (std::size_t n = 0, end = 0; n < entries.size(); n = end) {
        while (end < entries.size() && entries[end].sorted == entries[n].sorted) ++end;
        if (end - n == 1) boundary.push_back(entries[n].face);
    }
    return boundary;
}

void add_bends(const TetMesh& mesh, const PbdMaterial& material, PbdParts& parts) {
    struct Side {
        std::int32_t low, high, other;
        bool reversed;
    };
    std::vector<Side> sides;
    for (const Face& f : boundary_of(mesh))
        for (std::size_t n = 0; n < 3; ++n) {
            const std::int32_t a = f[n], b = f[(n + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), f[(n + 2) % 3], a > b});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) != std::pair(b.low, b.high)
                   ? std::pair(a.low, a.high) < std::pair(b.low, b.high)
                   : std::pair(a.reversed, a.other) < std::pair(b.reversed, b.other);
    });
    for (std::size_t n = 0, end = 0; n < sides.size(); n = end) {
        while (end < sides.size() && sides[end].low == sides[n].low &&
               sides[end].high == sides[n].high)
            ++end;
        if (end - n != 2) continue;  // edges of more than two triangles have no unique angle
        parts.bends.push_back(
            {.nodes = {sides[n].low, sides[n].high, sides[n].other, sides[n + 1].other},
             .compliance = material.bend_compliance});
    }
}

void add_edges(const TetMesh& mesh, const PbdMaterial& material, PbdParts& parts) {
    std::vector<std::array<std::int32_t, 2>> edges;
    edges.reserve(6 * mesh.cells.size());
    for (const auto& cell : mesh.cells)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                edges.push_back({std::min(cell[a], cell[b]), std::max(cell[a], cell[b])});
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    parts.distances.reserve(edges.size());
    for (const auto& edge : edges)
        parts.distances.push_back({.nodes = edge, .compliance = material.edge_compliance});
}

}  // namespace

Result<PbdParts> pbd_of_mesh(const TetMesh& mesh, const PbdMaterial& material) {
    if (const Status s = check_cells(mesh); !s.ok()) return s.error();
    if (!(std::isfinite(material.density) && material.density > 0))
        return Error{ErrorCode::InvalidArgument,
                     "density: expected one above 0, found " + std::to_string(material.density)};
    PbdParts parts;
    parts.positions = mesh.nodes_mm;
    std::vector<double> masses(mesh.nodes_mm.size(), 0);
    for (const auto& cell : mesh.cells) {
        const double mass = material.density * pbd::tetrahedron_volume(cell, mesh.nodes_mm);
        for (const std::int32_t n : cell) masses[std::size_t(n)] += mass / 4;
        if (material.volumes)
            parts.volumes.push_back({.nodes = cell, .compliance = material.volume_compliance});
        if (material.solids)
            parts.solids.push_back({.nodes = cell,
                                    .young_modulus = material.young_modulus,
                                    .poisson_ratio = material.poisson_ratio,
                                    .ogden_alpha = material.ogden_alpha});
    }
    for (const double mass : masses) parts.inverse_masses.push_back(mass > 0 ? 1 / mass : 0);
    if (material.edges) add_edges(mesh, material, parts);
    if (material.bends) add_bends(mesh, material, parts);
    if (const Status s = pbd::check_parts(parts, PbdMethod::Compliance); !s.ok()) return s.error();
    return parts;
}

TetMesh five_tet_block(Vec3i cells, double side) {
    PLIANT_ASSERT(cells.x > 0 && cells.y > 0 && cells.z > 0 && side > 0);
    // Corners by their bits x, y, z; the central one last. The second cube mirrors the first along
    // x.
    constexpr int kCorners[2][5][4] = {
        {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}},
        {{1, 5, 3, 0}, {2, 6, 0, 3}, {4, 0, 6, 5}, {7, 3, 5, 6}, {0, 6, 3, 5}}};
    const HexLattice lattice{.size = {cells.x + 1, cells.y + 1, cells.z + 1},
                             .spacing_mm = {side, side, side}};
    TetMesh mesh;
    for (std::int32_t n = 0; n < node_count(lattice); ++n)
        mesh.nodes_mm.push_back(node_position_mm(lattice, n));
    for (int k = 0; k < cells.z; ++k)
        for (int j = 0; j < cells.y; ++j)
            for (int i = 0; i < cells.x; ++i)
                for (const auto& tetrahedron : kCorners[(i + j + k) % 2]) {
                    std::array<std::int32_t, 4> cell{};
                    for (std::size_t n = 0; n < 4; ++n) {
                        const int bits = tetrahedron[n];
                        cell[n] = node_index(
                            lattice, {i + (bits & 1), j + (bits >> 1 & 1), k + (bits >> 2)});
                    }
                    const auto at = [&](std::size_t n) {
                        return mesh.nodes_mm[std::size_t(cell[n])];
                    };
                    if (dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) < 0)
                        std::swap(cell[2], cell[3]);
                    mesh.cells.push_back(cell);
                }
    return mesh;
}

}  // namespace pliant
