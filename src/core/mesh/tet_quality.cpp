// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/text.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

/// Face opposite to each corner, outward.
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Face {
    std::array<std::int32_t, 3> sorted;
    std::int32_t cell;
    std::int32_t number;
};

std::vector<Face> sorted_faces(const TetMesh& mesh) {
    std::vector<Face> faces;
    faces.reserve(4 * mesh.cells.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (int f = 0; f < 4; ++f) {
            Face face{{}, std::int32_t(c), f};
            for (std::size_t n = 0; n < 3; ++n)
                face.sorted[n] = mesh.cells[c][std::size_t(kFaces[f][n])];
            std::sort(face.sorted.begin(), face.sorted.end());
            faces.push_back(face);
        }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
        return std::pair(a.sorted, a.cell) < std::pair(b.sorted, b.cell);
    });
    return faces;
}

/// Calls body(first, count) for each group of equal faces.
template <class Body>
void for_each_face(const std::vector<Face>& faces, const Body& body) {
    for (std::size_t n = 0; n < faces.size();) {
        std::size_t end = n + 1;
        while (end < faces.size() && faces[end].sorted == faces[n].sorted) ++end;
        body(faces[n], end - n);
        n = end;
    }
}

std::vector<std::array<std::int32_t, 3>> single_faces(const TetMesh& mesh,
                                                      const std::vector<Face>& faces,
                                                      std::vector<std::int32_t>* cells) {
    std::vector<std::pair<std::int32_t, std::int32_t>> single;
    for_each_face(faces, [&](const Face& face, std::size_t count) {
        if (count == 1) single.emplace_back(face.cell, face.number);
    });
    std::sort(single.begin(), single.end());
    std::vector<std::array<std::int32_t, 3>> triangles;
    triangles.reserve(single.size());
    for (const auto& [cell, number] : single) {
        const auto& corners = mesh.cells[std::size_t(cell)];
        const auto& f = kFaces[number];
        triangles.push_back(
            {corners[std::size_t(f[0])], corners[std::size_t(f[1])], corners[std::size_t(f[2])]});
        if (cells) cells->push_back(cell);
    }
    return triangles;
}

/// 3 · inscribed / circumscribed radius, 0 if flat.
double radius_ratio(const std::array<Vec3d, 4>& p, double volume) {
    double area = 0;
    for (const auto& f : kFaces)
        area += 0.5 * norm(cross(p[std::size_t(f[1])] - p[std::size_t(f[0])],
                                 p[std::size_t(f[2])] - p[std::size_t(f[0])]));
    const Vec3d a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
    const Vec3d to_centre =
        dot(a, a) * cross(b, c) + dot(b, b) * cross(c, a) + dot(c, c) * cross(a, b);
    const double circumscribed_by_12_volumes = norm(to_centre);
    if (!(circumscribed_by_12_volumes > 0) || !(area > 0)) return 0;
    // inscribed = 3 V / area, circumscribed = |…| / (12 V)
    return 3 * (3 * volume / area) * (12 * volume / circumscribed_by_12_volumes);
}

}  // namespace

std::vector<std::array<std::int32_t, 3>> boundary_faces(const TetMesh& mesh,
                                                        std::vector<std::int32_t>* cells) {
    if (cells) cells->clear();
    return single_faces(mesh, sorted_faces(mesh), cells);
}

TriangleMesh part_of(std::span<const Vec3d> nodes_mm,
                     std::span<const std::array<std::int32_t, 3>> triangles,
                     std::vector<std::int32_t>* nodes) {
    std::vector<std::int32_t> number(nodes_mm.size(), -1);
    for (const auto& t : triangles)
        for (const std::int32_t n : t) number[std::size_t(n)] = 0;
    TriangleMesh part;
    if (nodes) nodes->clear();
    for (std::size_t n = 0; n < number.size(); ++n) {
        if (number[n] < 0) continue;
        number[n] = std::int32_t(part.nodes_mm.size());
        part.nodes_mm.push_back(nodes_mm[n]);
        if (nodes) nodes->push_back(std::int32_t(n));
    }
    part.cells.assign(triangles.begin(), triangles.end());
    for (auto& t : part.cells)
        for (std::int32_t& n : t) n = number[std::size_t(n)];
    return part;
}

TriangleMesh joined(const TriangleMesh& surface) {
    // Sorted by position, then by number: the first of equal nodes represents all.
    std::vector<std::int32_t> order(surface.nodes_mm.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](std::int32_t n) {
        const Vec3d p = surface.nodes_mm[std::size_t(n)];
        return std::tuple(p.x, p.y, p.z);
    };
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        return key(a) != key(b) ? key(a) < key(b) : a < b;
    });
    std::vector<std::int32_t> same(order.size());
    for (std::size_t n = 0; n < order.size(); ++n)
        same[std::size_t(order[n])] = n > 0 && key(order[n]) == key(order[n - 1])
                                          ? same[std::size_t(order[n - 1])]
                                          : order[n];
    std::vector<std::array<std::int32_t, 3>> triangles;
    for (auto t : surface.cells) {
        for (std::int32_t& n : t) n = same[std::size_t(n)];
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    return part_of(surface.nodes_mm, triangles);
}

TetMesh with_used_nodes(const TetMesh& mesh) {
    std::vector<std::int32_t> number(mesh.nodes_mm.size(), -1);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t n : cell) number[std::size_t(n)] = 0;
    TetMesh used{{}, mesh.cells};
    for (std::size_t n = 0; n < number.size(); ++n) {
        if (number[n] < 0) continue;
        number[n] = std::int32_t(used.nodes_mm.size());
        used.nodes_mm.push_back(mesh.nodes_mm[n]);
    }
    for (auto& cell : used.cells)
        for (std::int32_t& n : cell) n = number[std::size_t(n)];
    return used;
}

