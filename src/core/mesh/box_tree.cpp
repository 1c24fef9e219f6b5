// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mesh/box_tree.h"

#include <numeric>
#include <utility>

namespace pliant::mesh {

BoxTree::BoxTree(std::span<const Bounds> boxes) {
    m_items.resize(boxes.size());
    std::iota(m_items.begin(), m_items.end(), 0);
    m_nodes.reserve(boxes.size());
    if (!boxes.empty()) build(boxes, 0, std::int32_t(boxes.size()));
}

void BoxTree::build(std::span<const Bounds> boxes, std::int32_t begin, std::int32_t end) {
    const auto index = m_nodes.size();
    m_nodes.emplace_back();
    Bounds box, centres;
    const auto centre = [&](std::int32_t item) {
        return boxes[std::size_t(item)].low + boxes[std::size_t(item)].high;
    };
    for (std::int32_t n = begin; n < end; ++n) {
        const std::int32_t item = m_items[std::size_t(n)];
        box.add(boxes[std::size_t(item)]);
        centres.add(centre(item));
    }
    m_nodes[index].box = box;
    if (end - begin <= kLeaf) {
        m_nodes[index].second = begin;
        m_nodes[index].count = end - begin;
        return;
    }
    const Vec3d extent = centres.high - centres.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                     : extent.y >= extent.z                       ? 1
                                                                  : 2;
    const std::int32_t middle = begin + (end - begin) / 2;
    std::nth_element(m_items.begin() + begin, m_items.begin() + middle, m_items.begin() + end,
                     [&](std::int32_t a, std::int32_t b) {
                         return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
                     });
    build(boxes, begin, middle);
    m_nodes[index].second = std::int32_t(m_nodes.size());
    build(boxes, middle, end);
}

}  // namespace pliant::mesh
