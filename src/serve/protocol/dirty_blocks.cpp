// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/dirty_blocks.h"

#include <algorithm>

#include "volume/boxes.h"

namespace pliant::serve {
namespace {

/// Factor by which a joined box may exceed the blocks of the boxes that it replaces: fewer messages
/// for a few more bytes.
constexpr double kSlack = 1.3;

/// Joins a box with one of the last boxes if the excess is small.
/// @param axis  along which the two boxes must touch
void join(std::vector<Box3i>& boxes, std::vector<std::int64_t>& filled, const Box3i& box,
          std::int64_t blocks, int axis, std::int64_t max_blocks) {
    // The newest boxes suffice, because boxes come in order.
    constexpr std::size_t kLookBack = 8;
    const std::size_t first = boxes.size() - std::min(boxes.size(), kLookBack);
    for (std::size_t n = boxes.size(); n-- > first;) {
        if (boxes[n].end[axis] < box.begin[axis]) continue;
        const Box3i both = hull(boxes[n], box);
        const std::int64_t size = box_count(both);
        if (size > max_blocks || double(size) > kSlack * double(filled[n] + blocks)) continue;
        boxes[n] = both;
        filled[n] += blocks;
        return;
    }
    boxes.push_back(box);
    filled.push_back(blocks);
}

constexpr std::int64_t kMaxBlocks =
    DirtyBlocks::kMaxBoxVoxels / (DirtyBlocks::kEdge * DirtyBlocks::kEdge * DirtyBlocks::kEdge);

}  // namespace

DirtyBlocks::DirtyBlocks(Vec3i size) : m_size(size) {
    for (int a = 0; a < 3; ++a) m_blocks[a] = (size[a] + kEdge - 1) / kEdge;
    m_dirty.resize(index(0, 0, m_blocks.z));
    m_row_count.resize(row(0, m_blocks.z));
    m_layer_count.resize(std::size_t(m_blocks.z));
}

void DirtyBlocks::set(Vec3i block, bool dirty) {
    auto bit = m_dirty[index(block.x, block.y, block.z)];
    if (bit == dirty) return;
    bit = dirty;
    const int one = dirty ? 1 : -1;
    m_count += std::size_t(one);
    m_row_count[row(block.y, block.z)] += one;
    m_layer_count[std::size_t(block.z)] += one;
}

void DirtyBlocks::mark(const Box3i& box) {
    Box3i blocks;
    for (int a = 0; a < 3; ++a) {
        blocks.begin[a] = std::max(box.begin[a], 0) / kEdge;
        blocks.end[a] = (std::min(box.end[a], m_size[a]) + kEdge - 1) / kEdge;
    }
    for_each_in(blocks, [&](Vec3i block) { set(block, true); });
}

void DirtyBlocks::mark_all() {
    mark(Box3i{{0, 0, 0}, m_size});
}

/// Visits the dirty blocks, i fastest.
template <class Visit>
void DirtyBlocks::for_each(const Visit& visit) const {
    for (int k = 0; k < m_blocks.z; ++k) {
        if (m_layer_count[std::size_t(k)] == 0) continue;
        for (int j = 0; j < m_blocks.y; ++j)
            for (int i = 0, left = m_row_count[row(j, k)]; left > 0; ++i) {
                if (!m_dirty[index(i, j, k)]) continue;
                visit(Vec3i{i, j, k});
                --left;
            }
    }
}

void DirtyBlocks::mark(const DirtyBlocks& other) {
    other.for_each([&](Vec3i block) { set(block, true); });
}

void DirtyBlocks::clear() {
    if (m_count == 0) return;
    std::fill(m_dirty.begin(), m_dirty.end(), false);
    std::fill(m_row_count.begin(), m_row_count.end(), 0);
    std::fill(m_layer_count.begin(), m_layer_count.end(), 0);
    m_count = 0;
}

bool DirtyBlocks::contains(Vec3i voxel) const {
    return m_dirty[index(voxel.x / kEdge, voxel.y / kEdge, voxel.z / kEdge)];
}

std::vector<Vec3i> DirtyBlocks::blocks() const {
    std::vector<Vec3i> list;
    list.reserve(m_count);
    for_each([&](Vec3i block) { list.push_back(block); });
    return list;
}

std::vector<Box3i> DirtyBlocks::boxes_of_layer(int k) const {
    std::vector<Box3i> boxes;
    std::vector<std::int64_t> filled;
    for (int j = 0; j < m_blocks.y; ++j) {
        if (m_row_count[row(j, k)] == 0) continue;
        for (int i = 0; i < m_blocks.x; ++i) {
            if (!m_dirty[index(i, j, k)]) continue;
            const int begin = i;
            while (i < m_blocks.x && m_dirty[index(i, j, k)] && i - begin < kMaxBlocks) ++i;
            join(boxes, filled, {{begin, j, k}, {i, j + 1, k + 1}}, i - begin, 1, kMaxBlocks);
            --i;
        }
    }
    return boxes;
}

void DirtyBlocks::wipe(const Box3i& blocks) {
    for_each_in(blocks, [&](Vec3i block) { set(block, false); });
}

std::vector<Box3i> DirtyBlocks::take(std::int64_t max_voxels) {
    constexpr std::int64_t kBlock = kEdge * kEdge * kEdge;
    std::vector<Box3i> boxes;
    std::vector<std::int64_t> filled;
    std::int64_t taken = 0;
    for (int k = 0; k < m_blocks.z && taken * kBlock < max_voxels; ++k) {
        if (m_layer_count[std::size_t(k)] == 0) continue;
        for (const Box3i& box : boxes_of_layer(k)) {
            if (taken * kBlock >= max_voxels) break;
            taken += box_count(box);
            join(boxes, filled, box, box_count(box), 2, kMaxBlocks);
        }
    }
    for (Box3i& box : boxes) {
        wipe(box);
        for (int a = 0; a < 3; ++a) {
            box.begin[a] *= kEdge;
            box.end[a] = std::min(box.end[a] * kEdge, m_size[a]);
        }
    }
    return boxes;
}

}  // namespace pliant::serve
