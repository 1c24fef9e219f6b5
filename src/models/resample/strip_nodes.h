// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A strip of cells, laid out for vector lanes.
//
// A strip is a number of bricks in a row along x, enough that a row of their cells fills a vector.
// The corners of its cells are its nodes: the bricks' elements and the next layer on the high
// sides. Nodes are numbered n = x + row·(y + row_count·z), and a cell has the number of its lowest
// corner. So corner c of cells n, n + 1, … is at n + offset(c), n + 1 + offset(c), …: adjacent
// lanes load adjacent numbers, without gathers.
//
// Displacements are single precision relative to a whole-voxel shift of the strip, so that they
// keep full precision at any distance.

#pragma once

#include <pliant/volume.h>

#include <array>
#include <span>
#include <vector>

#include "resample/ahead.h"
#include "resample/snapshot.h"

namespace pliant {

// Cells that a deformation moves, and voxels that it can change: one bit each, brick by brick.
//
// A cell is touched if one of its corners moved or is void. Untouched cells keep their positions,
// so the touched ones together cover at most their region at rest: a voxel can change only if all
// eight cells around it are touched.
//
// A brick's cells, named by their lowest corners, are a block: some of their corners are in
// neighbouring bricks.

/// Share of a brick's voxels.
enum class Share { None, Some, All };

/// Bounds of the present positions of some cells' corners [voxels], from the bounds of the bricks.
struct CellReach {
    Vec3d low, high;
};

class TouchedCells {
  public:
    void find(const Snapshot& snapshot, int brick_size, const TaskArena& arena);

    /// Bricks with touched cells, sorted by coordinate. A cell belongs to the brick of its lowest
    /// corner, which need not be among the snapshot's.
    const std::vector<Vec3i>& bricks() const { return m_bricks; }
    /// The brick's touched cells, named by their lowest corner; null: none
    const BitWord* cells(Vec3i brick) const {
        const int found = find(brick);
        return found < 0 ? nullptr : bits_of(found);
    }
    /// Reach of the blocks of some bricks in a row along x.
    CellReach reach(const Grid& grid, Vec3i first, int bricks) const;
    /// Finds the brick's voxels that can change.
    Share changeable(Vec3i brick, BitWord* voxels) const;

  private:
    /// Bounds of displacements.
    struct Bounds {
        Vec3<Fixed> low{0, 0, 0}, high{0, 0, 0};
    };

    void list_bricks(const Snapshot& snapshot);
    static Bounds bounds_of(const BlockRecords& records);
    std::size_t slot_of(Vec3i brick) const {
        const Vec3i p = brick - m_box.begin, n = m_box.end - m_box.begin;
        return std::size_t(p.x) +
               std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
    }
    int find(Vec3i brick) const { return contains(m_box, brick) ? m_index_of[slot_of(brick)] : -1; }
    const BitWord* bits_of(int index) const {
        return m_cells.data() + std::size_t(index) * m_words_per_brick;
    }

    int m_size = 0;
    Box3i m_box{};
    std::vector<std::int32_t> m_index_of;  ///< [slot of m_box]; −1: no touched cells
    std::vector<Vec3i> m_bricks;
    std::vector<BitWord> m_cells;
    std::size_t m_words_per_brick = 0;
    std::vector<std::uint8_t> m_is_full;
    std::vector<Bounds> m_bounds;  ///< of the blocks' corners
};

/// A row of nodes along x.
struct NodeRow {
    int y, z;
};

/// Data, beside the cells, that determine the bits of all of a strip's voxels.
struct StripFrame {
    Vec3<Fixed> base;  ///< displacement to which those of the nodes are relative
    bool is_wild;      ///< displacements differ too much for single precision
    bool operator==(const StripFrame&) const = default;
};
StripFrame frame_of_strip(const Snapshot& snapshot, const Grid& grid, int brick_size, Vec3i coord,
                          const CellReach& reach);

class StripNodes {
  public:
    /// Loads the cells that may hold voxels of some boxes, and original values at their corners.
    /// @param coord  the strip's first brick. @param reach  of the strip
    /// @returns whether there are any
    bool load(const Snapshot& snapshot, const TouchedCells& touched, const Field& field,
              const Volume& original, Vec3i coord, const CellReach& reach,
              std::span<const Box3i> within);

    /// Queues the displacements that another strip's load will read, except the ones that this
    /// strip's load has just read.
    void note(const Snapshot& snapshot, Vec3i coord, Ahead& ahead) const;

    /// Rows of cells are size() by size(), cells() long.
    int size() const { return m_size; }
    int cells() const { return m_row - 1; }
    int row() const { return m_row; }
    int slice() const { return m_row * (m_size + 1); }
    int index(int x, int y, int z) const { return x + m_row * y + slice() * z; }
    /// Inverse of index().
    Vec3i local(int n) const { return {n % m_row, n / m_row % (m_size + 1), n / slice()}; }
    Vec3i first_element() const { return m_first; }
    /// Position to which u is relative: first_element() plus the strip's whole-voxel shift.
    Vec3i origin() const { return m_origin; }
    /// Displacements in eighths of a voxel, the summands of the cells' coefficients. Rows that no
    /// cell in use() needs are not set. Padded by a vector's width.
    const float* eighth_u(int axis) const { return m_u[std::size_t(axis)].data(); }
    const float* values() const { return m_values.data(); }
    /// Bit x of row y + size()·z: the cell is written.
    std::span<const RowBits> use() const { return m_use; }
    /// Whether cells must be written one by one.
    bool is_wild() const { return m_frame.is_wild; }
    /// Exact displacement of a node.
    Vec3<Fixed> displacement(Vec3i local) const;
    /// The node's flags (ElementEdit).
    int edits(Vec3i local) const;
    const CellReach& reach() const { return m_reach; }

  private:
    void resize(int brick_size);
    void list_rows();
    bool find_use(const TouchedCells& touched, const Field& field, Vec3i coord);
    void drop_broken_cells(const Field& field);
    void load_displacements(const Grid& grid, int axis);
    void load_values(const Volume& original);
    const BrickRecord* record(int brick, int hy, int hz) const {
        return m_records[std::size_t(brick + (m_bricks + 1) * (hy + 2 * hz))];
    }
    const BrickRecord* record_of(Vec3i local, int& element) const;

    /// Position of a node's coordinate: the brick, and the element in it.
    struct InBrick {
        int brick, element;
    };

    int m_size = 0, m_bricks = 0, m_row = 0;
    std::vector<InBrick> m_in_brick;  ///< [x], x = 0 … cells()
    Vec3i m_first{}, m_origin{};
    std::vector<const BrickRecord*> m_records;  ///< along x, then two along y, two along z
    CellReach m_reach{};
    StripFrame m_frame{};
    std::array<std::vector<float>, 3> m_u;
    std::vector<float> m_values;
    std::vector<RowBits> m_use;
    std::vector<NodeRow> m_rows;       ///< needed by cells in use
    std::vector<const Fixed*> m_from;  ///< one component in all bricks
    std::vector<Fixed> m_at_rest;      ///< a brick of zeros
};

/// Whether a cell hangs together: no corner is void, and where a link along one of its twelve edges
/// is cut, the two ends moved alike. A cut without any motion opens no gap, so such a cell is
/// written as if it were whole; it is gone as soon as the cut opens.
bool cell_is_whole(const StripNodes& strip, Vec3i cell);

}  // namespace pliant
