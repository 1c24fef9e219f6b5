// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "springs/cell_volume.h"
#include "springs/pieces.h"

#include "base/errors.h"

namespace pliant {
namespace {

Error bad_network(const std::string& text) {
    return {ErrorCode::InvalidArgument, "network: " + text};
}
Error bad_network(const char* what, std::size_t index, const std::string& text) {
    return bad_network(what + std::string(" ") + std::to_string(index) + ": " + text);
}
/// Whether a number is finite and ≥ 0.
bool is_amount(double value) {
    return std::isfinite(value) && value >= 0;
}

Status check_nodes(std::span<const SpringNode> nodes) {
    if (nodes.empty() || nodes.size() > std::size_t(INT32_MAX) / 2)
        return bad_network("expected 1 to 1073741823 nodes, found " + std::to_string(nodes.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (!is_finite(nodes[n].rest))
            return bad_network("node", n, "expected a rest position of three numbers");
        if (!(std::isfinite(nodes[n].mass) && nodes[n].mass > 0))
            return bad_network("node", n,
                               "expected a mass above 0, found " + std::to_string(nodes[n].mass));
        if (!is_amount(nodes[n].damping))
            return bad_network(
                "node", n,
                "expected a damping of 0 or more, found " + std::to_string(nodes[n].damping));
    }
    return Ok{};
}

Status check_links(std::span<const SpringLink> links, std::size_t node_count) {
    const auto is_there = [&](std::int32_t n) { return n >= 0 && std::size_t(n) < node_count; };
    if (links.size() > std::size_t(INT32_MAX))
        return bad_network("expected up to 2147483647 links, found " +
                           std::to_string(links.size()));
    for (std::size_t l = 0; l < links.size(); ++l) {
        const SpringLink& link = links[l];
        if (!is_there(link.a) || !is_there(link.b) || link.a == link.b)
            return bad_network("link", l,
                               "expected two different nodes below " + std::to_string(node_count) +
                                   ", found " + std::to_string(link.a) + " and " +
                                   std::to_string(link.b));
        if (!is_amount(link.stiffness))
            return bad_network(
                "link", l,
                "expected a stiffness of 0 or more, found " + std::to_string(link.stiffness));
        if (!is_amount(link.damping))
            return bad_network(
                "link", l,
                "expected a damping of 0 or more, found " + std::to_string(link.damping));
        if (!std::isfinite(link.rest_length))
            return bad_network("link", l, "expected a rest length that is a number");
        if (!is_amount(link.branch_stiffness))
            return bad_network("link", l,
                               "expected a branch stiffness of 0 or more, found " +
                                   std::to_string(link.branch_stiffness));
        if (link.branch_stiffness > 0 && !(std::isfinite(link.branch_time) && link.branch_time > 0))
            return bad_network(
                "link", l,
                "expected a branch time above 0, found " + std::to_string(link.branch_time));
    }
    return Ok{};
}

Status check_cells(const SpringParts& parts) {
    for (std::size_t c = 0; c < parts.cells.size(); ++c) {
        const SpringCell& cell = parts.cells[c];
        if (cell.node_count != 4 && cell.node_count != 8)
            return bad_network("cell", c,
                               "expected 4 or 8 nodes, found " + std::to_string(cell.node_count));
        for (int n = 0; n < cell.node_count; ++n)
            if (cell.nodes[std::size_t(n)] < 0 ||
                std::size_t(cell.nodes[std::size_t(n)]) >= parts.nodes.size())
                return bad_network("cell", c,
                                   "expected nodes below " + std::to_string(parts.nodes.size()) +
                                       ", found " + std::to_string(cell.nodes[std::size_t(n)]));
        if (!is_amount(cell.bulk))
            return bad_network("cell", c,
                               "expected a bulk of 0 or more, found " + std::to_string(cell.bulk));
        const double volume =
            cell_volume(cell, [&](std::int32_t n) { return parts.nodes[std::size_t(n)].rest; });
        if (!(volume > 0))
            return bad_network("cell", c,
                               "expected a volume above 0, found " + std::to_string(volume));
    }
    return Ok{};
}

}  // namespace

Result<SpringNetwork> SpringNetwork::create(SpringParts parts) noexcept {
    return attempt([&]() -> Result<SpringNetwork> {
        if (const Status status = check_nodes(parts.nodes); !status.ok()) return status.error();
        if (const Status status = check_links(parts.links, parts.nodes.size()); !status.ok())
            return status.error();
        if (const Status status = check_cells(parts); !status.ok()) return status.error();
        for (SpringLink& link : parts.links)
            if (link.rest_length < 0)
                link.rest_length = norm(parts.nodes[std::size_t(link.a)].rest -
                                        parts.nodes[std::size_t(link.b)].rest);
        SpringNetwork network;
        network.m_parts = std::move(parts);
        network.index();
        const Pieces pieces = pieces_of(network);
        if (pieces.count > 1)
            for (std::size_t n = 0; n < pieces.piece_of.size(); ++n)
                if (pieces.piece_of[n] != 0)
                    return bad_network("node", n,
                                       "expected a chain of links to node 0; the network is in " +
                                           std::to_string(pieces.count) + " pieces");
        return network;
    });
}

void SpringNetwork::index() {
    const std::size_t count = m_parts.nodes.size();
    m_link_cut.assign(m_parts.links.size(), 0);
    m_cell_cut.assign(m_parts.cells.size(), 0);
    m_first.assign(count + 1, 0);
    for (const SpringLink& link : m_parts.links) {
        ++m_first[std::size_t(link.a) + 1];
        ++m_first[std::size_t(link.b) + 1];
    }
    for (std::size_t n = 0; n < count; ++n) m_first[n + 1] += m_first[n];
    m_neighbours.resize(2 * m_parts.links.size());
    std::vector<std::int64_t> next(m_first.begin(), m_first.end() - 1);
    for (std::size_t l = 0; l < m_parts.links.size(); ++l) {
        const auto [a, b] = std::pair(m_parts.links[l].a, m_parts.links[l].b);
        m_neighbours[std::size_t(next[std::size_t(a)]++)] = {b, std::int32_t(l)};
        m_neighbours[std::size_t(next[std::size_t(b)]++)] = {a, std::int32_t(l)};
    }
    m_end.assign(m_first.begin() + 1, m_first.end());
    for (std::size_t n = 0; n < count; ++n)
        std::sort(m_neighbours.begin() + m_first[n], m_neighbours.begin() + m_end[n],
                  [](const Neighbour& p, const Neighbour& q) {
                      return p.node != q.node ? p.node < q.node : p.link < q.link;
                  });
    m_first_cell.assign(count + 1, 0);
    const auto each_corner = [&](const auto& visit) {
        for (std::size_t c = 0; c < m_parts.cells.size(); ++c)
            for (int n = 0; n < m_parts.cells[c].node_count; ++n)
                visit(std::size_t(m_parts.cells[c].nodes[std::size_t(n)]), std::int32_t(c));
    };
    each_corner([&](std::size_t n, std::int32_t) { ++m_first_cell[n + 1]; });
    for (std::size_t n = 0; n < count; ++n) m_first_cell[n + 1] += m_first_cell[n];
    m_cells_of.resize(std::size_t(m_first_cell.back()));
    next.assign(m_first_cell.begin(), m_first_cell.end() - 1);
    each_corner([&](std::size_t n, std::int32_t c) { m_cells_of[std::size_t(next[n]++)] = c; });
    m_has_volume_energy = std::any_of(m_parts.cells.begin(), m_parts.cells.end(),
                                      [](const SpringCell& cell) { return cell.bulk > 0; });
    m_has_branches = std::any_of(m_parts.links.begin(), m_parts.links.end(),
                                 [](const SpringLink& link) { return link.branch_stiffness > 0; });
}

}  // namespace pliant
