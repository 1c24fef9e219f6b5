// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The body-centred cubic lattice: two interlaced cubic grids, corners (grid 0) and centres (grid
// 1). Each node has 14 edges, identified by slots: 0…5 long, ±x ±y ±z; 6…13 short, to the other
// grid, one bit per axis. One end owns each edge: the lower end of a long one, the corner of a
// short one. Nodes are numbered cell by cell, corner before centre.

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>

namespace pliant::mesh {

inline constexpr int kBccSlots = 14;

struct BccNode {
    int grid;
    Vec3i cell;
};

struct BccLattice {
    Vec3d origin_mm{0, 0, 0};
    double cell_mm = 1;
    Vec3i size{0, 0, 0};  ///< nodes of each grid

    std::int64_t node_count() const { return 2 * std::int64_t(size.x) * size.y * size.z; }
    std::int32_t index(BccNode n) const {
        return std::int32_t(
            n.grid +
            2 * (n.cell.x + std::int64_t(size.x) * (n.cell.y + std::int64_t(size.y) * n.cell.z)));
    }
    BccNode node(std::int32_t index) const {
        const std::int32_t c = index / 2, row = c / size.x;
        return {index % 2, {c % size.x, row % size.y, row / size.y}};
    }
    bool inside(BccNode n) const {
        return n.cell.x >= 0 && n.cell.y >= 0 && n.cell.z >= 0 && n.cell.x < size.x &&
               n.cell.y < size.y && n.cell.z < size.z;
    }
    Vec3d position(BccNode n) const {
        const double half = 0.5 * n.grid;
        return origin_mm + cell_mm * Vec3d{n.cell.x + half, n.cell.y + half, n.cell.z + half};
    }
    static bool is_long(int slot) { return slot < 6; }
    static bool owns(int grid, int slot) { return is_long(slot) ? slot % 2 == 0 : grid == 0; }
    /// Slot of the same edge at its other end.
    static int opposite(int slot) { return is_long(slot) ? slot ^ 1 : slot; }
    static BccNode neighbour(BccNode n, int slot) {
        if (is_long(slot)) {
            n.cell[slot / 2] += slot % 2 == 0 ? 1 : -1;
            return n;
        }
        const int bits = slot - 6, step = n.grid == 0 ? -1 : 1;
        for (int a = 0; a < 3; ++a)
            if (bits >> a & 1) n.cell[a] += step;
        n.grid = 1 - n.grid;
        return n;
    }
    /// Slot of the edge between two neighbours, at the first.
    static int slot_between(BccNode a, BccNode b) {
        const Vec3i d = b.cell - a.cell;
        if (a.grid == b.grid) {
            for (int axis = 0; axis < 3; ++axis)
                if (d[axis] != 0) return 2 * axis + (d[axis] < 0);
        }
        return 6 + (d.x != 0) + 2 * (d.y != 0) + 4 * (d.z != 0);
    }
    /// Parity, which alternates along long edges.
    static bool is_even(BccNode n) { return (n.cell.x + n.cell.y + n.cell.z) % 2 == 0; }
};

}  // namespace pliant::mesh
