// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Faces of one hexahedron only: faces are sorted by their nodes, so that equal ones are adjacent.

#include <pliant/mesh.h>

#include <algorithm>
#include <utility>

namespace pliant {

std::vector<HexFace> boundary_faces(const HexMesh& mesh) {
    using Nodes = std::array<std::int32_t, 4>;
    std::vector<std::pair<Nodes, HexFace>> faces;
    faces.reserve(6 * mesh.cells.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (int f = 0; f < 6; ++f) {
            Nodes nodes;
            for (std::size_t n = 0; n < 4; ++n)
                nodes[n] = mesh.cells[c][std::size_t(kHexFaceCorners[f][n])];
            std::sort(nodes.begin(), nodes.end());
            faces.emplace_back(nodes, HexFace{std::int32_t(c), f});
        }
    std::sort(faces.begin(), faces.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<HexFace> single;
    for (std::size_t n = 0; n < faces.size();) {
        std::size_t end = n + 1;
        while (end < faces.size() && faces[end].first == faces[n].first) ++end;
        if (end == n + 1) single.push_back(faces[n].second);
        n = end;
    }
    std::sort(single.begin(), single.end(), [](const HexFace& a, const HexFace& b) {
        return std::pair(a.cell, a.face) < std::pair(b.cell, b.face);
    });
    return single;
}

TriangleMesh boundary_triangles(const HexMesh& mesh) {
    TriangleMesh surface;
    std::vector<std::int32_t> number(mesh.nodes_mm.size(), -1);
    for (const HexFace& f : boundary_faces(mesh)) {
        std::int32_t at[4];
        for (std::size_t n = 0; n < 4; ++n) {
            const auto node = std::size_t(
                mesh.cells[std::size_t(f.cell)][std::size_t(kHexFaceCorners[f.face][n])]);
            if (number[node] < 0) {
                number[node] = std::int32_t(surface.nodes_mm.size());
                surface.nodes_mm.push_back(mesh.nodes_mm[node]);
            }
            at[n] = number[node];
        }
        surface.cells.push_back({at[0], at[1], at[2]});
        surface.cells.push_back({at[0], at[2], at[3]});
    }
    return surface;
}

}  // namespace pliant
