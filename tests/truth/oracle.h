// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// All points that a deformation maps to a point, by bisection: no derivative, no Newton's method.
// The image of a box inside of a cell lies in the convex hull of its corners' images, because the
// map is trilinear in the box; boxes that cannot hold the point are dropped.

#pragma once

#include <pliant/deformation.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace pliant::test {

/// Positions of a cell's corners now, along i, j, k [voxels].
inline std::array<Vec3d, 8> cell_corners(const Deformation& d, Vec3i cell) {
    std::array<Vec3d, 8> corners;
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        const Vec3d u = lattice_from_world_vector(d.grid(), d.displacement_mm(e));
        for (int a = 0; a < 3; ++a)
            corners[std::size_t(c)][a] = e[a] + u[a] / d.grid().spacing_mm[a];
    }
    return corners;
}

inline Vec3d trilinear(const std::array<Vec3d, 8>& p, Vec3d t) {
    Vec3d sum{0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        const double w =
            (c & 1 ? t.x : 1 - t.x) * (c >> 1 & 1 ? t.y : 1 - t.y) * (c >> 2 ? t.z : 1 - t.z);
        sum = sum + w * p[std::size_t(c)];
    }
    return sum;
}

/// Whether no corner is void, and cut links have both ends displaced alike.
inline bool is_whole(const Deformation& d, Vec3i cell) {
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        if (d.is_void(e)) return false;
        for (int a = 0; a < 3; ++a) {
            Vec3i next = e;
            ++next[a];
            if (!(c >> a & 1) && !d.is_linked(e, a) &&
                d.displacement_mm(e) != d.displacement_mm(next))
                return false;
        }
    }
    return true;
}

/// Local coordinates t of all points of a cell that are mapped to y, each up to 2^-depth.
inline std::vector<Vec3d> roots_in_cell(const std::array<Vec3d, 8>& corners, Vec3d y, int depth) {
    std::vector<Vec3d> boxes{{0, 0, 0}}, next;
    double edge = 1;
    const auto may_hold = [&](Vec3d low) {
        Vec3d least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
        for (int c = 0; c < 8; ++c) {
            const Vec3d p = trilinear(
                corners, low + edge * Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)});
            for (int a = 0; a < 3; ++a) {
                least[a] = std::min(least[a], p[a]);
                most[a] = std::max(most[a], p[a]);
            }
        }
        for (int a = 0; a < 3; ++a)
            if (y[a] < least[a] - 1e-12 || y[a] > most[a] + 1e-12) return false;
        return true;
    };
    if (!may_hold(boxes[0])) return {};
    for (int level = 0; level < depth && !boxes.empty() && boxes.size() < 4000; ++level) {
        edge /= 2;
        next.clear();
        for (const Vec3d low : boxes)
            for (int c = 0; c < 8; ++c) {
                const Vec3d part =
                    low + edge * Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)};
                if (may_hold(part)) next.push_back(part);
            }
        std::swap(boxes, next);
    }
    for (Vec3d& low : boxes) low = low + 0.5 * edge * Vec3d{1, 1, 1};
    return boxes;
}

/// Distinct points of whole cells that are mapped to y [voxels at rest], each up to about 1e-6.
/// @param cells  low corners to look into
inline std::vector<Vec3d> sources_by_bisection(const Deformation& d, const Box3i& cells, Vec3d y) {
    std::vector<Vec3d> found;
    for (int k = cells.begin.z; k < cells.end.z; ++k)
        for (int j = cells.begin.y; j < cells.end.y; ++j)
            for (int i = cells.begin.x; i < cells.end.x; ++i) {
                if (!is_whole(d, {i, j, k})) continue;
                for (const Vec3d t : roots_in_cell(cell_corners(d, {i, j, k}), y, 22)) {
                    const Vec3d x = Vec3d{double(i), double(j), double(k)} + t;
                    bool is_new = true;
                    for (const Vec3d other : found) is_new &= norm(other - x) > 1e-4;
                    if (is_new) found.push_back(x);
                }
            }
    return found;
}

}  // namespace pliant::test
