// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Sums have four lanes, which compilers can vectorise without changing the order.
constexpr std::int64_t kLanes = 4;

struct Lanes {
    double sum[kLanes] = {};
    double total() const { return (sum[0] + sum[1]) + (sum[2] + sum[3]); }
};

/// Sums over pieces; body(begin, end) returns the sum of a piece.
template <class Body>
double sum_of_pieces(std::int64_t count, const TaskArena& arena, std::vector<double>& sums,
                     Body&& body) {
    sums.assign(std::size_t((count + kSumPiece - 1) / kSumPiece), 0);
    arena.for_each(std::int64_t(sums.size()), 1, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n)
            sums[std::size_t(n)] = body(n * kSumPiece, std::min(count, (n + 1) * kSumPiece));
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

/// to += factor · from
void add_scaled(double factor, const NodeVector& from, NodeVector& to, std::int64_t begin,
                std::int64_t end) {
    for (int axis = 0; axis < 3; ++axis) {
        const double* const a = from.component(axis);
        double* const b = to.component(axis);
        for (std::int64_t n = begin; n < end; ++n) b[n] += factor * a[n];
    }
}

/// to = from + factor · to
void renew_direction(const NodeVector& from, double factor, NodeVector& to, std::int64_t begin,
                     std::int64_t end) {
    for (int axis = 0; axis < 3; ++axis) {
        const double* const a = from.component(axis);
        double* const b = to.component(axis);
        for (std::int64_t n = begin; n < end; ++n) b[n] = a[n] + factor * b[n];
    }
}

}  // namespace

double dot_of_piece(const NodeVector& a, const NodeVector& b, std::int64_t begin,
                    std::int64_t end) {
    Lanes lanes;
    for (int axis = 0; axis < 3; ++axis)
        add_products(a.component(axis), b.component(axis), begin, end, lanes);
    return lanes.total();
}

double WholeSums::dot(const NodeVector& a, const NodeVector& b) const {
    return sum_of_pieces(
        a.node_count(), m_arena, m_sums,
        [&](std::int64_t begin, std::int64_t end) { return dot_of_piece(a, b, begin, end); });
}

double WholeSums::advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                          NodeVector& r) const {
    return sum_of_pieces(r.node_count(), m_arena, m_sums,
                         [&](std::int64_t begin, std::int64_t end) {
                             add_scaled(step, p, u, begin, end);
                             add_scaled(-step, q, r, begin, end);
                             return dot_of_piece(r, r, begin, end);
                         });
}

double ordered_dot(const NodeVector& a, const NodeVector& b, const TaskArena& arena) {
    return WholeSums(arena).dot(a, b);
}

Convergence conjugate_gradients(const Stiffness& stiffness, const Preconditioner& precondition,
                                const HeldNodes& held, const NodeVector& force, double residual,
                                int max_iterations, const Sums& sums, const TaskArena& arena,
                                NodeVector& u) {
    const std::int64_t count = force.node_count();
    u = NodeVector(count);
    NodeVector r = force, z(count), q(count);
    precondition(r, z);
    NodeVector p = z;
    double slope = sums.dot(r, z);
    Convergence found{0, false, std::sqrt(sums.dot(r, r))};
    for (;;) {
        found.reached = found.residual <= residual;
        if (found.reached || found.iterations == max_iterations) return found;
        stiffness.multiply(p, q, arena);
        held.clear(q);
        const double curvature = sums.dot(p, q);
        if (!(curvature > 0)) return found;  // rounding: no descent direction is left
        const double step = slope / curvature;
        found.residual = std::sqrt(sums.advance(step, p, q, u, r));
        ++found.iterations;
        precondition(r, z);
        const double next = sums.dot(r, z);
        const double factor = next / slope;
        slope = next;
        arena.for_each(count, kSumPiece, [&](std::int64_t begin, std::int64_t end) {
            renew_direction(z, factor, p, begin, end);
        });
    }
}

}  // namespace pliant
