// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pbd/ghost_surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "base/errors.h"

namespace pliant::pbd {
namespace {

constexpr std::size_t kNodeGrain = 256;  ///< nodes per task

Vec3d unit_or_zero(Vec3d v) {
    const double length = norm(v);
    return length > 0 ? (1 / length) * v : Vec3d{0, 0, 0};
}

}  // namespace

Status GhostSurface::check(const TetMesh& mesh, const TriangleMesh& ghost,
                           std::span<const Embedded> ghost_positions) {
    if (ghost.cells.empty()) return invalid("ghost: expected triangles, found none");
    if (ghost_positions.size() != ghost.nodes_mm.size())
        return invalid("ghost_positions: expected one for each of " +
                       std::to_string(ghost.nodes_mm.size()) + " nodes, found " +
                       std::to_string(ghost_positions.size()));
    if (const Status s = check_cells(ghost); !s.ok()) return invalid("ghost: " + s.error().message);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t n : cell)
            if (n < 0 || std::size_t(n) >= mesh.nodes_mm.size())
                return invalid("mesh: expected nodes below " +
                               std::to_string(mesh.nodes_mm.size()) + ", found " +
                               std::to_string(n));
    for (std::size_t n = 0; n < ghost_positions.size(); ++n) {
        const Embedded& e = ghost_positions[n];
        const std::string where = "ghost_positions: node " + std::to_string(n);
        if (e.tetrahedron < 0 || std::size_t(e.tetrahedron) >= mesh.cells.size())
            return invalid(where + ": expected a tetrahedron below " +
                           std::to_string(mesh.cells.size()) + ", found " +
                           std::to_string(e.tetrahedron));
        double sum = 0;
        for (const double w : e.weights) sum += w;
        if (!(std::abs(sum - 1) < 1e-6))
            return invalid(where + ": expected weights whose sum is 1");
    }
    return Ok{};
}

GhostSurface::GhostSurface(const TetMesh& mesh, const TriangleMesh& ghost,
                           std::span<const Embedded> ghost_positions, double margin)
    : m_triangles(ghost.cells),
      m_neighbours(ghost.cells.size(), {-1, -1, -1}),
      m_ring_starts(ghost.nodes_mm.size() + 1, 0),
      m_at_rim(ghost.nodes_mm.size(), false),
      m_positions(ghost.nodes_mm),
      m_margin(margin) {
    for (const Embedded& e : ghost_positions)
        m_rides.push_back({mesh.cells[std::size_t(e.tetrahedron)], e.weights});

    std::map<std::pair<std::int32_t, std::int32_t>, std::pair<std::size_t, int>> open;
    for (std::size_t t = 0; t < m_triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const auto a = m_triangles[t][std::size_t(k)],
                       b = m_triangles[t][std::size_t((k + 1) % 3)];
            const auto other = open.find({b, a});
            if (other == open.end()) {
                open.insert({{a, b}, {t, k}});
                continue;
            }
            const auto [u, l] = other->second;
            m_neighbours[t][std::size_t(k)] = std::int32_t(u);
            m_neighbours[u][std::size_t(l)] = std::int32_t(t);
            open.erase(other);
        }
    for (const auto& [edge, owner] : open)
        m_at_rim[std::size_t(edge.first)] = m_at_rim[std::size_t(edge.second)] = true;

    for (const auto& t : m_triangles)
        for (const std::int32_t n : t) ++m_ring_starts[std::size_t(n)];
    std::int32_t sum = 0;
    for (std::int32_t& start : m_ring_starts) start = sum += start;
    m_rings.resize(std::size_t(sum));
    for (std::size_t t = m_triangles.size(); t-- > 0;)
        for (const std::int32_t n : m_triangles[t])
            m_rings[std::size_t(--m_ring_starts[std::size_t(n)])] = std::int32_t(t);

    m_in_grid = m_marked = m_positions;
    m_moved.resize(2 * (m_positions.size() / kNodeGrain + 1));
    m_grid.fill(m_positions, m_triangles, m_margin);
}

