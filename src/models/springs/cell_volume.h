// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The volume of a cell and its gradient. A hexahedron's faces are bilinear: the volume under one is
// the mean of its two triangulations. With corners a, b, c, d around a face,
//
//   V = Σ_faces ( [a,b,c] + [a,c,d] + [a,b,d] + [b,c,d] ) / 12,    ∂V/∂a = Σ (b×c + c×d + b×d) / 12
//
// is exact. V is of degree three in the corners, so V = Σ a·∂V/∂a / 3.

#pragma once

#include <pliant/models/springs.h>

namespace pliant {

/// Faces at each corner, each as its next, opposite and last corner, such that the normal points
/// outwards.
inline constexpr int kFacesAt[8][3][3] = {
    {{3, 2, 1}, {1, 5, 4}, {4, 7, 3}}, {{0, 3, 2}, {2, 6, 5}, {5, 4, 0}},
    {{1, 0, 3}, {3, 7, 6}, {6, 5, 1}}, {{2, 1, 0}, {0, 4, 7}, {7, 6, 2}},
    {{5, 6, 7}, {0, 1, 5}, {7, 3, 0}}, {{6, 7, 4}, {1, 2, 6}, {4, 0, 1}},
    {{7, 4, 5}, {2, 3, 7}, {5, 1, 2}}, {{4, 5, 6}, {3, 0, 4}, {6, 2, 3}}};
/// Face opposite to a tetrahedron's corner, with its normal towards the corner.
inline constexpr int kFaceOpposite[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};

/// ∂V/∂corner. @param position  position of a node: Vec3d(std::int32_t)
template <class Position>
Vec3d volume_gradient(const SpringCell& cell, int corner, Position&& position) {
    const auto at = [&](int n) { return position(cell.nodes[std::size_t(n)]); };
    const Vec3d here = at(corner);
    if (cell.node_count == 4) {
        const auto& face = kFaceOpposite[corner];
        const Vec3d a = at(face[0]);
        return (1.0 / 6) * cross(at(face[1]) - a, at(face[2]) - a);
    }
    Vec3d sum{0, 0, 0};
    for (const auto& face : kFacesAt[corner]) {
        // Relative to the corner: the sum over its faces is independent of the origin.
        const Vec3d b = at(face[0]) - here, c = at(face[1]) - here, d = at(face[2]) - here;
        sum = sum + cross(b, c) + cross(c, d) + cross(b, d);
    }
    return (1.0 / 12) * sum;
}

/// Change of ∂V/∂corner for a small motion of all corners. @param move  like position
template <class Position, class Move>
Vec3d volume_gradient_change(const SpringCell& cell, int corner, Position&& position, Move&& move) {
    struct Edge {
        Vec3d position, move;
    };
    const auto edge = [&](int n) {
        const std::int32_t from = cell.nodes[std::size_t(corner)], to = cell.nodes[std::size_t(n)];
        return Edge{position(to) - position(from), move(to) - move(from)};
    };
    const auto change = [](const Edge& a, const Edge& b) {
        return cross(a.move, b.position) + cross(a.position, b.move);
    };
    if (cell.node_count == 4) {
        // Relative to the corner, for a common form: (b − a)×(c − a) = a×b + b×c + c×a.
        const auto& face = kFaceOpposite[corner];
        const Edge a = edge(face[0]), b = edge(face[1]), c = edge(face[2]);
        return (1.0 / 6) * (change(a, b) + change(b, c) + change(c, a));
    }
    Vec3d sum{0, 0, 0};
    for (const auto& face : kFacesAt[corner]) {
        const Edge b = edge(face[0]), c = edge(face[1]), d = edge(face[2]);
        sum = sum + change(b, c) + change(c, d) + change(b, d);
    }
    return (1.0 / 12) * sum;
}

/// Six times the volume of the tetrahedron of the edges at a corner; its sign is their orientation.
template <class Position>
double corner_volume(const SpringCell& cell, int corner, Position&& position) {
    const auto edge = [&](int n) {
        return position(cell.nodes[std::size_t(n)]) - position(cell.nodes[std::size_t(corner)]);
    };
    if (cell.node_count == 4) {
        const auto& face = kFaceOpposite[corner];
        return dot(edge(face[0]), cross(edge(face[1]), edge(face[2])));
    }
    const auto& faces = kFacesAt[corner];
    return dot(edge(faces[0][0]), cross(edge(faces[1][0]), edge(faces[2][0])));
}

template <class Position>
double cell_volume(const SpringCell& cell, Position&& position) {
    const Vec3d origin = position(cell.nodes[0]);
    double volume = 0;
    for (int n = 1; n < cell.node_count; ++n)
        volume +=
            dot(position(cell.nodes[std::size_t(n)]) - origin, volume_gradient(cell, n, position));
    return volume / 3;
}

/// Masses of nodes from a density: each cell distributes its mass equally to its corners.
inline void spread_masses(SpringParts& parts, double density) {
    for (SpringNode& node : parts.nodes) node.mass = 0;
    for (const SpringCell& cell : parts.cells) {
        const double volume =
            cell_volume(cell, [&](std::int32_t n) { return parts.nodes[std::size_t(n)].rest; });
        for (int n = 0; n < cell.node_count; ++n)
            parts.nodes[std::size_t(cell.nodes[std::size_t(n)])].mass +=
                density * volume / cell.node_count;
    }
}

}  // namespace pliant
