// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A bounding volume hierarchy: items with boxes, split recursively at the median of their centres
// along the longest axis. Nodes lie in one array, the first child right after its parent:
//
//     0 root ── 1 first half ── 2 … ── n second half …
//
// The tree depends only on the boxes, not on threads.

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant::mesh {

struct Bounds {
    static constexpr double kFar = std::numeric_limits<double>::infinity();
    Vec3d low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};

    void add(Vec3d p) {
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    }
    void add(const Bounds& b) {
        add(b.low);
        add(b.high);
    }
    double distance_squared(Vec3d p) const {
        double sum = 0;
        for (int a = 0; a < 3; ++a) {
            const double outside = std::max({low[a] - p[a], 0.0, p[a] - high[a]});
            sum += outside * outside;
        }
        return sum;
    }
};

/// Orders items so that the centres of the first half lie lower along the longest axis of their
/// box; equal ones by number. @returns the size of the first half
template <class CentreOf>
std::size_t halve(std::span<std::int32_t> items, const CentreOf& centre_of) {
    Bounds box;
    for (const std::int32_t item : items) box.add(centre_of(item));
    const Vec3d size = box.high - box.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t half = items.size() / 2;
    std::nth_element(items.begin(), items.begin() + std::ptrdiff_t(half), items.end(),
                     [&](std::int32_t a, std::int32_t b) {
                         const double u = centre_of(a)[axis], v = centre_of(b)[axis];
                         return u != v ? u < v : a < b;
                     });
    return half;
}

class BoxTree {
  public:
    BoxTree() = default;
    /// @pre all boxes are finite
    explicit BoxTree(std::span<const Bounds> boxes);

    /// Calls visit(item, best) for items whose box may be nearer than best [squared], nearest boxes
    /// first; visit lowers best on a hit. Boxes at equal distance are visited too, so that the
    /// caller can break ties by item numbers.
    template <class Visit>
    void nearest(Vec3d p, double best, const Visit& visit) const {
        if (m_nodes.empty()) return;
        std::int32_t stack[kDepth];
        int height = 0;
        stack[height++] = 0;
        while (height > 0) {
            const Node& node = m_nodes[std::size_t(stack[--height])];
            if (node.box.distance_squared(p) > best) continue;
            if (node.count > 0) {
                for (std::int32_t n = 0; n < node.count; ++n)
                    visit(m_items[std::size_t(node.second + n)], best);
                continue;
            }
            const auto first = std::int32_t(&node - m_nodes.data()) + 1, second = node.second;
            const bool swap = m_nodes[std::size_t(second)].box.distance_squared(p) <
                              m_nodes[std::size_t(first)].box.distance_squared(p);
            stack[height++] = swap ? first : second;
            stack[height++] = swap ? second : first;
        }
    }

  private:
    static constexpr int kLeaf = 4;
    static constexpr int kDepth = 64;  // halving: sufficient for far more than 2³¹ items
    struct Node {
        Bounds box;
        std::int32_t second = 0;  ///< second child, or first item of a leaf
        std::int32_t count = 0;   ///< number of a leaf's items
    };
    void build(std::span<const Bounds> boxes, std::int32_t begin, std::int32_t end);

    std::vector<Node> m_nodes;
    std::vector<std::int32_t> m_items;
};

}  // namespace pliant::mesh
#pragma GCC visibility pop