/// Updates `count` nodes. @param node_of  their numbers, without duplicates
/// @param since  reference positions
template <class NodeOf>
double GhostSurface::update_some(const PbdBody& body, std::size_t count, const TaskArena& arena,
                                 const std::vector<Vec3d>& since, const NodeOf& node_of) {
    const auto pieces = std::int64_t((count + kNodeGrain - 1) / kNodeGrain);
    const auto piece = [&](std::int64_t first, std::int64_t last) {
        for (auto p = std::size_t(first); p < std::size_t(last); ++p) {
            double moved = 0, from_grid = 0;
            const std::size_t begin = p * kNodeGrain;
            for (std::size_t at = begin; at < std::min(count, begin + kNodeGrain); ++at) {
                const std::size_t n = node_of(at);
                const Ride& ride = m_rides[n];
                Vec3d position{0, 0, 0};
                for (std::size_t k = 0; k < 4; ++k)
                    if (ride.weights[k] != 0)
                        position = position + ride.weights[k] * body.position(ride.particles[k]);
                moved = std::max(moved, norm(position - since[n]));
                from_grid = std::max(from_grid, norm(position - m_in_grid[n]));
                m_positions[n] = position;
            }
            m_moved[2 * p] = moved;
            m_moved[2 * p + 1] = from_grid;
        }
    };
    arena.for_each(pieces, 1, std::cref(piece));
    double moved = 0, from_grid = 0;
    for (std::size_t p = 0; p < std::size_t(pieces); ++p) {
        moved = std::max(moved, m_moved[2 * p]);
        from_grid = std::max(from_grid, m_moved[2 * p + 1]);
    }
    if (from_grid > m_margin) {
        m_in_grid = m_positions;
        m_grid.fill(m_positions, m_triangles, m_margin);
    }
    return moved;
}

double GhostSurface::update(const PbdBody& body, const TaskArena& arena) {
    return update_some(body, m_positions.size(), arena, m_positions,
                       [](std::size_t n) { return n; });
}

double GhostSurface::update(const PbdBody& body, std::span<const std::int32_t> nodes,
                            const TaskArena& arena) {
    return update_some(body, nodes.size(), arena, m_marked,
                       [&](std::size_t n) { return std::size_t(nodes[n]); });
}

Vec3d GhostSurface::face_normal(std::int32_t triangle) const {
    const auto& t = m_triangles[std::size_t(triangle)];
    const Vec3d a = m_positions[std::size_t(t[0])];
    return unit_or_zero(
        cross(m_positions[std::size_t(t[1])] - a, m_positions[std::size_t(t[2])] - a));
}

Vec3d GhostSurface::normal(std::int32_t triangle, int feature) const {
    if (feature == 6) return face_normal(triangle);
    if (feature >= 3) {
        const auto other = m_neighbours[std::size_t(triangle)][std::size_t(feature - 3)];
        if (other < 0) return {0, 0, 0};
        return unit_or_zero(face_normal(triangle) + face_normal(other));
    }
    const auto node = std::size_t(m_triangles[std::size_t(triangle)][std::size_t(feature)]);
    if (m_at_rim[node]) return {0, 0, 0};
    Vec3d sum{0, 0, 0};
    for (auto r = std::size_t(m_ring_starts[node]); r < std::size_t(m_ring_starts[node + 1]); ++r) {
        const auto& t = m_triangles[std::size_t(m_rings[r])];
        const std::size_t k = std::size_t(t[0]) == node ? 0 : std::size_t(t[1]) == node ? 1 : 2;
        const Vec3d at = m_positions[node], u = m_positions[std::size_t(t[(k + 1) % 3])] - at,
                    v = m_positions[std::size_t(t[(k + 2) % 3])] - at;
        sum = sum + std::atan2(norm(cross(u, v)), dot(u, v)) * face_normal(m_rings[r]);
    }
    return unit_or_zero(sum);
}

}  // namespace pliant::pbd
