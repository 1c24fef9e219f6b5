// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ranks/slab_sums.h"

#include <algorithm>

namespace pliant {

SlabSums::SlabSums(const Slabs& slabs, const TaskArena& arena) : m_slabs(slabs), m_arena(arena) {
    const auto begin_of = [&](int rank) {
        return std::int64_t(slabs.plane()) * slabs.first_of(rank);
    };
    const auto piece_at = [](std::int64_t node) { return (node + kSumPiece - 1) / kSumPiece; };
    Ranks& ranks = *slabs.ranks();
    const std::int64_t nodes = pliant::node_count(slabs.whole());
    for (int r = 0; r < ranks.count(); ++r)
        m_counts.push_back(std::size_t(piece_at(begin_of(r + 1)) - piece_at(begin_of(r))));
    m_begin = begin_of(ranks.rank());
    m_end = begin_of(ranks.rank() + 1);
    m_borrowed = std::min(piece_at(m_end) * kSumPiece, nodes) - m_end;
    m_lent = std::min(piece_at(m_begin) * kSumPiece, nodes) - m_begin;
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

    const std::int64_t first = (m_begin + kSumPiece - 1) / kSumPiece;
    const auto count = std::int64_t(m_counts[std::size_t(m_slabs.ranks()->rank())]);
    m_sums.assign(std::size_t(count), 0);
    const std::int64_t cut = m_borrowed > 0 ? count - 1 : count;
    m_arena.for_each(cut, 1, [&](std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n) {
            const std::int64_t begin = (first + n) * kSumPiece - low;
            m_sums[std::size_t(n)] =
                dot_of_piece(a, b, begin, std::min(begin + kSumPiece, m_end - low));
        }
    });
    if (cut < count) {
        const std::int64_t begin = (first + cut) * kSumPiece - low, own = m_end - low - begin;
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
    m_arena.for_each(r.node_count(), kSumPiece, [&](std::int64_t begin, std::int64_t end) {
        for (int axis = 0; axis < 3; ++axis)
            for (std::int64_t n = begin; n < end; ++n) {
                u.component(axis)[n] += step * p.component(axis)[n];
                r.component(axis)[n] += -step * q.component(axis)[n];
            }
    });
    return dot(r, r);
}

}  // namespace pliant
