// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/touched.h"

#include <algorithm>
#include <array>

namespace pliant {
namespace {

constexpr int kLargestBrick = 32;

/// Rows of a brick and of one layer around it: element (x, y, z), each −1…size, is bit x + 1 of
/// row (y + 1, z + 1).
struct HaloRows {
    int side;
    std::array<RowBits, (kLargestBrick + 2) * (kLargestBrick + 2)> rows;
    RowBits& at(int y, int z) { return rows[std::size_t(y + side * z)]; }
};

/// Elements that moved or are void. @param low  −1, or 0 where the layer on the low sides is not
/// wanted: it is then left empty
/// @returns whether there are any
bool gather_altered(const Snapshot& snapshot, int size, Vec3i coord, int low, HaloRows& halo) {
    halo.side = size + 2;
    std::fill_n(halo.rows.begin(), halo.side * halo.side, 0);
    bool any = false;
    for (int dz = low; dz <= 1; ++dz)
        for (int dy = low; dy <= 1; ++dy)
            for (int dx = low; dx <= 1; ++dx) {
                const int found = snapshot.find(coord + Vec3i{dx, dy, dz});
                if (found < 0) continue;
                any = true;
                const RowBits* from = snapshot.altered_rows(found);
                const auto first = [&](int d) { return d < 0 ? size - 1 : 0; };
                const auto last = [&](int d) { return d > 0 ? 0 : size - 1; };
                for (int z = first(dz); z <= last(dz); ++z)
                    for (int y = first(dy); y <= last(dy); ++y) {
                        const RowBits row = from[y + size * z];
                        halo.at(y + dy * size + 1, z + dz * size + 1) |=
                            dx < 0   ? row >> (size - 1)
                            : dx > 0 ? (row & 1) << (size + 1)
                                     : row << 1;
                    }
            }
    return any;
}

/// From elements to cells: bit x + 1 of row (y + 1, z + 1) is the cell whose lowest corner is
/// (x, y, z), each −1…size − 1.
void touch_cells(HaloRows& halo) {
    const int side = halo.side;
    for (int r = 0; r < side * side; ++r) {
        RowBits& row = halo.rows[std::size_t(r)];
        row |= row >> 1;
    }
    for (int z = 0; z < side; ++z)
        for (int y = 0; y + 1 < side; ++y) halo.at(y, z) |= halo.at(y + 1, z);
    for (int z = 0; z + 1 < side; ++z)
        for (int y = 0; y + 1 < side; ++y) halo.at(y, z) |= halo.at(y, z + 1);
}

RowBits low_bits(int count) {
    return (RowBits(1) << count) - 1;
}

/// A moved element touches all eight cells around it, so where all have moved there is nothing to
/// find out.
bool fill_if_full(const Snapshot& snapshot, int size, Vec3i coord, RowBits* rows) {
    const BrickRecord* record = snapshot.record_at(coord);
    if (!record || !record->is_full) return false;
    std::fill_n(rows, size * size, low_bits(size));
    return true;
}

}  // namespace

bool changeable_rows(const Snapshot& snapshot, int size, Vec3i coord, RowBits* rows) {
    if (fill_if_full(snapshot, size, coord, rows)) return true;
    HaloRows halo;
    if (!gather_altered(snapshot, size, coord, -1, halo)) {
        std::fill_n(rows, size * size, 0);
        return false;
    }
    touch_cells(halo);
    RowBits any = 0;
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y) {
            const RowBits around =
                halo.at(y, z) & halo.at(y + 1, z) & halo.at(y, z + 1) & halo.at(y + 1, z + 1);
            any |= rows[y + size * z] = around & (around >> 1) & low_bits(size);
        }
    return any != 0;
}

bool touched_rows(const Snapshot& snapshot, int size, Vec3i coord, RowBits* rows) {
    if (fill_if_full(snapshot, size, coord, rows)) return true;
    HaloRows halo;
    if (!gather_altered(snapshot, size, coord, 0, halo)) return false;
    touch_cells(halo);
    RowBits any = 0;
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            any |= rows[y + size * z] = (halo.at(y + 1, z + 1) >> 1) & low_bits(size);
    return any != 0;
}

}  // namespace pliant
