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
    std::int32_t begin, end;              ///< triangles
    std::int32_t nodes_begin, nodes_end;  ///< in patch_nodes(): nodes of its triangles
    std::int32_t owned_end;  ///< … up to here, those that belong to no earlier patch of the piece
    std::int32_t piece;
};

/// Nearest point of the surface.
struct SurfacePoint {
    std::int32_t triangle = -1;  ///< −1: none
    int feature = 6;             ///< as in mesh::NearestOnTriangle
    Vec3d place{0, 0, 0};
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
    std::span<const std::int32_t> patch_nodes() const { return m_patch_nodes; }
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
    /// Distance from the surface, negative inside. @pre found on these positions
    double signed_distance(Vec3d p, const SurfacePoint& nearest, std::span<const Vec3d> x) const;

  private:
    void split(const TetMesh& mesh, std::span<std::int32_t> triangles,
               const std::vector<std::array<std::int32_t, 3>>& faces,
               std::vector<std::int32_t>& ends) const;
    void number_nodes(const TetMesh& mesh);
    void find_neighbours();
    Vec3d face_normal(std::int32_t triangle, std::span<const Vec3d> x) const;

    std::vector<std::array<std::int32_t, 3>> m_triangles;
    std::vector<std::array<std::int32_t, 3>> m_neighbours;  ///< across each edge; −1: none
    std::vector<std::int32_t> m_triangle_pieces, m_pieces, m_particles;
    std::vector<std::int32_t> m_ring_starts, m_rings;  ///< triangles at each node
    std::vector<Patch> m_patches;
    std::vector<std::int32_t> m_patch_nodes;
    double m_mean_edge = 1;
};

/// Boxes of the patches, which are renewed patch by patch. Each node has an anchor, its position
/// when it was last seen, and has moved by less than the margin since then.
class PatchBoxes {
  public:
    PatchBoxes(const BodySurface& surface, std::span<const Vec3d> x, double margin);

    /// Call it after any motion.
    void update(const BodySurface& surface, std::span<const Vec3d> x);
    /// Marks all patches as changed in the next update.
    void forget() { m_is_known = false; }
    void clear_changed() { std::fill(m_changed.begin(), m_changed.end(), std::uint8_t(0)); }

    double margin() const { return m_margin; }
    std::span<const Vec3d> anchors() const { return m_anchors; }
    /// Box of the anchors and the margin: it contains the patch.
    const mesh::Bounds& box(std::size_t patch) const { return m_boxes[patch]; }
    /// [patch]: whether an anchor has changed since clear_changed().
    std::span<const std::uint8_t> changed() const { return m_changed; }
    /// [patch]: the way of its nodes in all updates so far; only differences have a meaning.
    std::span<const double> drifts() const { return m_drifts; }

  private:
    double m_margin;
    bool m_is_known = false;
    std::vector<Vec3d> m_anchors, m_last;
    std::vector<double> m_moved2;        ///< [node]: in this update, squared
    std::vector<std::uint8_t> m_is_far;  ///< [node]: beyond the margin
    std::vector<mesh::Bounds> m_boxes;
    std::vector<std::uint8_t> m_changed;
    std::vector<double> m_drifts;
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
