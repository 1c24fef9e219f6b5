// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Nodes that are summed up together.
constexpr std::int64_t kPiece = 2048;
/// Sums in four lanes, which compilers can keep in vectors without changing the order.
constexpr std::int64_t kLanes = 4;

struct Lanes {
    double sum[kLanes] = {};
    double total() const { return (sum[0] + sum[1]) + (sum[2] + sum[3]); }
};

/// body(begin, end) gives the sum of a piece.
template <class Body>
double sum_of_pieces(std::int64_t count, const TaskArena& arena, std::vector<double>& sums,
                     Body&& body) {
    sums.assign(std::size_t((count + kPiece - 1) / kPiece), 0);
    arena.for_each(std::int64_t(sums.size()), 1, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n)
            sums[std::size_t(n)] = body(n * kPiece, std::min(count, (n + 1) * kPiece));
    });
    double total = 0;
    for (const double sum : sums) total += sum;
    return total;
}

void add_products(const double* a, const double* b, std::int64_t begin, std::int64_t end,
                  Lanes& lanes) {
    std::int64_t n = begin;
    for (; n + kLanes <= end; n += kLanes)
        for (std::int64_t l = 0; l < kLanes; ++l) lanes.sum[l] += a[n + l] * b[n + l];
    for (; n < end; ++n) lanes.sum[0] += a[n] * b[n];
}

double dot_of_piece(const NodeVector& a, const NodeVector& b, std::int64_t begin,
                    std::int64_t end) {
    Lanes lanes;
    for (int axis = 0; axis < 3; ++axis)
        add_products(a.component(axis), b.component(axis), begin, end, lanes);
    return lanes.total();
}

/// to += factor · from
void add_scaled(double factor, const NodeVector& from, NodeVector& to, std::int64_t begin,
                std::int64_t end) {
    for (int axis = 0; axis < 3; ++axis) {
        const double* const a = from.component(axis);
        double* const b = to.component(axis);
        for (std::int64_t n = begin; n < end; ++n) b[n] += factor * a[n];
    }
}

/// to = preconditioner · from + factor · to
void renew_direction(const BlockJacobi& m, const NodeVector& from, double factor, NodeVector& to,
                     std::int64_t begin, std::int64_t end) {
    const double *xx = m.entry(0), *yy = m.entry(1), *zz = m.entry(2), *yz = m.entry(3),
                 *zx = m.entry(4), *xy = m.entry(5);
    const double *x = from.component(0), *y = from.component(1), *z = from.component(2);
    double *px = to.component(0), *py = to.component(1), *pz = to.component(2);
    for (std::int64_t n = begin; n < end; ++n) {
        px[n] = xx[n] * x[n] + xy[n] * y[n] + zx[n] * z[n] + factor * px[n];
        py[n] = xy[n] * x[n] + yy[n] * y[n] + yz[n] * z[n] + factor * py[n];
        pz[n] = zx[n] * x[n] + yz[n] * y[n] + zz[n] * z[n] + factor * pz[n];
    }
}

/// from · preconditioner · from
double preconditioned_square(const BlockJacobi& m, const NodeVector& from, std::int64_t begin,
                             std::int64_t end) {
    const double *xx = m.entry(0), *yy = m.entry(1), *zz = m.entry(2), *yz = m.entry(3),
                 *zx = m.entry(4), *xy = m.entry(5);
    const double *x = from.component(0), *y = from.component(1), *z = from.component(2);
    Lanes lanes;
    const auto term = [&](std::int64_t n) {
        return xx[n] * x[n] * x[n] + yy[n] * y[n] * y[n] + zz[n] * z[n] * z[n] +
               2 * (yz[n] * y[n] * z[n] + zx[n] * z[n] * x[n] + xy[n] * x[n] * y[n]);
    };
    std::int64_t n = begin;
    for (; n + kLanes <= end; n += kLanes)
        for (std::int64_t l = 0; l < kLanes; ++l) lanes.sum[l] += term(n + l);
    for (; n < end; ++n) lanes.sum[0] += term(n);
    return lanes.total();
}

