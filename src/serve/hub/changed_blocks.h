// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Blocks of the deformed volume whose voxels changed. An update of the volume reports every brick
// that moving cells touch. Many of them keep their values: air around the body, voxels that moved
// by too little for another integer, and the margin of a brick. They needn't be sent.
//
// A 64-bit hash of each block is compared with that of the last update: 8 bytes per block instead
// of a copy of the volume. Two values of a block have the same hash by chance once in 10^19 times.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <span>
#include <vector>

namespace pliant::serve {

class ChangedBlocks {
  public:
    /// Forgets all values: the next update of a block counts as a change.
    void forget() { m_hashes.clear(); }
    /// Compares the blocks in an update's boxes with their last values.
    /// @param boxes  all voxels that may have changed since the last call
    /// @returns boxes of the blocks with other values, neighbours along i joined; valid until the
    ///          next call
    std::span<const Box3i> find(const Volume& volume, std::span<const Box3i> boxes,
                                const TaskArena& arena);

  private:
    std::vector<std::uint64_t> m_hashes;  ///< [block]; 0: unknown
    std::vector<Vec3i> m_blocks;          ///< those in the boxes
    std::vector<std::uint8_t> m_is_new;   ///< [of m_blocks]
    std::vector<Box3i> m_changed;
};

}  // namespace pliant::serve
