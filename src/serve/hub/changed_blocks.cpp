// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/changed_blocks.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <variant>

#include "protocol/dirty_blocks.h"
#include "volume/boxes.h"

namespace pliant::serve {
namespace {

constexpr int kBlockEdge = DirtyBlocks::kEdge;
constexpr std::int64_t kBlocksAtOnce = 256;

std::uint64_t stirred(std::uint64_t hash, std::uint64_t word) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ULL;
    return hash ^ hash >> 32;
}

/// Hash of a box's voxels; never 0.
template <class T>
std::uint64_t hash_of_voxels(const VoxelArray<T>& voxels, Vec3i size, const Box3i& box) {
    std::uint64_t hash = 1;
    const auto bytes = std::size_t(box.end.x - box.begin.x) * sizeof(T);
    for_each_row(box, [&](Vec3i p) {
        const auto* row = reinterpret_cast<const char*>(voxels.data() + dense_index(p, size));
        for (std::size_t n = 0; n < bytes; n += 8) {
            std::uint64_t word = 0;
            std::memcpy(&word, row + n, std::min<std::size_t>(8, bytes - n));
            hash = stirred(hash, word);
        }
    });
    return hash ? hash : 1;
}

}  // namespace

std::span<const Box3i> ChangedBlocks::find(const Volume& volume, std::span<const Box3i> boxes,
                                           const TaskArena& arena) {
    const Vec3i size = volume.grid.size;
    Vec3i count;
    for (int a = 0; a < 3; ++a) count[a] = (size[a] + kBlockEdge - 1) / kBlockEdge;
    const auto voxels_of = [&](Vec3i block) {
        Box3i box{kBlockEdge * block, {}};
        for (int a = 0; a < 3; ++a) box.end[a] = std::min(box.begin[a] + kBlockEdge, size[a]);
        return box;
    };
    m_hashes.resize(dense_count(count));
    // Boxes may share blocks: each is compared once.
    DirtyBlocks touched(size);
    for (const Box3i& box : boxes) touched.mark(box);
    m_blocks = touched.blocks();
    m_is_new.assign(m_blocks.size(), 0);
    const auto compare = [&](std::int64_t begin, std::int64_t end) {
        for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
            const Box3i box = voxels_of(m_blocks[n]);
            const std::uint64_t now =
                std::visit([&](const auto& voxels) { return hash_of_voxels(voxels, size, box); },
                           volume.voxels);
            std::uint64_t& last = m_hashes[dense_index(m_blocks[n], count)];
            m_is_new[n] = now != last;
            last = now;
        }
    };
    // By reference: a copy of the captures would allocate.
    arena.for_each(std::int64_t(m_blocks.size()), kBlocksAtOnce, std::ref(compare));
    m_changed.clear();
    for (std::size_t n = 0; n < m_blocks.size(); ++n) {
        if (!m_is_new[n]) continue;
        const Box3i box = voxels_of(m_blocks[n]);
        const bool joins =
            n > 0 && m_is_new[n - 1] && m_blocks[n - 1] + Vec3i{1, 0, 0} == m_blocks[n];
        if (joins)
            m_changed.back().end.x = box.end.x;
        else
            m_changed.push_back(box);
    }
    return m_changed;
}

}  // namespace pliant::serve
