// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "springs/order.h"

#include <string>

#include "base/errors.h"

namespace pliant {

Status check_sources(const SpringNetwork& network, std::span<const std::int32_t> sources,
                     const char* argument) {
    const auto complain = [&](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, std::string(argument) + ": " + text};
    };
    for (const std::int32_t node : sources) {
        if (node < 0 || node >= network.node_count())
            return complain("expected nodes below " + std::to_string(network.node_count()) +
                            ", found " + std::to_string(node));
        if (network.nodes()[std::size_t(node)].fixed)
            return complain("expected nodes that can move, found node " + std::to_string(node) +
                            ", which is fixed");
    }
    return Ok{};
}

Status check_depth(std::int32_t depth) {
    if (depth < 0)
        return about("depth", ErrorCode::InvalidArgument,
                     "expected 0 layers or more, found " + std::to_string(depth));
    return Ok{};
}

void OrderSearch::run(const SpringNetwork& network, std::span<const std::int32_t> sources,
                      std::int32_t depth, TransmittalOrder& order) {
    if (m_seen.size() != std::size_t(network.node_count()) || ++m_turn == 0) {
        m_seen.assign(std::size_t(network.node_count()), 0);
        m_turn = 1;
    }
    std::vector<std::int32_t>& nodes = order.nodes;
    nodes.clear();
    order.layers.assign(1, 0);
    const auto visit = [&](std::int32_t node) {
        std::uint32_t& seen = m_seen[std::size_t(node)];
        if (seen == m_turn || network.nodes()[std::size_t(node)].fixed) return;
        seen = m_turn;
        nodes.push_back(node);
    };
    for (const std::int32_t node : sources) visit(node);
    for (std::int32_t layer = 0;; ++layer) {
        const auto begin = std::size_t(order.layers.back());
        const std::size_t end = nodes.size();
        if (begin == end) break;  // all nodes have been reached
        order.layers.push_back(std::int32_t(end));
        if (layer == depth) break;
        for (std::size_t n = begin; n < end; ++n)
            for (const auto& neighbour : network.neighbours(nodes[n])) visit(neighbour.node);
    }
}

Result<TransmittalOrder> transmittal_order(const SpringNetwork& network,
                                           std::span<const std::int32_t> sources,
                                           std::int32_t depth) noexcept {
    return attempt([&]() -> Result<TransmittalOrder> {
        if (const Status status = check_sources(network, sources, "sources"); !status.ok())
            return status.error();
        if (const Status status = check_depth(depth); !status.ok()) return status.error();
        TransmittalOrder order;
        OrderSearch().run(network, sources, depth, order);
        return order;
    });
}

}  // namespace pliant
