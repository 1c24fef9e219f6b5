// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/graph_raise.h"

#include <algorithm>
#include <bit>

namespace pliant {
namespace {

/// Number of buckets, log₂: more buckets visit fewer elements twice, and take longer to step
/// through.
constexpr int kBucketBits = 10;

}  // namespace

GraphRaise::GraphRaise(const ChainGraph& graph, GraphQueue queue)
    : m_graph(graph),
      m_queue(queue),
      m_raise(std::size_t(graph.element_count()), 0),
      m_spread(std::size_t(graph.element_count()), 0) {
    if (queue == GraphQueue::Buckets) m_buckets.resize(std::size_t(1) << kBucketBits);
}

void GraphRaise::clear() {
    for (const std::int32_t e : m_touched) m_raise[std::size_t(e)] = m_spread[std::size_t(e)] = 0;
    m_touched.clear();
}

bool GraphRaise::offer(std::int32_t element, Fixed raise) {
    Fixed& current = m_raise[std::size_t(element)];
    if (raise <= current) return false;
    if (current == 0) m_touched.push_back(element);
    current = raise;
    return true;
}

template <class Take>
void GraphRaise::spread(std::int32_t element, std::span<const Fixed> u, const ComponentPush& push,
                        Take&& take) {
    const auto e = std::size_t(element);
    const Fixed raise = m_raise[e];
    if (raise == m_spread[e]) return;  // outdated: its neighbours have received it already
    m_spread[e] = raise;
    for (const ChainNeighbour& link : m_graph.neighbours(element)) {
        const std::int64_t ahead = std::int64_t(u[std::size_t(link.element)]) - u[e];
        const std::int64_t slack =
            push.sign > 0 ? ahead - link.low[push.axis] : link.high[push.axis] - ahead;
        if (slack < raise && offer(link.element, Fixed(raise - slack))) take(link.element);
    }
}

void GraphRaise::propagate(std::span<const Fixed> u, std::span<const std::int32_t> grabbed,
                           const ComponentPush& push) {
    for (const std::int32_t e : grabbed) offer(e, push.amount);
    switch (m_queue) {
        case GraphQueue::Heap:
            return run_heap(u, push);
        case GraphQueue::Buckets:
            return run_buckets(u, push);
        case GraphQueue::Fifo:
            return run_fifo(u, push);
    }
}

void GraphRaise::run_heap(std::span<const Fixed> u, const ComponentPush& push) {
    for (const std::int32_t e : m_touched) m_heap.push_back({push.amount, e});
    while (!m_heap.empty()) {
        std::pop_heap(m_heap.begin(), m_heap.end());
        const Candidate candidate = m_heap.back();
        m_heap.pop_back();
        spread(candidate.element, u, push, [&](std::int32_t e) {
            m_heap.push_back({m_raise[std::size_t(e)], e});
            std::push_heap(m_heap.begin(), m_heap.end());
        });
    }
}

void GraphRaise::run_buckets(std::span<const Fixed> u, const ComponentPush& push) {
    const int shift = std::max(0, int(std::bit_width(unsigned(push.amount))) - kBucketBits);
    const auto put = [&](std::int32_t e) {
        m_buckets[std::size_t(m_raise[std::size_t(e)] >> shift)].push_back(e);
    };
    for (const std::int32_t e : m_touched) put(e);
    // A neighbour is raised by no more than its sponsor, so no bucket above the current one fills.
    for (int at = push.amount >> shift; at >= 0; --at) {
        auto& bucket = m_buckets[std::size_t(at)];
        while (!bucket.empty()) {
            const std::int32_t e = bucket.back();
            bucket.pop_back();
            spread(e, u, push, put);
        }
    }
}

void GraphRaise::run_fifo(std::span<const Fixed> u, const ComponentPush& push) {
    m_fifo = m_touched;
    for (std::size_t n = 0; n < m_fifo.size(); ++n)
        spread(m_fifo[n], u, push, [&](std::int32_t e) { m_fifo.push_back(e); });
    m_fifo.clear();
}

}  // namespace pliant
