// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stiffness matrix of a mesh of hexahedra: compressed rows of 3 × 3 blocks, one row per node,
// columns ascending.

#pragma once

#include <pliant/models/fem.h>

#include <span>
#include <vector>

#include "fem/stiffness.h"

namespace pliant {

class BlockMatrix : public Stiffness {
  public:
    /// @pre the solid has been checked
    BlockMatrix(const ElasticSolid& solid, HexElement element, const TaskArena& arena);

    void multiply(const NodeVector& displacement, NodeVector& force,
                  const TaskArena& arena) const override;
    Block3 diagonal_block(std::int32_t node) const override;
    std::int64_t bytes() const override;

    std::int32_t row_count() const { return std::int32_t(m_first.size() - 1); }
    std::span<const std::int32_t> columns(std::int32_t row) const {
        return {m_columns.data() + m_first[std::size_t(row)],
                m_columns.data() + m_first[std::size_t(row) + 1]};
    }
    std::span<const Block3> blocks(std::int32_t row) const {
        return {m_blocks.data() + m_first[std::size_t(row)],
                m_blocks.data() + m_first[std::size_t(row) + 1]};
    }

  private:
    void find_columns(const HexMesh& mesh);

    std::vector<std::int64_t> m_first;  ///< first block of each row, and the total
    std::vector<std::int32_t> m_columns;
    std::vector<Block3> m_blocks;
};

}  // namespace pliant
