// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Exact crossings of segments with the triangles of a blade's ribbon.
//
// Positions and triangles are whole numbers, so the signs of all volumes are exact in 128 bits.
// Regular lattices and meshes have many points that lie exactly on a plane with typed coordinates,
// so ties need a rule, the same for every segment and triangle: the whole ribbon is moved by an
// infinitely small vector (ε, ε², ε³) [Edelsbrunner1990]. Then no point lies on it, neighbouring
// triangles still share their edges, and a path that ends on the other side of a surface without a
// border has crossed it.

#pragma once

#include <pliant/core/vec.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace pliant {

/// A point in whole units.
using Position = Vec3<std::int64_t>;
using Triangle = std::array<Position, 3>;

__extension__ typedef __int128 Int128;
using WidePosition = Vec3<Int128>;

/// Differences of positions are below this, so that a volume of them stays below 2¹²⁰.
inline constexpr std::int64_t kWidestPosition = std::int64_t(1) << 38;
/// Relative error of a sum of three products of numbers that were rounded to doubles.
inline constexpr double kSideError = 0x1p-48;

inline WidePosition wide(Position p) {
    return {p.x, p.y, p.z};
}

inline int sign_of(Int128 value) {
    return (value > 0) - (value < 0);
}

/// Sign of d + v·n for the infinitely small v = (ε, ε², ε³).
inline int perturbed_sign(Int128 d, const WidePosition& n) {
    if (d != 0) return sign_of(d);
    for (int a = 0; a < 3; ++a)
        if (n[a] != 0) return sign_of(n[a]);
    return 0;
}

struct BladePlane {
    Position through;
    WidePosition normal;

    explicit BladePlane(const Triangle& t)
        : through(t[0]), normal(cross(wide(t[1] - t[0]), wide(t[2] - t[0]))) {}
    bool is_flat() const { return normal == WidePosition{0, 0, 0}; }
    /// Side of the moved plane on which p lies: +1 or −1. @pre !is_flat()
    int side(Position p) const {
        const Position away = p - through;
        double sum = 0, size = 0;
        for (int a = 0; a < 3; ++a) {
            const double product = double(normal[a]) * double(away[a]);
            sum += product;
            size += std::abs(product);
        }
        if (std::abs(sum) > kSideError * size) return sum > 0 ? 1 : -1;
        return perturbed_sign(dot(normal, wide(away)), -normal);
    }
    /// Distance from the plane times the length of the normal.
    double level(Position p) const { return double(dot(normal, wide(p - through))); }
};

/// Side of the moved edge from a to b on which the line from p to q passes.
inline int edge_side(Position a, Position b, Position p, Position q) {
    const WidePosition along = wide(q - p), edge = wide(b - a);
    return perturbed_sign(dot(along, cross(wide(a - p), wide(b - p))), cross(edge, along));
}

/// @pre p and q are on different sides of the triangle's plane
inline bool passes_inside(const Triangle& t, Position p, Position q) {
    const int first = edge_side(t[0], t[1], p, q);
    return edge_side(t[1], t[2], p, q) == first && edge_side(t[2], t[0], p, q) == first;
}

/// Whether the segment from p to q crosses the triangle moved by (ε, ε², ε³).
inline bool crosses(const Triangle& triangle, Position p, Position q) {
    const BladePlane plane(triangle);
    return !plane.is_flat() && plane.side(p) != plane.side(q) && passes_inside(triangle, p, q);
}

/// The two triangles of the parallelogram that a segment sweeps along a depth. They have equal
/// planes.
inline std::array<Triangle, 2> swept(Position a, Position b, Position depth) {
    return {Triangle{a, b, b + depth}, Triangle{a, b + depth, a + depth}};
}

}  // namespace pliant
