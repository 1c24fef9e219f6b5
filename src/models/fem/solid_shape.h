// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common view of a mesh or lattice: nodes and cells.

#pragma once

#include <pliant/mesh.h>

#include "fem/hex_element.h"

namespace pliant {

/// Keeps a reference to its source.
class SolidShape {
  public:
    explicit SolidShape(const HexMesh& mesh) : m_mesh(&mesh) {}
    explicit SolidShape(const HexLattice& lattice) : m_lattice(&lattice) {}

    std::int64_t node_count() const {
        return m_mesh ? std::int64_t(m_mesh->nodes_mm.size()) : pliant::node_count(*m_lattice);
    }
    std::int64_t cell_count() const {
        return m_mesh ? std::int64_t(m_mesh->cells.size()) : pliant::cell_count(*m_lattice);
    }
    Vec3d position(std::int32_t node) const {
        return m_mesh ? m_mesh->nodes_mm[std::size_t(node)] : node_position_mm(*m_lattice, node);
    }
    std::array<std::int32_t, 8> nodes_of(std::int32_t cell) const {
        return m_mesh ? m_mesh->cells[std::size_t(cell)] : cell_corners(*m_lattice, cell);
    }
    HexCorners corners_of(std::int32_t cell) const {
        HexCorners corners;
        const auto nodes = nodes_of(cell);
        for (std::size_t c = 0; c < 8; ++c) corners[c] = position(nodes[c]);
        return corners;
    }
    /// Piece of each node; empty: one piece.
    std::vector<std::int32_t> piece_of_nodes() const {
        return m_mesh ? pieces(*m_mesh) : std::vector<std::int32_t>{};
    }

  private:
    const HexMesh* m_mesh = nullptr;
    const HexLattice* m_lattice = nullptr;
};

}  // namespace pliant
