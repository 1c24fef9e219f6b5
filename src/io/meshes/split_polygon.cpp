// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Triangles of a polygon. A fan around the first corner is right if all of its triangles face as
// the polygon does, as those of convex polygons do:
//
//     4 ──── 3               4 ────────── 3      The fan 0 1 2, 0 2 3, … of the right polygon
//     │ ╲  ╱ │               │   5 ── 2 ──┘      leaves it. Ears are cut off instead: convex
//     │ ╱ ╲  │               │   │               corners whose triangle has no other corner
//     0 ──── 1               0 ─ 1               in it [Meisters1975].

#include <algorithm>
#include <array>
#include <cmath>

#include "meshes/file_numbers.h"

namespace pliant::mesh {
namespace {

struct Point {
    double x, y;
};
/// Twice the signed area of a triangle.
double area(Point a, Point b, Point c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// A polygon in its own plane, counterclockwise. Cut corners leave the ring.
class Ring {
  public:
    explicit Ring(std::vector<Point> corners) : m_corners(std::move(corners)) {
        m_ring.resize(m_corners.size());
        for (std::size_t n = 0; n < m_ring.size(); ++n) m_ring[n] = n;
    }
    /// Cuts the next ear off. @returns its corners; nothing if there is none
    std::optional<std::array<std::size_t, 3>> cut_ear() {
        for (std::size_t tried = 0; tried < m_ring.size(); ++tried) {
            const std::size_t at = (m_next + tried) % m_ring.size();
            const auto ear = triangle_at(at);
            if (!is_ear(ear)) continue;
            m_ring.erase(m_ring.begin() + std::ptrdiff_t(at));
            // One corner is passed, so that the triangles aren't all at one corner.
            m_next = (at + 1) % m_ring.size();
            return ear;
        }
        return std::nullopt;
    }
    std::size_t size() const { return m_ring.size(); }
    const std::vector<std::size_t>& corners() const { return m_ring; }

  private:
    std::array<std::size_t, 3> triangle_at(std::size_t at) const {
        const std::size_t count = m_ring.size();
        return {m_ring[(at + count - 1) % count], m_ring[at], m_ring[(at + 1) % count]};
    }
    bool is_ear(const std::array<std::size_t, 3>& ear) const {
        const Point a = m_corners[ear[0]], b = m_corners[ear[1]], c = m_corners[ear[2]];
        if (!(area(a, b, c) > 0)) return false;
        return std::none_of(m_ring.begin(), m_ring.end(), [&](std::size_t n) {
            const Point p = m_corners[n];
            const auto is = [p](Point q) { return p.x == q.x && p.y == q.y; };
            return !is(a) && !is(b) && !is(c) && area(a, b, p) >= 0 && area(b, c, p) >= 0 &&
                   area(c, a, p) >= 0;
        });
    }
    std::vector<Point> m_corners;
    std::vector<std::size_t> m_ring;
    std::size_t m_next = 0;
};

/// Projects corners along the coordinate in which the normal is largest, with its sense.
std::vector<Point> in_plane(std::span<const Vec3d> corners, Vec3d normal) {
    int along = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(normal[a]) > std::abs(normal[along])) along = a;
    int x = (along + 1) % 3, y = (along + 2) % 3;
    if (normal[along] < 0) std::swap(x, y);
    std::vector<Point> points;
    for (const Vec3d& p : corners) points.push_back({p[x], p[y]});
    return points;
}

}  // namespace

void add_note(MeshData& mesh, const std::string& note) {
    if (std::find(mesh.notes.begin(), mesh.notes.end(), note) == mesh.notes.end())
        mesh.notes.push_back(note);
}

Status add_polygon(MeshData& mesh, std::span<const std::int64_t> nodes) {
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        mesh.triangles.push_back(
            {std::int32_t(nodes[a]), std::int32_t(nodes[b]), std::int32_t(nodes[c])});
    };
    const auto add_fan = [&] {
        for (std::size_t n = 1; n + 1 < nodes.size(); ++n) add(0, n, n + 1);
    };
    if (nodes.size() <= 3) {
        add_fan();
        return Ok{};
    }
    std::vector<Vec3d> corners, normals;
    for (const std::int64_t n : nodes) corners.push_back(mesh.nodes_mm[std::size_t(n)]);
    Vec3d normal{0, 0, 0};
    for (std::size_t n = 1; n + 1 < corners.size(); ++n) {
        normals.push_back(cross(corners[n] - corners[0], corners[n + 1] - corners[0]));
        normal = normal + normals.back();
    }
    // Rounded corners on a straight side may be concave by a little.
    constexpr double kConcave = -1e-6;
    if (std::all_of(normals.begin(), normals.end(),
                    [&](Vec3d n) { return !(dot(n, normal) < kConcave * dot(normal, normal)); })) {
        add_fan();
        return Ok{};
    }
    if (nodes.size() > kMaxConcaveCorners)
        return unsupported("a concave polygon of " + std::to_string(nodes.size()) +
                           " corners, expected up to " + std::to_string(kMaxConcaveCorners));
    Ring ring(in_plane(corners, normal));
    while (ring.size() > 3) {
        const auto ear = ring.cut_ear();
        if (!ear) break;
        add((*ear)[0], (*ear)[1], (*ear)[2]);
    }
    const auto& rest = ring.corners();
    if (rest.size() > 3) add_note(mesh, "polygons that cross themselves were split into fans");
    for (std::size_t n = 1; n + 1 < rest.size(); ++n) add(rest[0], rest[n], rest[n + 1]);
    return Ok{};
}

}  // namespace pliant::mesh
