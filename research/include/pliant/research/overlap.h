// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Self-collision of a deforming mesh: finds nodes inside of tetrahedra that don't contain them,
// where bodies or parts of one interpenetrate. Uses spatial hashing of a grid [Teschner2003].
//
// @code
//   OverlapSearch search(mesh);                  // two vessels in one mesh
//   for (const NodeInCell& n : search.find(positions)) show(n.node, n.cell);
// @endcode

#pragma once

#include <pliant/core/vec.h>
#include <pliant/mesh.h>

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct NodeInCell {
    std::int32_t cell, node;
    auto operator<=>(const NodeInCell&) const = default;
};

/// Thread safety: concurrent reads.
class OverlapSearch {
  public:
    /// The grid's cell size is the mean edge length of the mesh. Positive and inverted tetrahedra
    /// are searched alike; flat ones contain no points.
    explicit OverlapSearch(const TetMesh& mesh);

    /// Returns pairs by cell, then by node, valid until the next call. A node on a face is inside;
    /// a node with a position that isn't finite is skipped. @pre positions.size() is the number of
    /// the mesh's nodes
    std::span<const NodeInCell> find(std::span<const Vec3d> positions);

  private:
    struct Entry {
        Vec3i cell;
        std::int32_t next;  ///< node with the same hash, or −1
    };
    Vec3i cell_of(Vec3d position) const;
    std::size_t slot_of(Vec3i cell) const;
    void test(std::int32_t cell, std::span<const Vec3d> positions);

    std::vector<std::array<std::int32_t, 4>> m_cells;
    double m_per_length = 1;
    std::vector<Entry> m_nodes;
    std::vector<std::int32_t> m_heads, m_stamps;  ///< [slot]; a slot with an older stamp is empty
    std::int32_t m_stamp = 0;
    std::vector<NodeInCell> m_found;
};

}  // namespace pliant
#pragma GCC visibility pop
