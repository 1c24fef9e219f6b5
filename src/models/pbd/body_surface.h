// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The surface of a body of tetrahedra, in patches: at most 32 adjacent triangles of a piece, by
// recursive halving. Triangles are numbered patch by patch, patches piece by piece.
//
//     piece 0             piece 1
//     patch 0 │ patch 1 │ patch 2 │ …        boxes of patches are the broad phase: there are few
//     0 … 31  │ 32 … 60 │ 61 …               hundreds of them, so that no tree is needed
//
// The side of a point comes from the nearest feature: face, or edge or corner with the
// angle-weighted mean of the adjacent faces [Baerentzen2005].

#pragma once

#include <pliant/mesh.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/box_tree.h"

namespace pliant::pbd {

struct Patch {
    std::int32_t begin, end;                         ///< triangles
    std::int32_t nodes_begin, owned_end, nodes_end;  ///< its nodes (nodes_of, owned_nodes_of)
    std::int32_t piece;
};

/// Nearest point of the surface.
struct SurfacePoint {
    std::int32_t triangle = -1;  ///< −1: none
    int feature = 6;             ///< as in mesh::NearestOnTriangle
    Vec3d position{0, 0, 0};
    double distance2 = 0;
};

class BodySurface {
  public:
    /// @param pieces  [tetrahedron]
    /// @pre check_cells accepts the mesh
    BodySurface(const TetMesh& mesh, std::span<const std::int32_t> pieces);

    std::size_t node_count() const { return m_particles.size(); }
    /// [node of the surface]: particle
    std::span<const std::int32_t> particles() const { return m_particles; }
    std::span<const std::array<std::int32_t, 3>> triangles() const { return m_triangles; }
    std::span<const Patch> patches() const { return m_patches; }
    /// Nodes of a patch's triangles, first those that belong to no earlier patch of the piece.
    std::span<const std::int32_t> nodes_of(std::size_t patch) const {
        const Patch& p = m_patches[patch];
        return std::span(m_patch_nodes)
            .subspan(std::size_t(p.nodes_begin), std::size_t(p.nodes_end - p.nodes_begin));
    }
    /// Only the latter: each node of the surface is in one patch, or in one of each piece.
    std::span<const std::int32_t> owned_nodes_of(std::size_t patch) const {
        const Patch& p = m_patches[patch];
        return nodes_of(patch).first(std::size_t(p.owned_end - p.nodes_begin));
    }
    /// [node]: its piece; −1 if pieces share it.
    std::span<const std::int32_t> pieces() const { return m_pieces; }
    /// [triangle]
    std::int32_t piece_of(std::int32_t triangle) const {
        return m_triangle_pieces[std::size_t(triangle)];
    }
    double mean_edge() const { return m_mean_edge; }

    /// Outward unit normal of a feature; zero if triangles are degenerate.
    Vec3d normal(std::int32_t triangle, int feature, std::span<const Vec3d> x) const;
    /// Nearest point among the triangles of a patch, if it is nearer than `best`.
    void nearest_in_patch(std::size_t patch, Vec3d p, std::span<const Vec3d> x,
                          SurfacePoint& best) const;
    /// Side of p − nearest.position: 1 outside, −1 inside. @pre found on these positions
    double side(Vec3d p, const SurfacePoint& nearest, std::span<const Vec3d> x) const;
    /// Distance from the surface, negative inside. @pre found on these positions
    double signed_distance(Vec3d p, const SurfacePoint& nearest, std::span<const Vec3d> x) const;

  private:
    void split(const TetMesh& mesh, std::span<std::int32_t> triangles,
               const std::vector<std::array<std::int32_t, 3>>& faces,
               std::vector<std::int32_t>& ends) const;
    void number_nodes(const TetMesh& mesh);
    void find_neighbours();
    Vec3d face_area(std::int32_t triangle, std::span<const Vec3d> x) const;
    Vec3d face_normal(std::int32_t triangle, std::span<const Vec3d> x) const;

    std::vector<std::array<std::int32_t, 3>> m_triangles;
    std::vector<std::array<std::int32_t, 3>> m_neighbours;  ///< across each edge; −1: none
    std::vector<std::int32_t> m_triangle_pieces, m_pieces, m_particles;
    std::vector<std::int32_t> m_ring_starts, m_rings;  ///< triangles at each node
    std::vector<Patch> m_patches;
    std::vector<std::int32_t> m_patch_nodes;
    double m_mean_edge = 1;
};

/// Boxes of the patches.
class PatchBoxes {
  public:
    explicit PatchBoxes(const BodySurface& surface) : m_boxes(surface.patches().size()) {}

    void update(const BodySurface& surface, std::span<const Vec3d> x) {
        for (std::size_t p = 0; p < m_boxes.size(); ++p) {
            m_boxes[p] = {};
            for (const std::int32_t n : surface.nodes_of(p)) m_boxes[p].add(x[std::size_t(n)]);
        }
    }
    const mesh::Bounds& box(std::size_t patch) const { return m_boxes[patch]; }

  private:
    std::vector<mesh::Bounds> m_boxes;
};

inline mesh::Bounds grown(mesh::Bounds box, double by) {
    const Vec3d m{by, by, by};
    return {box.low - m, box.high + m};
}
inline bool overlap(const mesh::Bounds& a, const mesh::Bounds& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y &&
           b.low.y <= a.high.y && a.low.z <= b.high.z && b.low.z <= a.high.z;
}

}  // namespace pliant::pbd
