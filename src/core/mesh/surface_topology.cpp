// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Edge statistics of a surface: sides of triangles are sorted by their ends, so that those of one
// edge are adjacent. A node is pinched if its triangles, joined across shared edges, form more than
// one fan: counted by union-find over (triangle, corner).

#include <pliant/mesh.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace pliant {
namespace {

struct Side {
    std::int32_t low, high;
    std::int32_t corner;  ///< 3·triangle + number of the side
    bool along;           ///< oriented from low to high
};

class Groups {
  public:
    explicit Groups(std::size_t count) : m_parent(count) {
        std::iota(m_parent.begin(), m_parent.end(), 0);
    }
    std::int32_t root(std::int32_t n) {
        while (m_parent[std::size_t(n)] != n) {
            auto& up = m_parent[std::size_t(n)];
            up = m_parent[std::size_t(up)];
            n = up;
        }
        return n;
    }
    void join(std::int32_t a, std::int32_t b) {
        a = root(a);
        b = root(b);
        m_parent[std::size_t(std::max(a, b))] = std::min(a, b);
    }

  private:
    std::vector<std::int32_t> m_parent;
};

}  // namespace

SurfaceTopology surface_topology(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t node_count) {
    SurfaceTopology topology;
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    Groups pieces(node_count), fans(3 * triangles.size());
    std::vector<bool> used(node_count, false);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t n = 0; n < 3; ++n) {
            const std::int32_t a = triangles[t][n], b = triangles[t][(n + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), std::int32_t(3 * t + n), a < b});
            pieces.join(a, b);
            used[std::size_t(a)] = true;
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    });
    /// Corner of side s's triangle at one of the side's ends.
    const auto corner_at = [&](const Side& s, std::int32_t node) {
        const std::int32_t first = s.corner - s.corner % 3;
        const auto& t = triangles[std::size_t(s.corner / 3)];
        return first + (t[0] == node ? 0 : t[1] == node ? 1 : 2);
    };
    for (std::size_t n = 0; n < sides.size();) {
        std::size_t end = n + 1;
        while (end < sides.size() && sides[end].low == sides[n].low &&
               sides[end].high == sides[n].high)
            ++end;
        ++topology.edges;
        if (end == n + 1) ++topology.open_edges;
        if (end > n + 2) ++topology.non_manifold_edges;
        if (end == n + 2 && sides[n].along == sides[n + 1].along) ++topology.disagreeing_edges;
        for (std::size_t m = n + 1; m < end; ++m)
            for (const std::int32_t node : {sides[n].low, sides[n].high})
                fans.join(corner_at(sides[n], node), corner_at(sides[m], node));
        n = end;
    }
    std::vector<std::int32_t> fan_count(node_count, 0);
    for (std::size_t c = 0; c < 3 * triangles.size(); ++c)
        if (fans.root(std::int32_t(c)) == std::int32_t(c))
            ++fan_count[std::size_t(triangles[c / 3][c % 3])];
    std::int64_t nodes = 0;
    for (std::size_t n = 0; n < node_count; ++n) {
        if (!used[n]) continue;
        ++nodes;
        if (pieces.root(std::int32_t(n)) == std::int32_t(n)) ++topology.pieces;
        if (fan_count[n] > 1) ++topology.pinched_nodes;
    }
    topology.euler = nodes - topology.edges + std::int64_t(triangles.size());
    return topology;
}

SurfaceTopology surface_topology(const TriangleMesh& surface) {
    return surface_topology(surface.cells, surface.nodes_mm.size());
}

Status check_closed(const TriangleMesh& surface) {
    if (const Status cells = check_cells(surface); !cells) return cells;
    const SurfaceTopology t = surface_topology(surface);
    const auto wrong = [](std::int64_t count, const char* what, const char* expected) {
        return Error{ErrorCode::InvalidArgument, "surface: found " + std::to_string(count) + " " +
                                                     what + ", expected " + expected};
    };
    if (t.open_edges) return wrong(t.open_edges, "open edges", "a closed surface");
    if (t.non_manifold_edges)
        return wrong(t.non_manifold_edges, "edges of three triangles or more",
                     "a manifold surface, two at each edge");
    if (t.disagreeing_edges)
        return wrong(t.disagreeing_edges, "edges where the triangles face different ways",
                     "all to face outwards");
    // Pinched nodes are accepted: the surface still has an inside. Only if such a node is the
    // nearest point, the sign comes from the mean of its fans.
    return Ok{};
}

double enclosed_volume_mm3(const TriangleMesh& surface) {
    if (surface.nodes_mm.empty()) return 0;
    const Vec3d from = surface.nodes_mm[0];
    double sum = 0;
    for (const auto& t : surface.cells)
        sum += dot(surface.nodes_mm[std::size_t(t[0])] - from,
                   cross(surface.nodes_mm[std::size_t(t[1])] - from,
                         surface.nodes_mm[std::size_t(t[2])] - from));
    return sum / 6;
}

// Faces of one hexahedron only: faces are sorted by their nodes, so that equal ones are adjacent.

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
