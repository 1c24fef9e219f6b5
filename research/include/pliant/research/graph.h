// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail on any graph, solved exactly.
//
// Elements have rest positions. A link joins any two of them. For component a of the displacement
// u, a link from i to j requires
//
//   low_a ≤ u_a(j) − u_a(i) ≤ high_a,     low_a ≤ 0 ≤ high_a
//
// Generalised ChainMail [Li2003] derives the limits from materials and the rest offset d = X_j −
// X_i:
//
//   d_a > 0:  −(|d_a|·compress_a + S) ≤ u_a(j) − u_a(i) ≤ |d_a|·stretch_a + S,
//             S = Σ |d_b|·shear_b over the other components b ≠ a
//    d_a < 0:  compress and stretch are exchanged
//
// The material of a link is the mean of the materials at its two ends. A lattice with six
// neighbours is the special case in which d has one component: its graph gives the same bits as
// ChainMail.
//
// @code
//   const auto graph =
//       graph_of_lattice({.size = {20, 20, 1}, .materials = {limits}}, Neighbours::All);
//   GraphChainMail tissue(*graph);
//   auto report = tissue.push(std::array{210}, {3, 0, 0}, arena);
// @endcode

#pragma once

#include <pliant/chainmail.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ChainElement {
    Vec3d rest_mm{0, 0, 0};
    double max_movement_mm = 500;  ///< largest distance from the rest position, 0…500
    bool fixed = false;            ///< never moves
};

/// low ≤ u(b) − u(a) ≤ high for each component [mm]; low ≤ 0 ≤ high.
struct ChainLink {
    std::int32_t a, b;
    Vec3d low_mm, high_mm;
};

/// Two elements that a link joins.
struct ChainEdge {
    std::int32_t a, b;
    friend constexpr auto operator<=>(const ChainEdge&, const ChainEdge&) = default;
};

/// A link seen from one of its ends: low ≤ u(element) − u(this end) ≤ high [2⁻²⁰ mm]. 28 bytes.
struct ChainNeighbour {
    std::int32_t element;
    Vec3i low, high;
};

/// Immutable. Limits are whole multiples of 2⁻²⁰ mm, rounded towards tighter.
/// Thread safety: immutable.
class ChainGraph {
  public:
    /// @returns InvalidArgument that names the element or link
    static Result<ChainGraph> create(std::vector<ChainElement> elements,
                                     std::span<const ChainLink> links);
    /// @param material_of  index into the materials for each element; empty: the first material
    /// @returns InvalidArgument that names the element, edge or material
    static Result<ChainGraph> create(std::span<const Vec3d> rest_mm,
                                     std::span<const ElementLimits> materials,
                                     std::span<const std::uint8_t> material_of,
                                     std::span<const ChainEdge> edges);

    std::int32_t element_count() const { return std::int32_t(m_elements.size()); }
    std::int64_t link_count() const { return std::int64_t(m_neighbours.size() / 2); }
    std::span<const ChainElement> elements() const { return m_elements; }
    /// Neighbours of an element, in the order in which the links were given.
    std::span<const ChainNeighbour> neighbours(std::int32_t element) const {
        const auto e = std::size_t(element);
        return {m_neighbours.data() + m_first[e], m_neighbours.data() + m_first[e + 1]};
    }

  private:
    std::vector<ChainElement> m_elements;
    std::vector<std::int64_t> m_first;  ///< offset of each element's first neighbour, and the total
    std::vector<ChainNeighbour> m_neighbours;
};

/// Dense box of elements, i fastest: the input of the published orderings.
struct ChainLattice {
    Vec3i size{1, 1, 1};  ///< size.z = 1: a plane
    Vec3d spacing_mm{1, 1, 1};
    std::vector<ElementLimits> materials{};  ///< at least one, 256 at most
    std::vector<std::uint8_t> material{};    ///< of each element; empty: the first material
    std::vector<std::uint8_t> present{};     ///< 0: the element is absent; empty: all are present
};

/// @returns InvalidArgument that names the field
Status check_chain_lattice(const ChainLattice& lattice);

enum class Neighbours {
    Faces,  ///< 6; in a plane 4
    Edges,  ///< 18; in a plane 8
    All,    ///< 26; in a plane 8
};

/// Builds a graph in which element (i, j, k) has the number i + size.x·(j + size.y·k). An absent
/// element has no links.
Result<ChainGraph> graph_of_lattice(const ChainLattice& lattice, Neighbours neighbours);

/// The edges of a mesh, each once, in ascending order.
std::vector<ChainEdge> edges_of_triangles(std::span<const std::array<std::int32_t, 3>> triangles);
std::vector<ChainEdge> edges_of_tetrahedra(std::span<const std::array<std::int32_t, 4>> tetrahedra);

/// Links outside of their limits.
struct LinkState {
    std::int64_t violated_links = 0;  ///< by more than the tolerance, in any component
    double max_violation_mm = 0;
};
/// @param displacement_mm  of each element of the graph, [element]
LinkState check_links(const ChainGraph& graph, std::span<const Vec3d> displacement_mm,
                      double tolerance_mm);

/// Order in which candidates are processed. All give the same bits.
enum class GraphQueue {
    Buckets,  ///< coarse classes of the raise; an element may be processed more than once
    Heap,     ///< the largest raise first [Dijkstra1959]: each element once
    Fifo,     ///< first in, first out [Bellman1958]: short code, slow
};

/// Thread safety: concurrent reads.
class GraphChainMail {
  public:
    /// Keeps a reference: the graph must outlive it.
    explicit GraphChainMail(const ChainGraph& graph, GraphQueue queue = GraphQueue::Buckets);
    ~GraphChainMail();
    GraphChainMail(GraphChainMail&&) noexcept;
    GraphChainMail& operator=(GraphChainMail&&) noexcept;

    /// Moves the elements together, as far as fixed elements and movement limits allow. The three
    /// components are solved in parallel.
    /// @returns InvalidArgument if an element doesn't exist, or the push isn't finite or exceeds
    ///          500 mm
    Result<PushReport> push(std::span<const std::int32_t> elements, Vec3d push_mm,
                            const TaskArena& arena);
    Vec3d displacement_mm(std::int32_t element) const;
    std::vector<Vec3d> displacements_mm() const;
    /// Hash of all displacements, equal for every queue and number of threads.
    std::uint64_t hash() const;
    /// Returns every element to its rest position.
    void reset();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
