// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes of other programs in the form that Pliant expects.
//
// Tetrahedra: orders of corners are compared across shared faces, so that cells in mirrored order
// differ from cells that are folded. Neighbours in the same order traverse their face in opposite
// directions:
//
//      b                    a face of cell 1 is a b c, the same face of cell 2 is c b a
//     ╱│╲
//    1 │ 2                  the sum of the volumes, each with the sign that makes its piece
//     ╲│╱                   consistent, says which of the two orders is the mirrored one
//      a

#include <pliant/core/text.h>
#include <pliant/mesh.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

using Corners = std::array<std::int32_t, 3>;

/// Rotates the smallest corner to the front, which keeps the orientation.
Corners rotated(Corners t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

/// Drops later copies of triangles with the same corners and orientation, in place.
/// @returns number of dropped triangles
std::size_t drop_repeated(std::vector<Corners>& triangles) {
    std::vector<std::pair<Corners, std::size_t>> sorted;
    sorted.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        sorted.emplace_back(rotated(triangles[t]), t);
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> is_repeated(triangles.size(), false);
    std::size_t count = 0;
    for (std::size_t n = 1; n < sorted.size(); ++n) {
        if (sorted[n].first != sorted[n - 1].first) continue;
        is_repeated[sorted[n].second] = true;
        ++count;
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (!is_repeated[t]) triangles[kept++] = triangles[t];
    triangles.resize(kept);
    return count;
}

/// The edges of a surface, from its triangles' sides in order.
struct Edges {
    std::int64_t open = 0;             ///< of one triangle
    bool is_crowded = false;           ///< some have three triangles or more
    std::vector<std::int32_t> border;  ///< nodes of open edges, in order
};

Edges edges_of(std::span<const Corners> triangles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> sides;
    sides.reserve(3 * triangles.size());
    for (const Corners& t : triangles)
        for (std::size_t n = 0; n < 3; ++n) sides.push_back(std::minmax(t[n], t[(n + 1) % 3]));
    std::sort(sides.begin(), sides.end());
    Edges edges;
    for (std::size_t n = 0, end = 0; n < sides.size(); n = end) {
        while (end < sides.size() && sides[end] == sides[n]) ++end;
        edges.is_crowded |= end > n + 2;
        if (end > n + 1) continue;
        ++edges.open;
        edges.border.push_back(sides[n].first);
        edges.border.push_back(sides[n].second);
    }
    std::sort(edges.border.begin(), edges.border.end());
    edges.border.erase(std::unique(edges.border.begin(), edges.border.end()), edges.border.end());
    return edges;
}

/// For each node, itself or the first of the border's nodes that are connected to it by steps of at
/// most `within_mm` along each axis. The nodes are sorted into cubes of that edge.
std::vector<std::int32_t> near_nodes(std::span<const Vec3d> nodes_mm,
                                     std::span<const std::int32_t> border, double within_mm) {
    using Cube = std::array<std::int64_t, 3>;
    std::vector<std::pair<Cube, std::int32_t>> cubes;
    for (const std::int32_t n : border) {
        const Vec3d p = (1 / within_mm) * nodes_mm[std::size_t(n)];
        cubes.push_back({{std::int64_t(std::floor(p.x)), std::int64_t(std::floor(p.y)),
                          std::int64_t(std::floor(p.z))},
                         n});
    }
    std::sort(cubes.begin(), cubes.end());
    std::vector<std::int32_t> same(nodes_mm.size());
    std::iota(same.begin(), same.end(), 0);
    const auto root = [&](std::int32_t n) {
        while (same[std::size_t(n)] != n) {
            std::int32_t& up = same[std::size_t(n)];
            n = up = same[std::size_t(up)];
        }
        return n;
    };
    const auto join = [&](std::int32_t a, std::int32_t b) {
        const Vec3d apart = nodes_mm[std::size_t(a)] - nodes_mm[std::size_t(b)];
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(apart[axis]) > within_mm) return;
        a = root(a);
        b = root(b);
        same[std::size_t(std::max(a, b))] = std::min(a, b);
    };
    for (const auto& [cube, node] : cubes)
        for (int c = 0; c < 27; ++c) {
            const Cube beside = {cube[0] + c % 3 - 1, cube[1] + c / 3 % 3 - 1, cube[2] + c / 9 - 1};
            auto other = std::lower_bound(cubes.begin(), cubes.end(), std::pair(beside, node + 1));
            for (; other != cubes.end() && other->first == beside; ++other)
                join(node, other->second);
        }
    for (std::int32_t n = 0; n < std::int32_t(same.size()); ++n) same[std::size_t(n)] = root(n);
    return same;
}

double extent_mm(std::span<const Vec3d> nodes_mm) {
    if (nodes_mm.empty()) return 0;
    Vec3d low = nodes_mm[0], high = nodes_mm[0];
    for (const Vec3d& p : nodes_mm)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    return norm(high - low);
}

/// Merges corners that rounding has moved apart, if that closes edges and collapses no triangle.
void join_near(TriangleMesh& surface, Edges& edges, std::vector<std::string>& notes) {
    constexpr double kNear = 1e-5;  // of the extent
    const double within_mm = kNear * extent_mm(surface.nodes_mm);
    if (edges.open == 0 || !(within_mm > 0)) return;
    const auto same = near_nodes(surface.nodes_mm, edges.border, within_mm);
    std::vector<Corners> triangles = surface.cells;
    for (Corners& t : triangles) {
        for (std::int32_t& n : t) n = same[std::size_t(n)];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
    }
    Edges left = edges_of(triangles);
    if (left.open >= edges.open) return;
    notes.push_back("corners within " + short_text(within_mm, 2) +
                    " mm of each other were joined: " + std::to_string(left.open) +
                    " open edges instead of " + std::to_string(edges.open));
    surface = part_of(surface.nodes_mm, triangles);
    edges = std::move(left);
}

/// A face of a tetrahedron with its corners sorted.
struct OrientedFace {
    Corners corners;
    bool is_odd;  ///< the cell's order is an odd permutation of the sorted one
    std::uint32_t cell;
};

std::vector<OrientedFace> oriented_faces(std::span<const std::array<std::int32_t, 4>> cells) {
    // Outward for a positive cell.
    constexpr std::size_t kSides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    std::vector<OrientedFace> faces;
    faces.reserve(4 * cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c)
        for (const auto& f : kSides) {
            Corners t = {cells[c][f[0]], cells[c][f[1]], cells[c][f[2]]};
            bool is_odd = false;
            for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
                if (t[std::size_t(a)] > t[std::size_t(b)]) {
                    std::swap(t[std::size_t(a)], t[std::size_t(b)]);
                    is_odd = !is_odd;
                }
            faces.push_back({t, is_odd, std::uint32_t(c)});
        }
    std::sort(faces.begin(), faces.end(), [](const OrientedFace& a, const OrientedFace& b) {
        return std::tuple(a.corners, a.cell) < std::tuple(b.corners, b.cell);
    });
    return faces;
}

}  // namespace

