// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bone is a piece of bone: face-connected elements above the threshold that together are large
// enough, or that the scan's border cuts. Smaller pieces are noise, or calcium in soft tissue,
// which moves with it.

#pragma once

#include <pliant/volume.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace pliant {

/// A set of the scan's voxels, as bits.
class VoxelBits {
  public:
    VoxelBits() = default;
    explicit VoxelBits(std::size_t voxels) : m_words((voxels + 63) / 64, 0) {}
    bool operator[](std::size_t n) const { return m_words[n / 64] >> n % 64 & 1; }
    void set(std::size_t n) { m_words[n / 64] |= std::uint64_t(1) << n % 64; }
    void clear(std::size_t n) { m_words[n / 64] &= ~(std::uint64_t(1) << n % 64); }
    const std::vector<std::uint64_t>& words() const { return m_words; }

  private:
    std::vector<std::uint64_t> m_words;
};

/// Class of an element before pieces are looked at.
enum class BoneElement : std::uint8_t { None, ByValue, ByLabel };

/// The elements of pieces that are too small to be bone.
class SmallBones {
  public:
    SmallBones() = default;
    /// @param smallest_mm3  pieces of less are small, if the scan's border doesn't cut them and
    /// they have no element ByLabel
    /// @param look  writes the elements of the row of voxels (0, y, z) along x, and returns whether
    /// any is bone
    SmallBones(const Grid& grid, double smallest_mm3,
               const std::function<bool(int y, int z, BoneElement* row)>& look);

    bool empty() const { return m_blocks.empty(); }
    /// Whether the box of voxels may have such elements. @pre within the scan
    bool may_be_in(const Box3i& box) const;
    /// @pre !empty(), within the scan
    bool has(std::size_t voxel) const { return m_bits[voxel]; }

  private:
    std::size_t block(Vec3i block) const {
        return std::size_t(block.x) +
               std::size_t(m_size.x) *
                   (std::size_t(block.y) + std::size_t(m_size.y) * std::size_t(block.z));
    }

    VoxelBits m_bits;
    Vec3i m_size{0, 0, 0};               ///< in blocks of 8³ voxels
    std::vector<std::uint8_t> m_blocks;  ///< whether one has any; empty: none has
};

}  // namespace pliant
