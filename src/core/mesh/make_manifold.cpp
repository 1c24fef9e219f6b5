// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Removes tetrahedra where the boundary touches itself at an edge or a node. The tetrahedra there
// form groups connected through faces. All but the largest group are removed. A single group means
// that two hollows touch, and the whole group is removed. Each removal may create new such
// positions, so it is repeated; it terminates because each round removes tetrahedra.

#include <pliant/mesh.h>

#include <algorithm>
#include <map>
#include <utility>

namespace pliant {
namespace {

struct Touching {
    std::vector<std::int32_t> nodes;
    std::vector<std::pair<std::int32_t, std::int32_t>> edges;
};

/// Finds edges of four or more boundary triangles, and nodes with more than one fan of triangles.
Touching touching_parts(const std::vector<std::array<std::int32_t, 3>>& faces) {
    Touching found;
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    std::map<std::int32_t, std::vector<std::size_t>> around;
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t n = 0; n < 3; ++n) {
            ++edges[std::minmax(faces[f][n], faces[f][(n + 1) % 3])];
            around[faces[f][n]].push_back(f);
        }
    for (const auto& [edge, count] : edges)
        if (count > 2) found.edges.push_back(edge);
    for (const auto& [node, own] : around) {
        // One fan: a walk across edges at the node reaches all triangles.
        std::vector<std::size_t> reached{own[0]};
        std::vector<bool> done(own.size(), false);
        done[0] = true;
        for (std::size_t r = 0; r < reached.size(); ++r)
            for (std::size_t k = 0; k < own.size(); ++k) {
                if (done[k]) continue;
                int shared = 0;
                for (const std::int32_t a : faces[reached[r]])
                    for (const std::int32_t b : faces[own[k]]) shared += a == b;
                if (shared < 2) continue;
                done[k] = true;
                reached.push_back(own[k]);
            }
        if (reached.size() < own.size()) found.nodes.push_back(node);
    }
    return found;
}

/// Marks the cells of a list except its largest group; all cells if there is one group.
void mark(const TetMesh& mesh, const std::vector<std::int32_t>& cells, std::vector<bool>& gone) {
    std::vector<std::vector<std::int32_t>> groups;
    std::vector<bool> done(cells.size(), false);
    for (std::size_t start = 0; start < cells.size(); ++start) {
        if (done[start]) continue;
        done[start] = true;
        std::vector<std::int32_t> group{cells[start]};
        for (std::size_t g = 0; g < group.size(); ++g)
            for (std::size_t k = 0; k < cells.size(); ++k) {
                if (done[k]) continue;
                std::size_t shared = 0;
                for (const std::int32_t a : mesh.cells[std::size_t(group[g])])
                    for (const std::int32_t b : mesh.cells[std::size_t(cells[k])]) shared += a == b;
                if (shared < 3) continue;  // all contain the edge or node, so the face does too
                done[k] = true;
                group.push_back(cells[k]);
            }
        groups.push_back(std::move(group));
    }
    const auto largest =
        std::max_element(groups.begin(), groups.end(),
                         [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (auto group = groups.begin(); group != groups.end(); ++group)
        if (groups.size() == 1 || group != largest)
            for (const std::int32_t c : *group) gone[std::size_t(c)] = true;
}

}  // namespace

std::int64_t make_manifold(TetMesh& mesh) {
    const std::size_t before = mesh.cells.size();
    for (;;) {
        const Touching touching = touching_parts(boundary_faces(mesh));
        if (touching.nodes.empty() && touching.edges.empty()) break;
        std::map<std::int32_t, std::vector<std::int32_t>> around;
        for (const std::int32_t n : touching.nodes) around[n];
        for (const auto& [a, b] : touching.edges) around[a];
        for (std::size_t c = 0; c < mesh.cells.size(); ++c)
            for (const std::int32_t n : mesh.cells[c])
                if (const auto at = around.find(n); at != around.end())
                    at->second.push_back(std::int32_t(c));
        std::vector<bool> gone(mesh.cells.size(), false);
        for (const std::int32_t n : touching.nodes) mark(mesh, around[n], gone);
        for (const auto& [a, b] : touching.edges) {
            std::vector<std::int32_t> cells = around[a];
            std::erase_if(cells, [&mesh, other = b](std::int32_t c) {
                const auto& cell = mesh.cells[std::size_t(c)];
                return std::find(cell.begin(), cell.end(), other) == cell.end();
            });
            mark(mesh, cells, gone);
        }
        std::size_t kept = 0;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c)
            if (!gone[c]) mesh.cells[kept++] = mesh.cells[c];
        mesh.cells.resize(kept);
    }
    if (mesh.cells.size() == before) return 0;
    mesh = with_used_nodes(mesh);
    return std::int64_t(before - mesh.cells.size());
}

int drop_crumbs(TetMesh& mesh) {
    if (mesh.cells.empty()) return 0;
    const auto piece = pieces(mesh);
    std::vector<std::int64_t> size(mesh.nodes_mm.size(), 0);
    for (const auto& cell : mesh.cells) ++size[std::size_t(piece[std::size_t(cell[0])])];
    const std::int64_t most = *std::max_element(size.begin(), size.end());
    const auto is_crumb = [&](std::int64_t cells) { return cells > 0 && 100 * cells < most; };
    const auto crumbs = std::count_if(size.begin(), size.end(), is_crumb);
    if (crumbs == 0) return 0;
    std::erase_if(mesh.cells, [&](const auto& cell) {
        return is_crumb(size[std::size_t(piece[std::size_t(cell[0])])]);
    });
    mesh = with_used_nodes(mesh);
    return int(crumbs);
}

}  // namespace pliant
