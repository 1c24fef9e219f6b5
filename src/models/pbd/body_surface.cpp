// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/body_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mesh/triangle_distance.h"

namespace pliant::pbd {
namespace {

constexpr std::size_t kPatchTriangles = 32;

Vec3d direction_of(Vec3d v) {
    const double length = norm(v);
    return length > 0 ? (1 / length) * v : Vec3d{0, 0, 0};
}

}  // namespace

BodySurface::BodySurface(const TetMesh& mesh, std::span<const std::int32_t> pieces) {
    std::vector<std::int32_t> owners;
    const auto faces = boundary_faces(mesh, &owners);
    std::vector<std::int32_t> order(faces.size());
    std::iota(order.begin(), order.end(), 0);
    const auto piece_of_face = [&](std::int32_t f) {
        return pieces[std::size_t(owners[std::size_t(f)])];
    };
    std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        return piece_of_face(a) < piece_of_face(b);
    });
    std::vector<std::int32_t> ends;  // of patches
    for (std::size_t begin = 0; begin < order.size();) {
        std::size_t end = begin;
        while (end < order.size() && piece_of_face(order[end]) == piece_of_face(order[begin]))
            ++end;
        split(mesh, std::span(order).subspan(begin, end - begin), faces, ends);
        begin = end;
    }
    for (const std::int32_t f : order) {
        m_triangles.push_back(faces[std::size_t(f)]);
        m_triangle_pieces.push_back(piece_of_face(f));
    }
    for (std::size_t p = 0, begin = 0; p < ends.size(); begin = std::size_t(ends[p++]))
        m_patches.push_back({std::int32_t(begin), ends[p], 0, 0, 0, m_triangle_pieces[begin]});
    number_nodes(mesh);
    find_neighbours();
}

/// Orders triangles so that patches are contiguous. @param[out] ends  of the patches, appended
void BodySurface::split(const TetMesh& mesh, std::span<std::int32_t> triangles,
                        const std::vector<std::array<std::int32_t, 3>>& faces,
                        std::vector<std::int32_t>& ends) const {
    if (triangles.size() <= kPatchTriangles) {
        std::sort(triangles.begin(), triangles.end());
        const std::int32_t last = ends.empty() ? 0 : ends.back();
        ends.push_back(last + std::int32_t(triangles.size()));
        return;
    }
    const auto centre = [&](std::int32_t f) {
        const auto& t = faces[std::size_t(f)];
        return mesh.nodes_mm[std::size_t(t[0])] + mesh.nodes_mm[std::size_t(t[1])] +
               mesh.nodes_mm[std::size_t(t[2])];
    };
    const std::size_t middle = mesh::halve(triangles, centre);
    split(mesh, triangles.first(middle), faces, ends);
    split(mesh, triangles.subspan(middle), faces, ends);
}

/// Numbers the nodes in the order of the patches, so that those of a patch are near in memory.
void BodySurface::number_nodes(const TetMesh& mesh) {
    std::vector<std::int32_t> number(mesh.nodes_mm.size(), -1), seen, owner;
    double edges = 0;
    for (std::size_t p = 0; p < m_patches.size(); ++p) {
        Patch& patch = m_patches[p];
        patch.nodes_begin = std::int32_t(m_patch_nodes.size());
        for (std::int32_t t = patch.begin; t < patch.end; ++t)
            for (std::int32_t& n : m_triangles[std::size_t(t)]) {
                std::int32_t& found = number[std::size_t(n)];
                if (found < 0) {
                    found = std::int32_t(m_particles.size());
                    m_particles.push_back(n);
                    m_pieces.push_back(patch.piece);
                    seen.push_back(-1);
                    owner.push_back(std::int32_t(p));
                }
                n = found;
                if (m_pieces[std::size_t(n)] != patch.piece) m_pieces[std::size_t(n)] = -1;
                if (seen[std::size_t(n)] == std::int32_t(p)) continue;
                seen[std::size_t(n)] = std::int32_t(p);
                m_patch_nodes.push_back(n);
            }
        patch.nodes_end = std::int32_t(m_patch_nodes.size());
        const auto own = std::stable_partition(
            m_patch_nodes.begin() + patch.nodes_begin, m_patch_nodes.end(),
            [&](std::int32_t n) { return owner[std::size_t(n)] == std::int32_t(p); });
        patch.owned_end = std::int32_t(own - m_patch_nodes.begin());
    }
    for (const auto& t : m_triangles)
        for (std::size_t k = 0; k < 3; ++k)
            edges += norm(mesh.nodes_mm[std::size_t(m_particles[std::size_t(t[k])])] -
                          mesh.nodes_mm[std::size_t(m_particles[std::size_t(t[(k + 1) % 3])])]);
    m_mean_edge = edges / (3.0 * double(m_triangles.size()));
}

