// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "rods/tet_segment.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <pliant/models/pbd.h>

namespace pliant::catheter {
namespace {

/// Fraction of EI due to volumes, and limits of GJ as fractions of EI.
constexpr double kBulkShare = 0.03, kMinTwist = 0.05, kMaxTwist = 4;

/// Orders the columns of a side's diagonals: each is cut from the ring behind at the earlier column
/// to the ring ahead at the later column.
std::array<std::uint8_t, kRing> order_of_columns(bool odd) {
    return odd ? std::array<std::uint8_t, kRing>{1, 3, 2, 0}
               : std::array<std::uint8_t, kRing>{0, 2, 1, 3};
}

/// EI and GJ of a segment for unit stiffness of axial bars, diagonal bars or bulk, with rigid
/// rings.
struct Shares {
    SegmentStiffness bend, twist;
};
Shares shares_of(double radius, double length) {
    Shares s;
    const Corners x = corners_at_rest(radius, length, {0, 0, 0});
    // Mean over both kinds of segments and two bending directions.
    for (const bool odd : {false, true})
        for (const Vec3d& turn : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
            SegmentStiffness& to = turn.z != 0 ? s.twist : s.bend;
            const double part = 1 / length / (turn.z != 0 ? 2 : 4);
            // Curvature or twist of 1: half of it ahead, half of it behind.
            Corners moved;
            for (std::size_t n = 0; n < x.size(); ++n)
                moved[n] =
                    (n < kRing ? -0.5 : 0.5) * length * cross(turn, x[n] - Vec3d{0, 0, x[n].z});
            for (const Bar& b : bars_across(odd)) {
                const double longer = dot(normalized(x[b.b] - x[b.a]), moved[b.b] - moved[b.a]);
                // Diagonal bars don't resist bending: rings shift sideways and
                // relax them.
                if (b.is_along || turn.z != 0)
                    (b.is_along ? to.along : to.aslant) += part * longer * longer;
            }
            for (const auto& tet : tetrahedra(odd)) {
                const auto g = volume_gradient(tet, x);
                double grown = 0;
                for (std::size_t k = 0; k < 4; ++k) grown += dot(g[k], moved[tet[k]]);
                to.bulk += part * grown * grown / volume_of(tet, x);
            }
        }
    return s;
}

}  // namespace

std::array<Bar, kAcross> bars_across(bool odd) {
    std::array<Bar, kAcross> bars{{{0, 4, true}, {1, 5, true}, {2, 6, true}, {3, 7, true}}};
    const auto order = order_of_columns(odd);
    std::size_t n = 4;
    for (std::size_t a = 0; a < 2; ++a)
        for (std::size_t b = 2; b < kRing; ++b)
            bars[n++] = {order[a], std::uint8_t(order[b] + kRing), false};
    return bars;
}

std::array<std::array<std::uint8_t, 2>, kInRing> bars_in_ring() {
    return {{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}}};
}

std::array<std::array<std::uint8_t, 4>, kTets> tetrahedra(bool odd) {
    std::array<std::array<std::uint8_t, 4>, kTets> all{};
    const Corners x = corners_at_rest(1, 1, {0, 0, 0});
    std::size_t n = 0;
    for (const std::uint8_t without : {3, 1}) {  // a prism of three columns
        std::array<std::uint8_t, 3> c{};
        std::size_t k = 0;
        for (const std::uint8_t column : order_of_columns(odd))
            if (column != without) c[k++] = column;
        const auto ahead = [](std::uint8_t column) { return std::uint8_t(column + kRing); };
        all[n++] = {c[0], c[1], c[2], ahead(c[2])};
        all[n++] = {c[0], c[1], ahead(c[1]), ahead(c[2])};
        all[n++] = {c[0], ahead(c[0]), ahead(c[1]), ahead(c[2])};
    }
    for (auto& tet : all)
        if (volume_of(tet, x) < 0) std::swap(tet[2], tet[3]);
    return all;
}

Corners corners_at_rest(double radius, double length, Vec3d turned) {
    Corners x;
    for (std::size_t n = 0; n < x.size(); ++n) {
        const double angle = 0.5 * std::numbers::pi * double(n % kRing), side = n < kRing ? -1 : 1;
        const Vec3d from{radius * std::cos(angle), radius * std::sin(angle), 0};
        x[n] = Vec3d{0, 0, 0.5 * side * length} + rotated(rotation_by((0.5 * side) * turned), from);
    }
    return x;
}

double volume_of(const std::array<std::uint8_t, 4>& tet, const Corners& x) {
    const Vec3d p = x[tet[0]];
    return dot(cross(x[tet[1]] - p, x[tet[2]] - p), x[tet[3]] - p) / 6;
}

std::array<Vec3d, 4> volume_gradient(const std::array<std::uint8_t, 4>& tet, const Corners& x) {
    const Vec3d a = x[tet[1]] - x[tet[0]], b = x[tet[2]] - x[tet[0]], c = x[tet[3]] - x[tet[0]];
    const Vec3d first = (1.0 / 6) * cross(b, c), second = (1.0 / 6) * cross(c, a),
                third = (1.0 / 6) * cross(a, b);
    return {-(first + second + third), first, second, third};
}

TwistBounds twist_bounds(double bend, double radius, double length) {
    const Shares s = shares_of(radius, length);
    const double of_bulk = kBulkShare * bend / s.bend.bulk * s.twist.bulk;
    return {of_bulk + kMinTwist * bend, of_bulk + kMaxTwist * bend};
}

SegmentStiffness stiffness_for(double bend, double twist, double radius, double length) {
    const Shares s = shares_of(radius, length);
    SegmentStiffness k;
    k.bulk = kBulkShare * bend / s.bend.bulk;
    k.aslant = (twist - k.bulk * s.twist.bulk) / s.twist.aslant;
    k.along = (1 - kBulkShare) * bend / s.bend.along;
    // Rings are stiffer than all other parts, so they keep their shape.
    k.ring = 10 * (k.along + k.aslant);
    return k;
}

}  // namespace pliant::catheter
