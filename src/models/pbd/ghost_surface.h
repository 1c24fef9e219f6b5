// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The ghost surface moving with the wall: positions of its nodes, search for nearby triangles, and
// the side of a point. The side comes from the face's normal, or at an edge or corner from the
// angle-weighted mean of the adjacent faces [Baerentzen2005]. The rim of an open end has no sides.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/pbd.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbd/triangle_grid.h"

namespace pliant::pbd {

struct Ride {
    std::array<std::int32_t, 4> particles;
    std::array<double, 4> weights;
};

class GhostSurface {
  public:
    /// @returns InvalidArgument that names the triangle or node
    static Status check(const TetMesh& mesh, const TriangleMesh& ghost,
                        std::span<const Embedded> ghost_positions);
    /// @pre check accepts the arguments. @param margin  motion of nodes after which the grid is
    /// refilled
    GhostSurface(const TetMesh& mesh, const TriangleMesh& ghost,
                 std::span<const Embedded> ghost_positions, double margin);

    /// Updates the nodes' positions from the body. @returns the largest distance of a node from its
    /// previous position
    double update(const PbdBody& body, const TaskArena& arena);
    /// Updates these nodes only; the others keep their last position. @returns the largest distance
    /// of a node from its position at `mark`
    double update(const PbdBody& body, std::span<const std::int32_t> nodes, const TaskArena& arena);

    void mark() { m_marked = m_positions; }

    std::span<const Vec3d> positions() const { return m_positions; }
    std::span<const std::array<std::int32_t, 3>> triangles() const { return m_triangles; }
    const Ride& ride(std::int32_t node) const { return m_rides[std::size_t(node)]; }
    void near(Vec3d low, Vec3d high, std::vector<std::int32_t>& found) const {
        m_grid.near(low, high, found);
    }

    /// Unit normal of a triangle's feature, numbered as in mesh::NearestOnTriangle, towards the
    /// lumen; zero at a rim, or if triangles are degenerate.
    Vec3d normal(std::int32_t triangle, int feature) const;

    /// Triangles at a node.
    std::span<const std::int32_t> ring(std::int32_t node) const {
        const auto begin = std::size_t(m_ring_starts[std::size_t(node)]),
                   end = std::size_t(m_ring_starts[std::size_t(node) + 1]);
        return std::span<const std::int32_t>(m_rings).subspan(begin, end - begin);
    }

  private:
    Vec3d face_normal(std::int32_t triangle) const;
    template <class NodeOf>
    double update_some(const PbdBody& body, std::size_t count, const TaskArena& arena,
                       const std::vector<Vec3d>& since, const NodeOf& node_of);

    std::vector<std::array<std::int32_t, 3>> m_triangles;
    std::vector<std::array<std::int32_t, 3>> m_neighbours;  ///< across each edge; −1: none
    std::vector<std::int32_t> m_ring_starts, m_rings;       ///< triangles at each node
    std::vector<bool> m_at_rim;                             ///< [node]
    std::vector<Ride> m_rides;
    std::vector<Vec3d> m_positions, m_in_grid, m_marked;
    std::vector<double> m_moved;  ///< [piece of nodes]; then since the grid was filled
    TriangleGrid m_grid;
    double m_margin;
};

}  // namespace pliant::pbd
