// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/box_tree.h"
#include "mesh/triangle_distance.h"

namespace pliant {

struct SurfaceDistance::Impl {
    TriangleMesh surface;
    mesh::BoxTree tree;
    /// Outward normals, not normalised: of each triangle's three edges, then of the triangle.
    std::vector<std::array<Vec3d, 4>> normals;
    std::vector<Vec3d> node_normals;

    std::array<Vec3d, 3> corners(std::size_t t) const {
        const auto& c = surface.cells[t];
        return {surface.nodes_mm[std::size_t(c[0])], surface.nodes_mm[std::size_t(c[1])],
                surface.nodes_mm[std::size_t(c[2])]};
    }
    void prepare();
    Vec3d normal(std::size_t t, int feature) const {
        if (feature < 3) return node_normals[std::size_t(surface.cells[t][std::size_t(feature)])];
        return normals[t][std::size_t(feature - 3)];
    }
};

void SurfaceDistance::Impl::prepare() {
    const std::size_t count = surface.cells.size();
    std::vector<mesh::Bounds> boxes(count);
    normals.resize(count);
    node_normals.assign(surface.nodes_mm.size(), {0, 0, 0});
    // After sorting the edges by their ends, an edge's two triangles are adjacent.
    struct Side {
        std::int32_t low, high, triangle, edge;
        bool operator<(const Side& s) const {
            return std::pair(low, high) < std::pair(s.low, s.high);
        }
    };
    std::vector<Side> sides;
    sides.reserve(3 * count);
    for (std::size_t t = 0; t < count; ++t) {
        const auto p = corners(t);
        for (const Vec3d& corner : p) boxes[t].add(corner);
        const Vec3d normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
        normals[t].fill(normal);
        for (std::size_t n = 0; n < 3; ++n) {
            const std::int32_t a = surface.cells[t][n], b = surface.cells[t][(n + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), std::int32_t(t), std::int32_t(n)});
            const Vec3d u = p[(n + 1) % 3] - p[n], v = p[(n + 2) % 3] - p[n];
            const double angle = std::atan2(norm(cross(u, v)), dot(u, v));
            node_normals[std::size_t(a)] = node_normals[std::size_t(a)] + angle * normal;
        }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t n = 0; n + 1 < sides.size(); n += 2) {
        const Side &a = sides[n], &b = sides[n + 1];
        const Vec3d sum = normals[std::size_t(a.triangle)][3] + normals[std::size_t(b.triangle)][3];
        normals[std::size_t(a.triangle)][std::size_t(a.edge)] = sum;
        normals[std::size_t(b.triangle)][std::size_t(b.edge)] = sum;
    }
    tree = mesh::BoxTree(boxes);
}

SurfaceDistance::SurfaceDistance(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SurfaceDistance::SurfaceDistance(SurfaceDistance&&) noexcept = default;
SurfaceDistance& SurfaceDistance::operator=(SurfaceDistance&&) noexcept = default;
SurfaceDistance::~SurfaceDistance() = default;

const TriangleMesh& SurfaceDistance::surface() const {
    return m_impl->surface;
}

Result<SurfaceDistance> SurfaceDistance::create(TriangleMesh surface) {
    if (const Status closed = check_closed(surface); !closed) return closed.error();
    auto impl = std::make_unique<Impl>();
    impl->surface = std::move(surface);
    impl->prepare();
    return SurfaceDistance(std::move(impl));
}

SurfaceDistance::Nearest SurfaceDistance::nearest(Vec3d x_mm, double within_mm) const {
    const Impl& s = *m_impl;
    Nearest found;
    int feature = 6;
    double best = within_mm * within_mm;
    s.tree.nearest(x_mm, best, [&](std::int32_t t, double& limit) {
        const auto p = s.corners(std::size_t(t));
        const auto near = mesh::nearest_on_triangle(x_mm, p[0], p[1], p[2]);
        const double d = dot(x_mm - near.position, x_mm - near.position);
        if (d > limit || (d == limit && found.triangle >= 0 && t > found.triangle)) return;
        limit = d;
        found.triangle = t;
        found.position_mm = near.position;
        feature = near.feature;
    });
    if (found.triangle < 0) return found;
    const Vec3d away = x_mm - found.position_mm;
    const double side = dot(away, s.normal(std::size_t(found.triangle), feature));
    found.distance_mm = std::copysign(norm(away), side);
    return found;
}

}  // namespace pliant
