// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Algebra of half-open boxes, and indices into dense arrays, i fastest.

#pragma once

#include <pliant/volume.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pliant {

inline std::size_t dense_index(Vec3i p, Vec3i n) {
    return std::size_t(p.x) +
           std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
}
inline std::size_t dense_count(Vec3i n) {
    return std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
}
/// Number of voxels in a box. @pre it isn't empty
inline std::int64_t box_count(const Box3i& box) {
    return std::int64_t(dense_count(box.end - box.begin));
}

/// Common part of two boxes; empty if they have none.
inline Box3i overlap(const Box3i& a, const Box3i& b) {
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::max(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::min(a.end[axis], b.end[axis]);
    }
    return both;
}

/// Smallest box around two boxes, each of which may be empty.
inline Box3i hull(const Box3i& a, const Box3i& b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::min(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::max(a.end[axis], b.end[axis]);
    }
    return both;
}

template <class Visit>
void for_each_in(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) visit(Vec3i{x, y, z});
}

/// Visits the first voxel of each of a box's rows.
template <class Visit>
void for_each_row(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y) visit(Vec3i{box.begin.x, y, z});
}

}  // namespace pliant