TriangleMesh cleaned(const TriangleMesh& surface, std::vector<std::string>* notes) {
    std::vector<std::string> unused;
    std::vector<std::string>& said = notes ? *notes : unused;
    TriangleMesh clean = joined(surface);
    Edges edges = edges_of(clean.cells);
    join_near(clean, edges, said);
    const std::size_t dropped = edges.is_crowded ? drop_repeated(clean.cells) : 0;
    if (dropped > 0)
        said.push_back(std::to_string(dropped) + (dropped == 1
                                                      ? " repeated triangle was dropped"
                                                      : " repeated triangles were dropped"));
    return clean;
}

std::int64_t turn_mirrored(std::span<const Vec3d> nodes_mm,
                           std::span<std::array<std::int32_t, 4>> cells) {
    const auto volume = [&](const std::array<std::int32_t, 4>& c) {
        const auto at = [&](std::size_t n) { return nodes_mm[std::size_t(c[n])]; };
        return dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0)));
    };
    if (std::none_of(cells.begin(), cells.end(), [&](const auto& c) { return volume(c) < 0; }))
        return 0;
    // Pairs of neighbours, and whether their orders agree.
    struct Neighbour {
        std::uint32_t cell, other;
        bool agree;
    };
    std::vector<Neighbour> pairs;
    const std::vector<OrientedFace> faces = oriented_faces(cells);
    for (std::size_t n = 0; n + 1 < faces.size(); ++n) {
        if (faces[n].corners != faces[n + 1].corners) continue;
        const bool agree = faces[n].is_odd != faces[n + 1].is_odd;
        pairs.push_back({faces[n].cell, faces[n + 1].cell, agree});
        pairs.push_back({faces[n + 1].cell, faces[n].cell, agree});
    }
    std::sort(pairs.begin(), pairs.end(), [](const Neighbour& a, const Neighbour& b) {
        return std::tuple(a.cell, a.other) < std::tuple(b.cell, b.other);
    });
    std::vector<int> sign(cells.size(), 0);
    std::vector<std::uint32_t> piece;
    std::int64_t turned = 0;
    for (std::size_t first = 0; first < cells.size(); ++first) {
        if (sign[first] != 0) continue;
        piece = {std::uint32_t(first)};
        sign[first] = 1;
        double sum = 0;
        for (std::size_t n = 0; n < piece.size(); ++n) {
            const std::uint32_t cell = piece[n];
            sum += sign[cell] * volume(cells[cell]);
            auto pair =
                std::lower_bound(pairs.begin(), pairs.end(), cell,
                                 [](const Neighbour& a, std::uint32_t c) { return a.cell < c; });
            for (; pair != pairs.end() && pair->cell == cell; ++pair) {
                if (sign[pair->other] != 0) continue;
                sign[pair->other] = pair->agree ? sign[cell] : -sign[cell];
                piece.push_back(pair->other);
            }
        }
        for (const std::uint32_t cell : piece) {
            if (!(sign[cell] * sum < 0)) continue;
            std::swap(cells[cell][2], cells[cell][3]);
            ++turned;
        }
    }
    return turned;
}

}  // namespace pliant
