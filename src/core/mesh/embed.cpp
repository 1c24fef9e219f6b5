// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Embedding of points in tetrahedra. A bounding volume hierarchy finds the tetrahedra around a
// point. If none contains it, the one with the nearest boundary face is used.

#include <pliant/mesh.h>

#include <algorithm>

#include "mesh/box_tree.h"
#include "mesh/triangle_distance.h"

namespace pliant {
namespace {

/// Tolerance for points on a face, which rounding may place outside of both neighbours.
constexpr double kTolerance = 1e-9;

std::array<double, 4> weights_of(Vec3d x, const TetMesh& mesh, std::int32_t tetrahedron) {
    const auto& cell = mesh.cells[std::size_t(tetrahedron)];
    const auto position = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(cell[n])]; };
    const Vec3d a = position(0), b = position(1) - a, c = position(2) - a, d = position(3) - a,
                p = x - a;
    const double volume = dot(b, cross(c, d));
    const double u = dot(p, cross(c, d)) / volume, v = dot(b, cross(p, d)) / volume,
                 w = dot(b, cross(c, p)) / volume;
    return {1 - u - v - w, u, v, w};
}

bool is_in_box(Vec3d p, const std::array<Vec3d, 4>& corners) {
    for (int a = 0; a < 3; ++a) {
        double low = corners[0][a], high = low;
        for (const Vec3d& corner : corners) {
            low = std::min(low, corner[a]);
            high = std::max(high, corner[a]);
        }
        if (!(p[a] >= low && p[a] <= high)) return false;
    }
    return true;
}

}  // namespace

bool is_inside_tetrahedron(Vec3d position, const std::array<Vec3d, 4>& corners) {
    if (!is_in_box(position, corners)) return false;
    const Vec3d a = corners[1] - corners[0], b = corners[2] - corners[0];
    const Vec3d c = corners[3] - corners[0], p = position - corners[0];
    const Vec3d bc = cross(b, c), pa = cross(p, a);
    double whole = dot(a, bc);
    double first = dot(p, bc), second = -dot(pa, c), third = dot(pa, b);
    if (whole < 0) {
        whole = -whole;
        first = -first;
        second = -second;
        third = -third;
    }
    return whole > 0 && first >= 0 && second >= 0 && third >= 0 && first + second + third <= whole;
}

std::vector<Embedded> embed(std::span<const Vec3d> points_mm, const TetMesh& mesh,
                            const TaskArena& arena) {
    std::vector<mesh::Bounds> boxes(mesh.cells.size());
    for (std::size_t c = 0; c < boxes.size(); ++c)
        for (const std::int32_t n : mesh.cells[c]) boxes[c].add(mesh.nodes_mm[std::size_t(n)]);
    const mesh::BoxTree cells(boxes);
    std::vector<std::int32_t> face_cells;
    const auto faces = boundary_faces(mesh, &face_cells);
    boxes.assign(faces.size(), {});
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (const std::int32_t n : faces[f]) boxes[f].add(mesh.nodes_mm[std::size_t(n)]);
    const mesh::BoxTree boundary(boxes);

    std::vector<Embedded> embedded(points_mm.size());
    const auto find = [&](Vec3d x) {
        Embedded e{-1, {}};
        cells.nearest(x, 0, [&](std::int32_t cell, double&) {
            if (e.tetrahedron >= 0 && cell > e.tetrahedron) return;
            const auto w = weights_of(x, mesh, cell);
            if (*std::min_element(w.begin(), w.end()) >= -kTolerance) e = {cell, w};
        });
        if (e.tetrahedron >= 0) return e;
        std::int32_t nearest = -1;
        boundary.nearest(
            x, std::numeric_limits<double>::infinity(), [&](std::int32_t f, double& limit) {
                const auto& t = faces[std::size_t(f)];
                const auto near = mesh::nearest_on_triangle(x, mesh.nodes_mm[std::size_t(t[0])],
                                                            mesh.nodes_mm[std::size_t(t[1])],
                                                            mesh.nodes_mm[std::size_t(t[2])]);
                const double d = dot(x - near.position, x - near.position);
                if (d > limit || (d == limit && nearest >= 0 && f > nearest)) return;
                limit = d;
                nearest = f;
            });
        e.tetrahedron = face_cells[std::size_t(nearest)];
        e.weights = weights_of(x, mesh, e.tetrahedron);
        return e;
    };
    arena.for_each(std::int64_t(points_mm.size()), 64, [&](std::int64_t begin, std::int64_t end) {
        for (auto n = std::size_t(begin); n < std::size_t(end); ++n)
            embedded[n] = find(points_mm[n]);
    });
    return embedded;
}

}  // namespace pliant
