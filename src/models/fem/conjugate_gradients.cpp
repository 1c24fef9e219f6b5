// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Nodes per partial sum.
constexpr std::int64_t kPiece = 2048;
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

SlabSums::SlabSums(const Slabs& slabs, const TaskArena& arena) : m_slabs(slabs), m_arena(arena) {
    const auto begin_of = [&](int rank) {
        return std::int64_t(slabs.plane()) * slabs.first_of(rank);
    };
    const auto piece_at = [](std::int64_t node) { return (node + kPiece - 1) / kPiece; };
    Ranks& ranks = *slabs.ranks();
    const std::int64_t nodes = pliant::node_count(slabs.whole());
    for (int r = 0; r < ranks.count(); ++r)
        m_counts.push_back(std::size_t(piece_at(begin_of(r + 1)) - piece_at(begin_of(r))));
    m_begin = begin_of(ranks.rank());
    m_end = begin_of(ranks.rank() + 1);
    m_borrowed = std::min(piece_at(m_end) * kPiece, nodes) - m_end;
    m_lent = std::min(piece_at(m_begin) * kPiece, nodes) - m_begin;
}

double SlabSums::dot(const NodeVector& a, const NodeVector& b) const {
    // The last piece continues in the slab above.
    const std::int64_t low = std::int64_t(m_slabs.plane()) * m_slabs.low();  // of local vectors
    const NodeVector* const both[2] = {&a, &b};
    const std::size_t vectors = &a == &b ? 1 : 2;
    m_lending.clear();
    for (std::size_t v = 0; v < vectors; ++v)
        for (int axis = 0; axis < 3; ++axis) {
            const double* const from = both[v]->component(axis) + (m_begin - low);
            m_lending.insert(m_lending.end(), from, from + m_lent);
        }
    m_tail.resize(3 * vectors * std::size_t(m_borrowed));
    m_slabs.ranks()->exchange(m_lending, {}, {}, m_tail);

    const std::int64_t first = (m_begin + kPiece - 1) / kPiece;
    const auto count = std::int64_t(m_counts[std::size_t(m_slabs.ranks()->rank())]);
    m_sums.assign(std::size_t(count), 0);
    const std::int64_t cut = m_borrowed > 0 ? count - 1 : count;
    m_arena.for_each(cut, 1, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n) {
            const std::int64_t begin = (first + n) * kPiece - low;
            m_sums[std::size_t(n)] =
                dot_of_piece(a, b, begin, std::min(begin + kPiece, m_end - low));
        }
    });
    if (cut < count) {
        const std::int64_t begin = (first + cut) * kPiece - low, own = m_end - low - begin;
        NodeVector parts[2] = {NodeVector(own + m_borrowed), NodeVector(own + m_borrowed)};
        const double* tail = m_tail.data();
        for (std::size_t v = 0; v < vectors; ++v)
            for (int axis = 0; axis < 3; ++axis, tail += m_borrowed) {
                const double* const from = both[v]->component(axis) + begin;
                std::copy_n(from, own, parts[v].component(axis));
                std::copy_n(tail, m_borrowed, parts[v].component(axis) + own);
            }
        m_sums[std::size_t(cut)] = dot_of_piece(parts[0], parts[vectors - 1], 0, own + m_borrowed);
    }
    std::size_t pieces = 0;
    for (const std::size_t c : m_counts) pieces += c;
    m_all.resize(pieces);
    m_slabs.ranks()->gather(m_sums, m_counts, m_all);
    double total = 0;
    for (const double sum : m_all) total += sum;
    return total;
}

double SlabSums::advance(double step, const NodeVector& p, const NodeVector& q, NodeVector& u,
                         NodeVector& r) const {
    m_arena.for_each(r.node_count(), kPiece, [&](std::int64_t begin, std::int64_t end) {
        add_scaled(step, p, u, begin, end);
        add_scaled(-step, q, r, begin, end);
    });
    return dot(r, r);
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
        arena.for_each(count, kPiece, [&](std::int64_t begin, std::int64_t end) {
            renew_direction(z, factor, p, begin, end);
        });
    }
}

}  // namespace pliant