TriangleMesh boundary_triangles(const TetMesh& mesh, std::vector<std::int32_t>* nodes) {
    return part_of(mesh.nodes_mm, boundary_faces(mesh), nodes);
}

TetQuality tet_quality(const TetMesh& mesh) {
    TetQuality q;
    q.nodes = std::int64_t(mesh.nodes_mm.size());
    q.tetrahedra = std::int64_t(mesh.cells.size());
    double least_edge = std::numeric_limits<double>::infinity(), largest_edge = 0;
    double least_cosine = 1, largest_cosine = -1, ratios = 0;
    for (const auto& cell : mesh.cells) {
        std::array<Vec3d, 4> p;
        for (std::size_t n = 0; n < 4; ++n) p[n] = mesh.nodes_mm[std::size_t(cell[n])];
        const double volume = dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) / 6;
        q.volume_mm3 += volume;
        if (!(volume > 0)) ++q.inverted;
        const double ratio = radius_ratio(p, volume) * (volume < 0 ? -1 : 1);
        q.min_radius_ratio = std::min(q.min_radius_ratio, ratio);
        ratios += ratio;
        Vec3d normals[4];
        for (std::size_t f = 0; f < 4; ++f) {
            const auto& at = kFaces[f];
            const Vec3d n = cross(p[std::size_t(at[1])] - p[std::size_t(at[0])],
                                  p[std::size_t(at[2])] - p[std::size_t(at[0])]);
            normals[f] = norm(n) > 0 ? normalized(n) : n;
        }
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b) {
                const double length = norm(p[a] - p[b]);
                least_edge = std::min(least_edge, length);
                largest_edge = std::max(largest_edge, length);
                // Angle between the faces opposite to a and b, at the edge of the other two
                // corners.
                const double cosine = -dot(normals[a], normals[b]);
                least_cosine = std::min(least_cosine, cosine);
                largest_cosine = std::max(largest_cosine, cosine);
            }
    }
    const auto degrees = [](double cosine) {
        return std::acos(std::clamp(cosine, -1.0, 1.0)) * (180 / std::numbers::pi);
    };
    const auto faces = sorted_faces(mesh);
    for_each_face(faces, [&](const Face&, std::size_t count) {
        if (count > 2) ++q.non_manifold_faces;
    });
    q.boundary = surface_topology(single_faces(mesh, faces, nullptr), mesh.nodes_mm.size());
    if (mesh.cells.empty()) return q;
    q.min_dihedral_deg = degrees(largest_cosine);
    q.largest_dihedral_deg = degrees(least_cosine);
    q.mean_radius_ratio = ratios / double(q.tetrahedra);
    q.shortest_edge_mm = least_edge;
    q.longest_edge_mm = largest_edge;
    const auto piece = pieces(mesh);
    if (!piece.empty()) q.pieces = *std::max_element(piece.begin(), piece.end()) + 1;
    return q;
}

Status check_quality(const TetQuality& q) {
    const auto wrong = [](std::int64_t count, const char* what, const char* expected) {
        return Error{ErrorCode::InvalidArgument, "mesh: found " + std::to_string(count) + " " +
                                                     what + ", expected " + expected};
    };
    if (q.tetrahedra == 0) return wrong(0, "tetrahedra", "one or more");
    if (q.inverted) return wrong(q.inverted, "inverted or flat tetrahedra", "none");
    if (q.non_manifold_faces)
        return wrong(q.non_manifold_faces, "faces of three tetrahedra or more",
                     "two at most at each");
    if (q.boundary.open_edges)
        return wrong(q.boundary.open_edges, "open edges of the boundary", "none");
    if (q.boundary.non_manifold_edges || q.boundary.pinched_nodes)
        return wrong(q.boundary.non_manifold_edges + q.boundary.pinched_nodes,
                     "edges and nodes where the boundary touches itself", "a manifold one");
    return Ok{};
}

std::string describe(const TetQuality& q) {
    const auto count = [](std::int64_t n) { return std::to_string(n); };
    std::string text;
    text += "tetrahedra          " + count(q.tetrahedra) + ", " + count(q.nodes) + " nodes, " +
            count(q.pieces) + (q.pieces == 1 ? " piece\n" : " pieces\n");
    text += "inverted            " + count(q.inverted) + "\n";
    text += "volume              " + fixed_text(q.volume_mm3, 1) + " mm3\n";
    text += "dihedral angles     " + fixed_text(q.min_dihedral_deg, 2) + " to " +
            fixed_text(q.largest_dihedral_deg, 2) + " degrees\n";
    text += "radius ratio        " + fixed_text(q.min_radius_ratio, 3) + " at least, " +
            fixed_text(q.mean_radius_ratio, 3) + " on average\n";
    text += "edges               " + fixed_text(q.shortest_edge_mm, 3) + " to " +
            fixed_text(q.longest_edge_mm, 3) + " mm\n";
    text += "boundary            " + count(q.boundary.pieces) +
            (q.boundary.pieces == 1 ? " piece, " : " pieces, ") + "Euler characteristic " +
            count(q.boundary.euler) + ", " + count(q.boundary.open_edges) + " open and " +
            count(q.boundary.non_manifold_edges + q.boundary.pinched_nodes) +
            " non-manifold edges and nodes";
    return text;
}

}  // namespace pliant