/// The inverse of the free part of a symmetric positive block, as xx, yy, zz, yz, zx, xy; zero
/// where held. By elimination, one free axis after the other.
std::array<double, 6> free_inverse(const Block3& block, std::uint8_t held) {
    double a[3][3] = {}, inverse[3][3] = {};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const bool both_free = !(held >> i & 1) && !(held >> j & 1);
            a[i][j] = both_free ? block[3 * i + j] : i == j;
            inverse[i][j] = i == j;
        }
    for (int p = 0; p < 3; ++p) {
        const double scale = 1 / a[p][p];
        for (int j = 0; j < 3; ++j) {
            a[p][j] *= scale;
            inverse[p][j] *= scale;
        }
        for (int i = 0; i < 3; ++i) {
            if (i == p) continue;
            const double factor = a[i][p];
            for (int j = 0; j < 3; ++j) {
                a[i][j] -= factor * a[p][j];
                inverse[i][j] -= factor * inverse[p][j];
            }
        }
    }
    for (int i = 0; i < 3; ++i)
        if (held >> i & 1) inverse[i][i] = 0;
    return {inverse[0][0],
            inverse[1][1],
            inverse[2][2],
            (inverse[1][2] + inverse[2][1]) / 2,
            (inverse[2][0] + inverse[0][2]) / 2,
            (inverse[0][1] + inverse[1][0]) / 2};
}

}  // namespace

BlockJacobi::BlockJacobi(const Stiffness& stiffness, const HeldNodes& held, const TaskArena& arena)
    : m_count(held.axes.size()), m_values(6 * m_count) {
    arena.for_each(std::int64_t(m_count), kPiece, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            const auto node = std::size_t(n);
            const auto inverse =
                free_inverse(stiffness.diagonal_block(std::int32_t(n)), held.axes[node]);
            for (std::size_t e = 0; e < 6; ++e) m_values[e * m_count + node] = inverse[e];
        }
    });
}

double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena) {
    std::vector<double> sums;
    return sum_of_pieces(a.node_count(), arena, sums, [&](std::int64_t begin, std::int64_t end) {
        return dot_of_piece(a, b, begin, end);
    });
}

Convergence conjugate_gradients(const Stiffness& stiffness, const BlockJacobi& m,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const TaskArena& arena, NodeVector& u) {
    const std::int64_t count = force.node_count();
    u = NodeVector(count);
    NodeVector r = force, p(count), q(count);
    std::vector<double> sums, squares(std::size_t((count + kPiece - 1) / kPiece));
    double slope = sum_of_pieces(count, arena, sums, [&](std::int64_t begin, std::int64_t end) {
        renew_direction(m, r, 0, p, begin, end);
        return preconditioned_square(m, r, begin, end);
    });
    Convergence found{0, false, std::sqrt(ordered_dot(r, r, arena))};
    for (;;) {
        found.reached = found.residual <= residual;
        if (found.reached || found.iterations == max_iterations) return found;
        stiffness.multiply(p, q, arena);
        held.clear(q);
        const double curvature = sum_of_pieces(
            count, arena, sums,
            [&](std::int64_t begin, std::int64_t end) { return dot_of_piece(p, q, begin, end); });
        if (!(curvature > 0)) return found;  // rounding: no direction is left
        const double step = slope / curvature;
        const double next =
            sum_of_pieces(count, arena, sums, [&](std::int64_t begin, std::int64_t end) {
                add_scaled(step, p, u, begin, end);
                add_scaled(-step, q, r, begin, end);
                squares[std::size_t(begin / kPiece)] = dot_of_piece(r, r, begin, end);
                return preconditioned_square(m, r, begin, end);
            });
        double square = 0;
        for (const double s : squares) square += s;
        found.residual = std::sqrt(square);
        ++found.iterations;
        const double factor = next / slope;
        slope = next;
        arena.for_each(count, kPiece, [&](std::int64_t begin, std::int64_t end) {
            renew_direction(m, r, factor, p, begin, end);
        });
    }
}

}  // namespace pliant
