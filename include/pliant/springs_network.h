// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mass-spring networks: point masses, and Voigt links between pairs of them.
//
// A link from i to j with r = x_i − x_j pulls node i with −f [Choi2004, Eq. 6],
//
//   f = ( stiffness · (|r| − rest_length) + damping · (v_i − v_j)·n ) n,     n = r/|r|
//
// A node is also damped by −damping · v. A cell of four or eight nodes may have a volume energy, ½
// bulk · (V − V₀)²/V₀. Links alone obey Cauchy's relations for every stiffness, so they always have
// a Poisson's ratio of 1/4.
//
// Any consistent units apply. Pliant uses mm, g, s, with forces in µN and moduli in Pa. The figures
// of [Choi2004] use m, kg, s, with forces in N.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct SpringNode {
    Vec3d rest{0, 0, 0};
    double mass = 1;
    double damping = 0;  ///< force per velocity of the node itself
    bool fixed = false;  ///< never moves
};

struct SpringLink {
    std::int32_t a, b;
    double stiffness = 1;  ///< force per length
    double damping = 0;    ///< force per velocity along the link
    /// Negative: the distance at rest.
    double rest_length = -1;
};

/// A tetrahedron of four nodes with positive volume (n1−n0)×(n2−n0)·(n3−n0)/6, or a hexahedron of
/// eight: n0…n3 around its bottom, n4…n7 above them, as in VTK.
///
///       7────6
///      ╱│   ╱│
///     4────5 │
///     │ 3──│─2
///     │╱   │╱
///     0────1
struct SpringCell {
    std::array<std::int32_t, 8> nodes{};
    std::int32_t node_count = 8;  ///< 4 or 8
    double bulk = 0;              ///< modulus of the volume energy; 0: none
};

/// Parts of a network, from a builder (springs_builders.h). They may be changed before the network
/// is created.
struct SpringParts {
    std::vector<SpringNode> nodes;
    std::vector<SpringLink> links;
    std::vector<SpringCell> cells;
};

/// Connectivity after a cut.
struct SpringCut {
    std::int64_t cut_links = 0, cut_cells = 0;  ///< by this call
    std::int32_t pieces = 1;                    ///< connected components of the network
    std::int32_t loose_nodes = 0;               ///< in pieces without a fixed node
};

class SpringNetwork {
  public:
    /// @returns InvalidArgument that names the node, link or cell: a mass that isn't above 0, a
    ///          negative stiffness, damping or bulk, a node that doesn't exist, a cell without
    ///          volume, or nodes that aren't connected to node 0
    static Result<SpringNetwork> create(SpringParts parts) noexcept;

    std::int32_t node_count() const { return std::int32_t(m_parts.nodes.size()); }
    std::span<const SpringNode> nodes() const { return m_parts.nodes; }
    /// In the order of the parts, with computed rest lengths.
    std::span<const SpringLink> links() const { return m_parts.links; }
    std::span<const SpringCell> cells() const { return m_parts.cells; }
    bool is_cut(std::size_t link) const { return m_link_cut[link]; }
    bool is_cell_cut(std::size_t cell) const { return m_cell_cut[cell]; }
    bool has_volume_energy() const { return m_has_volume_energy; }

    /// A link seen from one of its ends. 8 bytes.
    struct Neighbour {
        std::int32_t node, link;
    };
    /// Neighbours over uncut links, by ascending node.
    std::span<const Neighbour> neighbours(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {m_neighbours.data() + m_first[n], m_neighbours.data() + m_end[n]};
    }
    /// Cells of a node, including cut ones.
    std::span<const std::int32_t> cells_of(std::int32_t node) const {
        const auto n = std::size_t(node);
        return {m_cells_of.data() + m_first_cell[n], m_cells_of.data() + m_first_cell[n + 1]};
    }

    /// Stability bound of central differences near the rest shape: h²λ + 2hγ ≤ 4 [Courant1928],
    /// where λ and γ bound the eigenvalues of M⁻¹K and of M⁻¹C, C the damping of links. It is
    /// independent of the nodes' own damping. Exact for a chain; for lattices within a few percent
    /// of the first unstable step.
    double stable_time_step() const;

    /// Cuts links, and the volume energy of all cells that have one of them as an edge or diagonal.
    /// Links that are already cut stay cut.
    /// @returns InvalidArgument for a link that doesn't exist, LimitExceeded if memory runs out;
    ///          then nothing is cut
    Result<SpringCut> cut_links(std::span<const std::int32_t> links) noexcept;
    /// Cuts cells out: their volume energy, and all links that lie in no other cell.
    Result<SpringCut> cut_cells(std::span<const std::int32_t> cells) noexcept;

  private:
    struct PieceMemory;
    void index();
    void drop_cut_neighbours(std::int32_t node);
    void cut_link(std::size_t link, SpringCut& cut);
    void cut_cell(std::size_t cell, SpringCut& cut);
    SpringCut cut_out(std::span<const std::int32_t> cells);
    void count_pieces(SpringCut& cut, PieceMemory& memory) const;

    SpringParts m_parts;
    std::vector<std::int64_t> m_first, m_end, m_first_cell;  ///< offsets of each node
    std::vector<Neighbour> m_neighbours;
    std::vector<std::int32_t> m_cells_of;
    std::vector<std::uint8_t> m_link_cut, m_cell_cut;
    bool m_has_volume_energy = false;
};

}  // namespace pliant
#pragma GCC visibility pop
