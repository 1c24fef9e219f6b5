// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts. Links keep their numbers: a node's list of neighbours only shrinks.

#include <pliant/models/springs.h>

#include <algorithm>
#include <string>

#include "base/errors.h"
#include "springs/pieces.h"

namespace pliant {
namespace {

template <class T>
Status check_indices(const char* what, std::span<const std::int32_t> indices,
                     std::span<const T> all) {
    for (const std::int32_t i : indices)
        if (i < 0 || std::size_t(i) >= all.size())
            return Error{ErrorCode::InvalidArgument, std::string("cut: expected ") + what +
                                                         " below " + std::to_string(all.size()) +
                                                         ", found " + std::to_string(i)};
    return Ok{};
}

bool has_corner(const SpringCell& cell, std::int32_t node) {
    const auto end = cell.nodes.begin() + cell.node_count;
    return std::find(cell.nodes.begin(), end, node) != end;
}

/// @param waiting  scratch. Doesn't allocate if both vectors have capacity for all nodes
void find_pieces(const SpringNetwork& network, Pieces& pieces, std::vector<std::int32_t>& waiting) {
    pieces.count = 0;
    pieces.piece_of.assign(std::size_t(network.node_count()), -1);
    for (std::int32_t start = 0; start < network.node_count(); ++start) {
        if (pieces.piece_of[std::size_t(start)] >= 0) continue;
        pieces.piece_of[std::size_t(start)] = pieces.count;
        waiting.assign(1, start);
        while (!waiting.empty()) {
            const std::int32_t node = waiting.back();
            waiting.pop_back();
            for (const auto& neighbour : network.neighbours(node))
                if (std::int32_t& piece = pieces.piece_of[std::size_t(neighbour.node)]; piece < 0) {
                    piece = pieces.count;
                    waiting.push_back(neighbour.node);
                }
        }
        ++pieces.count;
    }
}

}  // namespace

Pieces pieces_of(const SpringNetwork& network) {
    Pieces pieces;
    std::vector<std::int32_t> waiting;
    find_pieces(network, pieces, waiting);
    return pieces;
}

/// Memory for counting pieces.
struct SpringNetwork::PieceMemory {
    explicit PieceMemory(std::int32_t nodes) {
        pieces.piece_of.reserve(std::size_t(nodes));
        waiting.reserve(std::size_t(nodes));
        held.reserve(std::size_t(nodes));
    }
    Pieces pieces;
    std::vector<std::int32_t> waiting;
    std::vector<std::uint8_t> held;
};

void SpringNetwork::drop_cut_neighbours(std::int32_t node) {
    const auto n = std::size_t(node);
    const auto end =
        std::remove_if(m_neighbours.begin() + m_first[n], m_neighbours.begin() + m_end[n],
                       [&](const Neighbour& other) { return m_link_cut[std::size_t(other.link)]; });
    m_end[n] = end - m_neighbours.begin();
}

void SpringNetwork::cut_cell(std::size_t cell, SpringCut& cut) {
    if (m_cell_cut[cell]) return;
    m_cell_cut[cell] = 1;
    ++cut.cut_cells;
}

void SpringNetwork::cut_link(std::size_t l, SpringCut& cut) {
    if (m_link_cut[l]) return;
    m_link_cut[l] = 1;
    ++cut.cut_links;
    const SpringLink& link = m_parts.links[l];
    drop_cut_neighbours(link.a);
    drop_cut_neighbours(link.b);
    for (const std::int32_t c : cells_of(link.a))
        if (has_corner(m_parts.cells[std::size_t(c)], link.b)) cut_cell(std::size_t(c), cut);
}

void SpringNetwork::count_pieces(SpringCut& cut, PieceMemory& memory) const {
    Pieces& pieces = memory.pieces;
    find_pieces(*this, pieces, memory.waiting);
    cut.pieces = pieces.count;
    std::vector<std::uint8_t>& held = memory.held;
    held.assign(std::size_t(pieces.count), 0);
    for (std::size_t n = 0; n < pieces.piece_of.size(); ++n)
        if (m_parts.nodes[n].fixed) held[std::size_t(pieces.piece_of[n])] = 1;
    cut.loose_nodes =
        std::int32_t(std::count_if(pieces.piece_of.begin(), pieces.piece_of.end(),
                                   [&](std::int32_t piece) { return !held[std::size_t(piece)]; }));
}

Result<SpringCut> SpringNetwork::cut_links(std::span<const std::int32_t> links) noexcept {
    return attempt([&]() -> Result<SpringCut> {
        const Status status =
            check_indices("a link", links, std::span<const SpringLink>(m_parts.links));
        if (!status.ok()) return status.error();
        PieceMemory memory(node_count());
        SpringCut cut;
        for (const std::int32_t l : links) cut_link(std::size_t(l), cut);
        count_pieces(cut, memory);
        return cut;
    });
}

Result<SpringCut> SpringNetwork::cut_cells(std::span<const std::int32_t> cells) noexcept {
    return attempt([&]() -> Result<SpringCut> {
        const Status status =
            check_indices("a cell", cells, std::span<const SpringCell>(m_parts.cells));
        if (!status.ok()) return status.error();
        PieceMemory memory(node_count());
        SpringCut cut = cut_out(cells);
        count_pieces(cut, memory);
        return cut;
    });
}

SpringCut SpringNetwork::cut_out(std::span<const std::int32_t> cells) {
    SpringCut cut;
    for (const std::int32_t c : cells) cut_cell(std::size_t(c), cut);
    const auto is_in_a_cell = [&](const SpringLink& link) {
        const auto around = cells_of(link.a);
        return std::any_of(around.begin(), around.end(), [&](std::int32_t c) {
            return !m_cell_cut[std::size_t(c)] && has_corner(m_parts.cells[std::size_t(c)], link.b);
        });
    };
    for (const std::int32_t c : cells) {
        const SpringCell& cell = m_parts.cells[std::size_t(c)];
        for (int n = 0; n < cell.node_count; ++n) {
            const std::int32_t node = cell.nodes[std::size_t(n)];
            // Backwards, because cutting a link shortens the list behind it.
            for (std::size_t i = neighbours(node).size(); i-- > 0;) {
                const Neighbour other = neighbours(node)[i];
                if (!has_corner(cell, other.node)) continue;
                if (!is_in_a_cell(m_parts.links[std::size_t(other.link)]))
                    cut_link(std::size_t(other.link), cut);
            }
        }
    }
    return cut;
}

}  // namespace pliant
