// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Signed distance to a triangle surface: exact, by a bounding volume hierarchy. The sign comes from
// the pseudonormal at the nearest point [Baerentzen2005]. The pseudonormal of a triangle is its
// normal, that of an edge the mean of its two triangles', that of a node the mean weighted by the
// triangles' angles. With these normals, (x − nearest)·normal has the correct sign everywhere
// around a closed surface.
//
//   const auto distance = SurfaceDistance::create(surface);   // closed, oriented
//   if (!distance) …distance.error().message
//   distance->signed_mm({0, 0, 0})   // negative inside

#pragma once

#include <pliant/mesh.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// Edge statistics of a triangle surface.
struct SurfaceTopology {
    std::int64_t edges = 0;
    std::int64_t open_edges = 0;         ///< edges of one triangle
    std::int64_t crowded_edges = 0;      ///< non-manifold edges, of three or more triangles
    std::int64_t disagreeing_edges = 0;  ///< edges that two triangles traverse in the same
                                         ///< direction
    std::int64_t pinched_nodes = 0;      ///< nodes whose triangles form more than one fan
    std::int64_t pieces = 0;             ///< components connected through shared nodes
    std::int64_t euler = 0;              ///< used nodes − edges + triangles

    bool closed_manifold() const {
        return open_edges == 0 && crowded_edges == 0 && disagreeing_edges == 0 &&
               pinched_nodes == 0;
    }
};
/// @pre the triangles name nodes below node_count
SurfaceTopology surface_topology(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t node_count);
SurfaceTopology surface_topology(const TriangleMesh& surface);

/// Checks that a surface has an inside: closed, consistently oriented, not folded back on itself.
/// @returns InvalidArgument that names the fault
Status check_closed(const TriangleMesh& surface);

/// Enclosed volume [mm³], negative if the triangles face inwards.
double enclosed_volume_mm3(const TriangleMesh& surface);

class SurfaceDistance {
  public:
    /// @returns InvalidArgument if the surface isn't closed (check_closed) or has a flat cell
    static Result<SurfaceDistance> create(TriangleMesh surface);
    SurfaceDistance(SurfaceDistance&&) noexcept;
    SurfaceDistance& operator=(SurfaceDistance&&) noexcept;
    ~SurfaceDistance();

    struct Nearest {
        double distance_mm = std::numeric_limits<double>::infinity();  ///< negative inside
        Vec3d place_mm{0, 0, 0};                                       ///< on the surface
        std::int32_t triangle = -1;  ///< the first of equally near ones; −1: none within reach
    };
    /// @param within_mm  farther triangles are ignored
    Nearest nearest(Vec3d x_mm, double within_mm = std::numeric_limits<double>::infinity()) const;
    double signed_mm(Vec3d x_mm) const { return nearest(x_mm).distance_mm; }
    const TriangleMesh& surface() const;

  private:
    struct Impl;
    explicit SurfaceDistance(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
