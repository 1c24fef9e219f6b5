// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "path/lumen_tiles.h"

#include <algorithm>
#include <cmath>

#include "render/voxel_field.h"
#include "volume/boxes.h"

namespace pliant::render {
namespace {

constexpr int kFirstMargin = 8;  // voxels of the smallest spacing

int tiles_along(int voxels) {
    return (voxels + LumenTiles::kSide - 1) / LumenTiles::kSide;
}

double smallest(Vec3d v) {
    return std::min({v.x, v.y, v.z});
}

}  // namespace

LumenTiles::LumenTiles(const Volume& volume, const LumenSide& lumen, int far_voxels,
                       std::int64_t max_voxels, const TaskArena& arena)
    : m_volume(volume),
      m_lumen(lumen),
      m_arena(arena),
      m_far_voxels(far_voxels),
      m_unit_mm(smallest(volume.grid.spacing_mm)),
      m_voxels_left(max_voxels),
      m_size{tiles_along(volume.grid.size.x), tiles_along(volume.grid.size.y),
             tiles_along(volume.grid.size.z)},
      m_tiles(dense_count(m_size)) {}

void LumenTiles::close() {
    m_new = kClosed;
    for (const auto& tile : m_tiles) {
        if (!tile) continue;
        std::fill(tile->arrival.begin(), tile->arrival.end(),
                  std::numeric_limits<double>::infinity());
        std::fill(tile->set.begin(), tile->set.end(), kClosed);
    }
}

LumenTile* LumenTiles::make(Vec3i voxel) {
    constexpr std::size_t kCount = std::size_t(kSide) * kSide * kSide;
    if (m_voxels_left < std::int64_t(kCount)) {
        m_is_full = true;
        return nullptr;
    }
    m_voxels_left -= std::int64_t(kCount);
    auto tile = std::make_unique<LumenTile>();
    tile->wall_mm.assign(kCount, 0);
    tile->arrival.assign(kCount, std::numeric_limits<double>::infinity());
    tile->set.assign(kCount, m_new);
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        box.begin[a] = voxel[a] / kSide * kSide;
        box.end[a] = std::min(box.begin[a] + kSide, m_volume.grid.size[a]);
    }
    int margin = std::min(kFirstMargin, m_far_voxels);
    while (!fill(box, *tile, margin * m_unit_mm, margin == m_far_voxels))
        margin = std::min(2 * margin, m_far_voxels);
    auto& kept = m_tiles[tile_index(voxel)];
    kept = std::move(tile);
    return kept.get();
}

/// @returns whether the margin was sufficient
bool LumenTiles::fill(const Box3i& box, LumenTile& tile, double margin_mm, bool last) const {
    bool any = false;
    with_field(m_volume, [&](const auto& field) {
        for_each_in(box, [&](Vec3i p) { any |= m_lumen.contains(double(*field.at(p))); });
    });
    if (!any) return true;
    Box3i around = box;
    for (int a = 0; a < 3; ++a) {
        const double voxels = std::ceil(margin_mm / m_volume.grid.spacing_mm[a]);
        around.begin[a] = int(std::max(0.0, box.begin[a] - voxels));
        around.end[a] = int(std::min(double(m_volume.grid.size[a]), box.end[a] + voxels));
    }
    std::vector<float> wall_mm;
    wall_distance(m_volume, around, m_lumen, m_arena, wall_mm);
    const Vec3i n = around.end - around.begin;
    bool enough = true;
    with_field(m_volume, [&](const auto& field) {
        for_each_in(box, [&](Vec3i p) {
            if (!m_lumen.contains(double(*field.at(p)))) return;
            const Vec3i q = p - around.begin;
            const float d = wall_mm[std::size_t(q.x) +
                                    std::size_t(n.x) *
                                        (std::size_t(q.y) + std::size_t(n.y) * std::size_t(q.z))];
            enough = enough && double(d) <= margin_mm;
            tile.wall_mm[index_in_tile(p)] = std::min(d, float(margin_mm));
        });
    });
    return enough || last;
}

}  // namespace pliant::render
