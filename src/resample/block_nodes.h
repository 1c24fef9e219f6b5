// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A block of cells, laid out for vector lanes.
//
// The cells of a block belong to one brick, and their corners are its (size + 1)³ nodes: the
// brick's elements and the next layer on the high sides. Nodes are numbered n = x + row·(y + row·z)
// with row = size + 1, and a cell has the number of its lowest corner. So corner c of cells n, n +
// 1, … is at n + offset(c), n + 1 + offset(c), …: neighbouring lanes load neighbouring numbers,
// without any gather. Cells with x, y or z = size don't exist; their bits in `use` are never set.
//
// Displacements are single precision voxels relative to a whole-voxel shift of the block, so that
// they keep full precision however far the block went.

#pragma once

#include <pliant/volume.h>

#include <array>
#include <span>
#include <vector>

#include "resample/snapshot.h"

namespace pliant {

/// Places in the same order as cell corners: c & 1, c >> 1 & 1, c >> 2.
using BlockRecords = std::array<const BrickRecord*, 8>;

BlockRecords records_of_block(const Snapshot& snapshot, Vec3i coord);

/// Where the corners of a block's cells are now [voxels], from the bounds of its bricks.
struct BlockReach {
    Vec3d low, high;
};
BlockReach reach_of_block(const BlockRecords& records, const Grid& grid, int brick_size,
                          Vec3i coord);

class BlockNodes {
  public:
    /// Loads the cells that can write layers begin_z…end_z, and original values at their corners.
    /// @returns whether there are any
    bool load(const Snapshot& snapshot, const Lattice& lattice, const Volume& original, Vec3i coord,
              int begin_z, int end_z);

    int size() const { return m_size; }
    int row() const { return m_row; }
    int index(int x, int y, int z) const { return x + m_row * (y + m_row * z); }
    /// Inverse of index().
    Vec3i local(int n) const { return {n % m_row, n / m_row % m_row, n / (m_row * m_row)}; }
    /// One component of local(n) for all n.
    const float* place(int axis) const { return m_place[std::size_t(axis)].data(); }
    Vec3i first_element() const { return m_first; }
    /// Place that u is relative to: first_element() and the block's whole-voxel shift.
    Vec3i origin() const { return m_origin; }
    /// [voxels], padded by a vector's width beyond the last node
    const float* u(int axis) const { return m_u[std::size_t(axis)].data(); }
    const float* values() const { return m_values.data(); }
    /// Bit n: cell n is written. Padded to whole words.
    std::span<const RowBits> use() const { return m_use; }
    /// Displacements differ too much for single precision: cells go one by one.
    bool is_wild() const { return m_is_wild; }
    /// Exact displacement of a node.
    Vec3<Fixed> displacement(Vec3i local) const;
    /// The node's flags (ElementEdit).
    int edits(Vec3i local) const;
    const BlockReach& reach() const { return m_reach; }

  private:
    void resize(int brick_size);
    bool find_use(const Snapshot& snapshot, const Lattice& lattice, Vec3i coord);
    void drop_broken_cells(const Lattice& lattice);
    void fetch_ahead(const Snapshot& snapshot, Vec3i coord);
    void load_displacements(const Grid& grid, int axis);
    bool keep_layers_within(int begin_z, int end_z);
    void load_values(const Volume& original);

    int m_size = 0, m_row = 0;
    Vec3i m_first{}, m_origin{};
    BlockRecords m_records{};
    BlockReach m_reach{};
    bool m_is_wild = false;
    std::array<std::vector<float>, 3> m_u, m_place;
    std::vector<float> m_values;
    std::vector<RowBits> m_use;
    std::vector<Fixed> m_at_rest;  ///< a brick of zeros
    volatile Fixed m_ignored = 0;  ///< what is read only so that its page is known
};

/// Whether a cell hangs together: no corner is void, and where a link along one of its twelve edges
/// is cut, the two ends moved alike. A cut without any motion opens no gap, so such a cell is
/// written as if it were whole; it is gone as soon as the cut opens.
bool cell_is_whole(const BlockNodes& block, Vec3i cell);

}  // namespace pliant
