// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mesh/box_tree.h"

#include <numeric>

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
    const auto items = std::span(m_items).subspan(std::size_t(begin), std::size_t(end - begin));
    Bounds box;
    for (const std::int32_t item : items) box.add(boxes[std::size_t(item)]);
    m_nodes[index].box = box;
    if (end - begin <= kLeaf) {
        m_nodes[index].second = begin;
        m_nodes[index].count = end - begin;
        return;
    }
    const auto half = halve(items, [&](std::int32_t item) {
        return boxes[std::size_t(item)].low + boxes[std::size_t(item)].high;
    });
    const std::int32_t middle = begin + std::int32_t(half);
    build(boxes, begin, middle);
    m_nodes[index].second = std::int32_t(m_nodes.size());
    build(boxes, middle, end);
}

}  // namespace pliant::mesh