void BodySurface::find_neighbours() {
    struct Edge {
        std::int32_t low, high, triangle, side;
    };
    std::vector<Edge> edges;
    m_neighbours.assign(m_triangles.size(), {-1, -1, -1});
    for (std::size_t t = 0; t < m_triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const auto a = m_triangles[t][std::size_t(k)],
                       b = m_triangles[t][std::size_t((k + 1) % 3)];
            edges.push_back({std::min(a, b), std::max(a, b), std::int32_t(t), k});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
        const Edge &a = edges[e], &b = edges[e + 1];
        if (a.low != b.low || a.high != b.high) continue;
        m_neighbours[std::size_t(a.triangle)][std::size_t(a.side)] = b.triangle;
        m_neighbours[std::size_t(b.triangle)][std::size_t(b.side)] = a.triangle;
        ++e;
    }
    m_ring_starts.assign(m_particles.size() + 1, 0);
    for (const auto& t : m_triangles)
        for (const std::int32_t n : t) ++m_ring_starts[std::size_t(n)];
    std::int32_t sum = 0;
    for (std::int32_t& start : m_ring_starts) start = sum += start;
    m_rings.resize(std::size_t(sum));
    for (std::size_t t = m_triangles.size(); t-- > 0;)
        for (const std::int32_t n : m_triangles[t])
            m_rings[std::size_t(--m_ring_starts[std::size_t(n)])] = std::int32_t(t);
}

/// Normal, with twice the area as its length.
Vec3d BodySurface::face_area(std::int32_t triangle, std::span<const Vec3d> x) const {
    const auto& t = m_triangles[std::size_t(triangle)];
    const Vec3d a = x[std::size_t(t[0])];
    return cross(x[std::size_t(t[1])] - a, x[std::size_t(t[2])] - a);
}

Vec3d BodySurface::face_normal(std::int32_t triangle, std::span<const Vec3d> x) const {
    return direction_of(face_area(triangle, x));
}

Vec3d BodySurface::normal(std::int32_t triangle, int feature, std::span<const Vec3d> x) const {
    if (feature == 6) return face_normal(triangle, x);
    const auto& own = m_triangles[std::size_t(triangle)];
    if (feature >= 3) {
        const std::int32_t other = m_neighbours[std::size_t(triangle)][std::size_t(feature - 3)];
        const Vec3d n = face_normal(triangle, x);
        return other < 0 ? n : direction_of(n + face_normal(other, x));
    }
    const auto node = std::size_t(own[std::size_t(feature)]);
    Vec3d sum{0, 0, 0};
    for (auto r = std::size_t(m_ring_starts[node]); r < std::size_t(m_ring_starts[node + 1]); ++r) {
        const auto& t = m_triangles[std::size_t(m_rings[r])];
        const std::size_t k = std::size_t(t[0]) == node ? 0 : std::size_t(t[1]) == node ? 1 : 2;
        const Vec3d at = x[node], u = x[std::size_t(t[(k + 1) % 3])] - at,
                    v = x[std::size_t(t[(k + 2) % 3])] - at;
        sum = sum + std::atan2(norm(cross(u, v)), dot(u, v)) * face_normal(m_rings[r], x);
    }
    return direction_of(sum);
}

void BodySurface::nearest_in_patch(std::size_t patch, Vec3d p, std::span<const Vec3d> x,
                                   SurfacePoint& best) const {
    for (std::int32_t t = m_patches[patch].begin; t < m_patches[patch].end; ++t) {
        const auto& nodes = m_triangles[std::size_t(t)];
        const auto found = mesh::nearest_on_triangle(
            p, x[std::size_t(nodes[0])], x[std::size_t(nodes[1])], x[std::size_t(nodes[2])]);
        const Vec3d d = p - found.position;
        if (!(dot(d, d) < best.distance2)) continue;
        best = {t, found.feature, found.position, dot(d, d)};
    }
}

/// The normal is needed only if the adjacent faces disagree.
double BodySurface::side(Vec3d p, const SurfacePoint& nearest, std::span<const Vec3d> x) const {
    const Vec3d d = p - nearest.position;
    const auto is_inside = [&](std::int32_t t) { return dot(d, face_area(t, x)) < 0; };
    const bool inside = is_inside(nearest.triangle);
    bool agree = true;
    if (nearest.feature < 3) {
        const auto node =
            std::size_t(m_triangles[std::size_t(nearest.triangle)][std::size_t(nearest.feature)]);
        for (auto r = std::size_t(m_ring_starts[node]);
             agree && r < std::size_t(m_ring_starts[node + 1]); ++r)
            agree = is_inside(m_rings[r]) == inside;
    } else if (nearest.feature < 6) {
        const std::int32_t other =
            m_neighbours[std::size_t(nearest.triangle)][std::size_t(nearest.feature - 3)];
        agree = other < 0 || is_inside(other) == inside;
    }
    if (agree) return inside ? -1 : 1;
    return dot(d, normal(nearest.triangle, nearest.feature, x)) < 0 ? -1 : 1;
}

double BodySurface::signed_distance(Vec3d p, const SurfacePoint& nearest,
                                    std::span<const Vec3d> x) const {
    return side(p, nearest, x) * std::sqrt(nearest.distance2);
}

}  // namespace pliant::pbd
