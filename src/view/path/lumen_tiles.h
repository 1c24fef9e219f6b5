// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The lumen in tiles of 32³ voxels that are created on demand: a path through the airways visits
// about 1 % of a scan, and needs memory for that part only.
//
// A tile's distances depend on the walls around it. They are searched in a margin that grows until
// it exceeds all distances, so they are exact, up to far_voxels. Larger distances are clamped.

#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "path/wall_distance.h"
#include "volume/boxes.h"

namespace pliant::render {

struct LumenTile {
    std::vector<float> wall_mm;     ///< distance to the wall; 0: in the tissue
    std::vector<double> arrival;    ///< arrival of the front; infinite: not yet
    std::vector<std::uint8_t> set;  ///< kOpen, kFinal or kClosed
};

inline constexpr std::uint8_t kOpen = 0;
inline constexpr std::uint8_t kFinal = 1;   ///< the front has passed
inline constexpr std::uint8_t kClosed = 2;  ///< the front may not come here

class LumenTiles {
  public:
    static constexpr int kSide = 32;

    /// Keeps references.
    /// @param far_voxels  in units of the smallest spacing: larger distances to the wall don't
    ///                    matter
    LumenTiles(const Volume& volume, const LumenSide& lumen, int far_voxels,
               std::int64_t max_voxels, const TaskArena& arena);

    const Volume& volume() const { return m_volume; }
    const LumenSide& lumen() const { return m_lumen; }
    bool is_inside(Vec3i voxel) const { return contains(voxel_box(m_volume.grid), voxel); }
    /// Whether a tile could not be made for lack of voxels.
    bool is_full() const { return m_is_full; }

    /// The tile of a voxel, created on demand; null if that fails.
    /// @pre the voxel is inside the volume
    LumenTile* tile_of(Vec3i voxel) {
        LumenTile* tile = m_tiles[tile_index(voxel)].get();
        return tile ? tile : make(voxel);
    }
    static std::size_t index_in_tile(Vec3i voxel) {
        constexpr int kMask = kSide - 1;
        return std::size_t(voxel.x & kMask) +
               kSide * (std::size_t(voxel.y & kMask) + kSide * std::size_t(voxel.z & kMask));
    }

    /// Arrival at a voxel; infinite in missing tiles and outside of the volume.
    double arrival(Vec3i voxel) const {
        if (!is_inside(voxel)) return std::numeric_limits<double>::infinity();
        const LumenTile* tile = m_tiles[tile_index(voxel)].get();
        return tile ? tile->arrival[index_in_tile(voxel)] : std::numeric_limits<double>::infinity();
    }
    /// Distance to the wall; 0 in the tissue, and in tiles that can't be made. @pre inside the
    /// volume
    double wall_mm(Vec3i voxel) {
        const LumenTile* tile = tile_of(voxel);
        return tile ? double(tile->wall_mm[index_in_tile(voxel)]) : 0;
    }

    double far_mm() const { return m_far_voxels * m_unit_mm; }
    /// Resets all arrivals and closes all voxels; open() opens single ones.
    void close();
    void open(Vec3i voxel) {
        if (LumenTile* tile = tile_of(voxel)) tile->set[index_in_tile(voxel)] = kOpen;
    }

  private:
    std::size_t tile_index(Vec3i voxel) const {
        return dense_index({voxel.x / kSide, voxel.y / kSide, voxel.z / kSide}, m_size);
    }
    LumenTile* make(Vec3i voxel);
    bool fill(const Box3i& box, LumenTile& tile, double margin_mm, bool last) const;

    const Volume& m_volume;
    LumenSide m_lumen;
    const TaskArena& m_arena;
    int m_far_voxels;
    double m_unit_mm;            // the smallest spacing
    std::uint8_t m_new = kOpen;  // state of voxels in new tiles
    std::int64_t m_voxels_left;
    bool m_is_full = false;
    Vec3i m_size;  // in tiles
    std::vector<std::unique_ptr<LumenTile>> m_tiles;
};

}  // namespace pliant::render
