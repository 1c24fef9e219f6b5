// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The pending changes of a client: one bit per 4³ voxels, independent of the client's speed.
// Further changes of a dirty block are free; it is sent with its newest values.

#pragma once

#include <pliant/volume.h>

#include <cstdint>
#include <vector>

namespace pliant::serve {

class DirtyBlocks {
  public:
    static constexpr int kEdge = 4;  ///< voxels along a block's edge
    /// Limit of the voxels in a box of take(), except for one row of blocks.
    static constexpr std::int64_t kMaxBoxVoxels = 1 << 19;

    DirtyBlocks() = default;
    /// Starts clean. @param size  of the volume [voxels]
    explicit DirtyBlocks(Vec3i size);

    /// @param box  clipped to the volume
    void mark(const Box3i& box);
    void mark_all();
    void mark(const DirtyBlocks& other);
    void clear();
    bool empty() const { return m_count == 0; }
    bool contains(Vec3i voxel) const;
    /// Indices of the dirty blocks, i fastest.
    std::vector<Vec3i> blocks() const;

    /// Takes boxes that cover the dirty blocks with little excess, in order of k. Covered blocks
    /// become clean.
    /// @param max_voxels  stops once the boxes have this number of voxels
    std::vector<Box3i> take(std::int64_t max_voxels);

  private:
    std::size_t index(int i, int j, int k) const {
        return std::size_t(i) + std::size_t(m_blocks.x) *
                                    (std::size_t(j) + std::size_t(m_blocks.y) * std::size_t(k));
    }
    std::size_t row(int j, int k) const {
        return std::size_t(j) + std::size_t(m_blocks.y) * std::size_t(k);
    }
    template <class Visit>
    void for_each(const Visit& visit) const;
    std::vector<Box3i> boxes_of_layer(int k) const;
    void set(Vec3i block, bool dirty);
    void wipe(const Box3i& blocks);

    Vec3i m_size{0, 0, 0};    ///< voxels
    Vec3i m_blocks{0, 0, 0};  ///< blocks along each axis
    std::vector<bool> m_dirty;
    std::size_t m_count = 0;  ///< dirty blocks
    /// Dirty blocks in each row and each layer: clean ones are skipped.
    std::vector<int> m_row_count, m_layer_count;
};

}  // namespace pliant::serve
