// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Orderings on a graph: one waiting list of candidates, each with the link to its sponsor.
//
// Enhanced ChainMail [Schill1998] sorts the list by the amount of constraint violation, so that
// information travels fastest through stiff material; one number stands for all three components.
// Generalised ChainMail [Li2003] takes candidates in the order in which their sponsors moved. In
// both, elements move once, so that the list is short. With requeue they may move again, two-sided:
// a candidate may be pulled back by a sponsor that has not arrived yet itself. A link that is
// already in the list is not added again; without this rule lists grow without bound.

#include <algorithm>

#include "chains/graph_limits.h"
#include "chains/published_ordering.h"

namespace pliant {
namespace {

struct Candidate {
    double violation;
    std::int32_t sponsor;
    const ChainNeighbour* link;  ///< from the sponsor to the candidate
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return a.violation < b.violation;
    }
};

/// Takes the candidate with the largest violation first.
class SortedList {
  public:
    static constexpr bool kIsSorted = true;
    bool empty() const { return m_heap.empty(); }
    void clear() { m_heap.clear(); }
    void put(const Candidate& candidate) {
        m_heap.push_back(candidate);
        std::push_heap(m_heap.begin(), m_heap.end());
    }
    Candidate take() {
        std::pop_heap(m_heap.begin(), m_heap.end());
        const Candidate taken = m_heap.back();
        m_heap.pop_back();
        return taken;
    }

  private:
    std::vector<Candidate> m_heap;
};

/// Takes candidates in the order of their arrival.
class FirstInFirstOut {
  public:
    static constexpr bool kIsSorted = false;
    bool empty() const { return m_next == m_list.size(); }
    void clear() {
        m_list.clear();
        m_next = 0;
    }
    void put(const Candidate& candidate) { m_list.push_back(candidate); }
    Candidate take() {
        const Candidate taken = m_list[m_next++];
        if (empty()) {
            clear();
        } else if (2 * m_next > m_list.size()) {  // drop the consumed part
            m_list.erase(m_list.begin(), m_list.begin() + std::ptrdiff_t(m_next));
            m_next = 0;
        }
        return taken;
    }

  private:
    std::vector<Candidate> m_list;
    std::size_t m_next = 0;
};

template <class List>
class GraphOrdering final : public PublishedOrdering {
  public:
    GraphOrdering(std::shared_ptr<const ChainGraph> graph, bool once)
        : PublishedOrdering(bounds_of(*graph)),
          m_graph(std::move(graph)),
          m_once(once),
          m_waiting(List::kIsSorted ? 0 : std::size_t(2 * m_graph->link_count()), 0) {}

  private:
    static std::vector<Bounds> bounds_of(const ChainGraph& graph) {
        std::vector<Bounds> bounds;
        for (const ChainElement& e : graph.elements())
            bounds.push_back({float(e.max_movement_mm), e.fixed});
        return bounds;
    }
    /// An initial element stays at the tool's position.
    bool is_settled(std::int32_t e) const { return m_once ? is_moved(e) : is_initial(e); }
    std::uint8_t& is_waiting(const ChainNeighbour& link) {
        return m_waiting[std::size_t(&link - m_graph->neighbours(0).data())];
    }
    void put_neighbours(std::int32_t sponsor);
    bool propagate(std::span<const std::int32_t> initial) override;

    const std::shared_ptr<const ChainGraph> m_graph;
    const bool m_once;
    std::vector<std::uint8_t> m_waiting;  ///< [link and direction]: 1: in the list
    List m_list;
};

template <class List>
void GraphOrdering<List>::put_neighbours(std::int32_t sponsor) {
    for (const ChainNeighbour& link : m_graph->neighbours(sponsor)) {
        if (is_settled(link.element)) continue;
        double amount = 0;
        if constexpr (List::kIsSorted) {
            amount = violation(u(link.element), u(sponsor), mm_from_units(link.low),
                               mm_from_units(link.high));
            if (amount <= 0) continue;
        } else {
            if (is_waiting(link)) continue;
            is_waiting(link) = 1;
        }
        m_list.put({amount, sponsor, &link});
    }
}

template <class List>
bool GraphOrdering<List>::propagate(std::span<const std::int32_t> initial) {
    if (!m_list.empty()) {  // the last attempt was abandoned
        m_list.clear();
        std::fill(m_waiting.begin(), m_waiting.end(), 0);
    }
    for (const std::int32_t e : initial) put_neighbours(e);
    while (!m_list.empty()) {
        if (!count_candidate()) return false;
        const Candidate c = m_list.take();
        const std::int32_t element = c.link->element;
        if constexpr (!List::kIsSorted) is_waiting(*c.link) = 0;
        if (is_settled(element)) continue;
        const Vec3d to = clamped(u(element), u(c.sponsor), mm_from_units(c.link->low),
                                 mm_from_units(c.link->high));
        if (to == u(element)) continue;
        if (!move(element, to)) return false;
        put_neighbours(element);
    }
    return true;
}

}  // namespace

std::unique_ptr<OrderingSolver> make_schill(std::shared_ptr<const ChainGraph> graph, bool once) {
    return std::make_unique<GraphOrdering<SortedList>>(std::move(graph), once);
}

std::unique_ptr<OrderingSolver> make_li(std::shared_ptr<const ChainGraph> graph, bool once) {
    return std::make_unique<GraphOrdering<FirstInFirstOut>>(std::move(graph), once);
}

}  // namespace pliant
