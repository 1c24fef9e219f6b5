// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/block_nodes.h"

#include <algorithm>
#include <cmath>

#include "chainmail/cell_block.h"
#include "resample/cell_kernel.h"
#include "resample/touched.h"

namespace pliant {
namespace {

/// Widest vector, in lanes, that reads beyond the last node.
constexpr int kPadding = 16;
/// Differences of displacement within a block above which it is wild [voxels].
constexpr double kWild = 64;
/// Slack of a layer's reach for rounding [voxels].
constexpr float kLayerSlack = 1e-3f;
constexpr int kFixedPerLine = 64 / int(sizeof(Fixed));  ///< of the cache

}  // namespace

BlockRecords records_of_block(const Snapshot& snapshot, Vec3i coord) {
    BlockRecords records;
    for (int c = 0; c < 8; ++c)
        records[std::size_t(c)] = snapshot.record_at(coord + Vec3i{c & 1, c >> 1 & 1, c >> 2});
    return records;
}

BlockReach reach_of_block(const BlockRecords& records, const Grid& grid, int brick_size,
                          Vec3i coord) {
    const Vec3d scale = voxels_per_unit(grid);
    BlockReach reach;
    for (int a = 0; a < 3; ++a) {
        bool at_rest = false;
        Fixed low = INT32_MAX, high = INT32_MIN;
        for (const BrickRecord* record : records) {
            if (!record) {
                at_rest = true;
                continue;
            }
            low = std::min(low, record->u_min[a]);
            high = std::max(high, record->u_max[a]);
        }
        if (at_rest) low = std::min(low, 0), high = std::max(high, 0);
        const double first = double(coord[a]) * brick_size;
        reach.low[a] = first + scale[a] * low;
        reach.high[a] = first + brick_size + scale[a] * high;
    }
    return reach;
}

void BlockNodes::resize(int brick_size) {
    if (brick_size == m_size) return;
    m_size = brick_size;
    m_row = brick_size + 1;
    const auto nodes = std::size_t(m_row) * std::size_t(m_row) * std::size_t(m_row);
    // The last cell's highest corner, and a vector that starts there.
    const auto padded = nodes + std::size_t(m_row) * std::size_t(m_row) + std::size_t(m_row) + 1 +
                        std::size_t(kPadding);
    for (auto& component : m_u) component.assign(padded, 0);
    for (auto& component : m_place) component.assign(padded, 0);
    for (int n = 0; n < int(nodes); ++n)
        for (int a = 0; a < 3; ++a) m_place[std::size_t(a)][std::size_t(n)] = float(local(n)[a]);
    m_values.assign(padded, 0);
    m_use.assign((nodes + 63) / 64 + 1, 0);
    m_at_rest.assign(std::size_t(m_size) * std::size_t(m_size) * std::size_t(m_size), 0);
}

bool BlockNodes::load(const Snapshot& snapshot, const Lattice& lattice, const Volume& original,
                      Vec3i coord, int begin_z, int end_z) {
    resize(lattice.brick_size());
    m_first = m_origin = m_size * coord;
    m_records = records_of_block(snapshot, coord);
    m_reach = reach_of_block(m_records, lattice.grid(), m_size, coord);
    if (!find_use(snapshot, lattice, coord)) return false;
    // Indices of voxels are whole numbers of 32 bits.
    const Vec3i n = lattice.grid().size;
    m_is_wild = double(n.x) * n.y * (2 * m_size + 2 * kWild) > INT32_MAX;
    for (int a = 0; a < 3; ++a) m_is_wild |= m_reach.high[a] - m_reach.low[a] > m_size + kWild;
    if (m_is_wild) return true;
    load_displacements(lattice.grid(), 2);
    if (!keep_layers_within(begin_z, end_z)) return false;
    load_displacements(lattice.grid(), 0);
    load_displacements(lattice.grid(), 1);
    load_values(original);
    fetch_ahead(snapshot, coord);
    return true;
}

bool BlockNodes::find_use(const Snapshot& snapshot, const Lattice& lattice, Vec3i coord) {
    std::array<RowBits, 32 * 32> rows;
    if (!touched_rows(snapshot, m_size, coord, rows.data())) return false;
    std::fill(m_use.begin(), m_use.end(), 0);
    for (int z = 0; z < m_size; ++z)
        for (int y = 0; y < m_size; ++y) {
            const RowBits bits = rows[std::size_t(y + m_size * z)];
            const auto at = unsigned(index(0, y, z));
            m_use[at / 64] |= bits << (at % 64);
            if (at % 64) m_use[at / 64 + 1] |= bits >> (64 - at % 64);
        }
    const bool edited = std::any_of(m_records.begin(), m_records.end(),
                                    [](const auto* record) { return record && record->edits; });
    if (edited || lattice.is_void({-1, 0, 0})) drop_broken_cells(lattice);
    return true;
}

void BlockNodes::drop_broken_cells(const Lattice& lattice) {
    const bool bounded = lattice.is_void({-1, 0, 0});
    const Vec3i size = lattice.grid().size;
    for (int z = 0; z < m_size; ++z)
        for (int y = 0; y < m_size; ++y)
            for (int x = 0; x < m_size; ++x) {
                const Vec3i low = m_first + Vec3i{x, y, z};
                const bool beyond = low.x < 0 || low.y < 0 || low.z < 0 || low.x + 1 >= size.x ||
                                    low.y + 1 >= size.y || low.z + 1 >= size.z;
                if (!(bounded && beyond) && cell_is_whole(*this, {x, y, z})) continue;
                const auto n = unsigned(index(x, y, z));
                m_use[n / 64] &= ~(RowBits(1) << (n % 64));
            }
}

Vec3<Fixed> BlockNodes::displacement(Vec3i p) const {
    const bool hx = p.x == m_size, hy = p.y == m_size, hz = p.z == m_size;
    const BrickRecord* record = m_records[std::size_t(hx + 2 * hy + 4 * hz)];
    if (!record || !record->brick) return {0, 0, 0};
    const int n = (hx ? 0 : p.x) + m_size * ((hy ? 0 : p.y) + m_size * (hz ? 0 : p.z));
    return {record->brick->u[0][n], record->brick->u[1][n], record->brick->u[2][n]};
}

int BlockNodes::edits(Vec3i p) const {
    const bool hx = p.x == m_size, hy = p.y == m_size, hz = p.z == m_size;
    const BrickRecord* record = m_records[std::size_t(hx + 2 * hy + 4 * hz)];
    if (!record || !record->edits) return 0;
    return record->edits[(hx ? 0 : p.x) + m_size * ((hy ? 0 : p.y) + m_size * (hz ? 0 : p.z))];
}

/// Bricks lie anywhere in memory. What the next block along x will be the first to read is asked
/// for in advance: a brick, and the faces and the edge of three more. Processors may ignore the
/// wish where they don't know the page yet, so one element of each component is really read.
void BlockNodes::fetch_ahead(const Snapshot& snapshot, Vec3i coord) {
    const int layer = m_size * m_size, count = m_size * layer;
    const auto fetch = [&](Vec3i offset, int row_count, int row_step, int row_size) {
        const BrickRecord* next = snapshot.record_at(coord + offset);
        if (!next || !next->brick) return;
        for (const Fixed* u : next->brick->u) m_ignored = *u;
        for (const Fixed* u : next->brick->u)
            for (int row = 0; row < row_count; ++row)
                for (int n = 0; n < row_size; n += kFixedPerLine)
                    __builtin_prefetch(u + row * row_step + n);
    };
    fetch({2, 0, 0}, 1, 0, count);
    fetch({2, 1, 0}, m_size, layer, m_size);
    fetch({2, 0, 1}, 1, 0, layer);
    fetch({2, 1, 1}, 1, 0, m_size);
}

void BlockNodes::load_displacements(const Grid& grid, int axis) {
    const Fixed base = displacement({m_size / 2, m_size / 2, m_size / 2})[axis];
    const double scale = voxels_per_unit(grid)[axis], voxels = scale * base;
    const int whole = int(std::lround(voxels));
    m_origin[axis] = m_first[axis] + whole;
    std::array<const Fixed*, 8> from;
    for (std::size_t c = 0; c < 8; ++c)
        from[c] = m_records[c] && m_records[c]->brick ? m_records[c]->brick->u[std::size_t(axis)]
                                                      : m_at_rest.data();
    convert_block_nodes(from, m_size, base, float(scale), float(voxels - whole),
                        m_u[std::size_t(axis)].data());
}

/// Takes away the layers of cells that are wholly beyond the given layers of voxels.
bool BlockNodes::keep_layers_within(int begin_z, int end_z) {
    if (m_reach.low.z >= begin_z && m_reach.high.z <= end_z - 1) return true;
    const int slice = m_row * m_row;
    std::array<float, 33> low, high;
    for (int z = 0; z <= m_size; ++z) {
        const auto [least, most] =
            std::minmax_element(m_u[2].data() + z * slice, m_u[2].data() + (z + 1) * slice);
        low[std::size_t(z)] = float(m_origin.z + z) + *least - kLayerSlack;
        high[std::size_t(z)] = float(m_origin.z + z) + *most + kLayerSlack;
    }
    bool any = false;
    for (int z = 0; z < m_size; ++z) {
        const auto k = std::size_t(z);
        if (std::max(high[k], high[k + 1]) >= float(begin_z) &&
            std::min(low[k], low[k + 1]) <= float(end_z - 1)) {
            any = true;
            continue;
        }
        for (int n = z * slice; n < (z + 1) * slice; ++n)
            m_use[unsigned(n) / 64] &= ~(RowBits(1) << (unsigned(n) % 64));
    }
    return any;
}

void BlockNodes::load_values(const Volume& original) {
    const Grid& grid = original.grid;
    const Box3i box = voxel_box(grid);
    const Vec3i last = m_first + Vec3i{m_size, m_size, m_size};
    const bool inside = contains(box, m_first) && contains(box, last);
    std::visit(
        [&](const auto& voxels) {
            float* to = m_values.data();
            for (int z = m_first.z; z <= last.z; ++z)
                for (int y = m_first.y; y <= last.y; ++y, to += m_row) {
                    if (inside) {
                        const auto* from = voxels.data() + voxel_index(grid, {m_first.x, y, z});
                        for (int x = 0; x < m_row; ++x) to[x] = float(from[x]);
                        continue;
                    }
                    for (int x = 0; x < m_row; ++x) {
                        const Vec3i e{m_first.x + x, y, z};
                        to[x] =
                            contains(box, e) ? float(voxels[voxel_index(grid, e)]) : float(kAirHu);
                    }
                }
        },
        original.voxels);
}

bool cell_is_whole(const BlockNodes& block, Vec3i cell) {
    std::array<int, 8> edits;
    for (int c = 0; c < 8; ++c) {
        edits[std::size_t(c)] = block.edits(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (edits[std::size_t(c)] & kVoid) return false;
    }
    constexpr int kCut[3] = {kCutX, kCutY, kCutZ};
    for (int c = 0; c < 8; ++c)
        for (int axis = 0; axis < 3; ++axis) {
            if (c >> axis & 1 || !(edits[std::size_t(c)] & kCut[axis])) continue;
            const int d = c | 1 << axis;
            if (block.displacement(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}) !=
                block.displacement(cell + Vec3i{d & 1, d >> 1 & 1, d >> 2}))
                return false;
        }
    return true;
}

}  // namespace pliant
