// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How far a place is from a triangle surface, and on which side: exact distances through a
// hierarchy of boxes. The sign comes from the nearest point's pseudonormal [Baerentzen2005]: of a
// triangle its normal, of an edge the mean of its two triangles', of a node the mean weighted by
// the triangles' angles there. With those, and only with such, (x − nearest)·normal has the right
// sign everywhere around a closed surface.
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

/// What the edges of a triangle surface say of it.
struct SurfaceTopology {
    std::int64_t edges = 0;
    std::int64_t open_edges = 0;         ///< of one triangle only
    std::int64_t crowded_edges = 0;      ///< of three triangles or more
    std::int64_t disagreeing_edges = 0;  ///< two triangles run along it the same way
    std::int64_t pinched_nodes = 0;      ///< whose triangles are more than one fan
    std::int64_t pieces = 0;             ///< connected through shared nodes
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

/// Whether a surface has an inside: closed, each edge run along once each way, nothing folded back
/// on itself. @returns InvalidArgument that says what was found
Status check_closed(const TriangleMesh& surface);

/// What the surface encloses [mm³]: negative where its triangles face inwards.
double enclosed_volume_mm3(const TriangleMesh& surface);

class SurfaceDistance {
  public:
    /// @returns InvalidArgument where the surface isn't closed (check_closed), or has a flat cell
    static Result<SurfaceDistance> create(TriangleMesh surface);
    SurfaceDistance(SurfaceDistance&&) noexcept;
    SurfaceDistance& operator=(SurfaceDistance&&) noexcept;
    ~SurfaceDistance();

    struct Nearest {
        double distance_mm = std::numeric_limits<double>::infinity();  ///< negative inside
        Vec3d place_mm{0, 0, 0};                                       ///< on the surface
        std::int32_t triangle = -1;  ///< of equally near ones the first; −1: none within reach
    };
    /// @param within_mm  farther triangles aren't looked at
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
