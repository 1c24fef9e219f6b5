// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The raise of propagation.h, on a graph: raise(j) is the maximum of raise(i) − slack(i, j), where
// slack(i, j) ≥ 0 is the distance that i can still move before it takes j along.

#pragma once

#include <pliant/research/graph.h>

#include <span>
#include <vector>

#include "material/limit_units.h"
#include "propagate/propagation.h"

namespace pliant {

/// Solver of one component; kept between pushes, so that cost depends on touched elements only.
class GraphRaise {
  public:
    GraphRaise(const ChainGraph& graph, GraphQueue queue);

    /// @param u  [element], along the push's axis
    void propagate(std::span<const Fixed> u, std::span<const std::int32_t> grabbed,
                   const ComponentPush& push);
    Fixed raise(std::int32_t element) const { return m_raise[std::size_t(element)]; }
    /// Elements with a raise above 0, each once.
    std::span<const std::int32_t> touched() const { return m_touched; }
    /// Ends the solve: resets all raises to 0.
    void clear();

  private:
    struct Candidate {
        Fixed raise;
        std::int32_t element;
        friend bool operator<(const Candidate& a, const Candidate& b) { return a.raise < b.raise; }
    };

    /// Raises the element if that is higher. @returns whether it is
    bool offer(std::int32_t element, Fixed raise);
    /// Offers the remainder of an element's raise to each neighbour; calls take(neighbour) if it
    /// was accepted.
    template <class Take>
    void spread(std::int32_t element, std::span<const Fixed> u, const ComponentPush& push,
                Take&& take);
    void run_heap(std::span<const Fixed> u, const ComponentPush& push);
    void run_buckets(std::span<const Fixed> u, const ComponentPush& push);
    void run_fifo(std::span<const Fixed> u, const ComponentPush& push);

    const ChainGraph& m_graph;
    GraphQueue m_queue;
    std::vector<Fixed> m_raise;   ///< [element]
    std::vector<Fixed> m_spread;  ///< [element]: the raise that its neighbours have received
    std::vector<std::int32_t> m_touched;
    std::vector<Candidate> m_heap;
    std::vector<std::vector<std::int32_t>> m_buckets;
    std::vector<std::int32_t> m_fifo;
};

}  // namespace pliant
