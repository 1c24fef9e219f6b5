// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/strip_nodes.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "field/cell_block.h"
#include "resample/cell_kernel.h"
#include "resample/node_kernel.h"
#include "resample/scatter_job.h"

namespace pliant {
namespace {

/// Widest vector, in lanes, that may be read beyond the last node.
constexpr int kPadding = 16;
/// Limit of differences of displacement within a strip; above it, it is wild [voxels].
constexpr double kWild = 64;

constexpr std::int64_t kBricksPerTask = 64;
constexpr AnyBrickBits kNone{};

/// @returns whether all are touched
template <class Size>
bool find_cells(const Snapshot& snapshot, const BitLayout<Size>& layout,
                const BlockRecords& records, BitWord* cells) {
    // A moved element touches all eight cells around it.
    if (records[0] && records[0]->is_full) {
        std::fill_n(cells, layout.words(), layout.all());
        return true;
    }
    std::array<const BitWord*, 8> altered;
    for (std::size_t c = 0; c < 8; ++c)
        altered[c] = records[c] ? snapshot.altered(*records[c]) : kNone.data();
    combine_around<true>(layout, altered, std::bit_or<BitWord>(), cells);
    return std::all_of(cells, cells + layout.words(),
                       [&](BitWord word) { return word == layout.all(); });
}

}  // namespace

StripFrame frame_of_strip(const Snapshot& snapshot, const Grid& grid, int brick_size, Vec3i coord,
                          const CellReach& reach) {
    const StripLayout layout(brick_size);
    const BrickRecord* middle = snapshot.record_at(coord + Vec3i{layout.middle_brick, 0, 0});
    StripFrame frame{middle ? middle->u_middle : Vec3<Fixed>{0, 0, 0}, false};
    const Vec3i size{layout.bricks * brick_size, brick_size, brick_size};
    for (int a = 0; a < 3; ++a) frame.is_wild |= reach.high[a] - reach.low[a] > size[a] + kWild;
    // Indices of voxels must fit into 32 bits.
    frame.is_wild |= double(grid.size.x) * grid.size.y * (2 * brick_size + 2 * kWild) > INT32_MAX;
    return frame;
}

void StripNodes::resize(int brick_size) {
    if (brick_size == m_size) return;
    m_size = brick_size;
    m_bricks = StripLayout(brick_size).bricks;
    m_row = m_bricks * brick_size + 1;
    const auto side = std::size_t(m_size);
    // The last cell's highest corner, and a vector that starts there.
    const std::size_t padded = std::size_t(slice()) * (side + 1) + kPadding;
    for (auto& component : m_u) component.assign(padded, 0);
    m_values.assign(padded, 0);
    m_use.assign(side * side, 0);
    m_records.assign(4 * std::size_t(m_bricks + 1), nullptr);
    m_from.assign(m_records.size(), nullptr);
    m_at_rest.assign(side * side * side, 0);
    m_in_brick.clear();
    for (int x = 0; x < m_row; ++x) m_in_brick.push_back({x / m_size, x % m_size});
}

bool StripNodes::load(const Snapshot& snapshot, const TouchedCells& touched, const Field& field,
                      const Volume& original, Vec3i coord, const CellReach& reach,
                      std::span<const Box3i> within) {
    resize(field.brick_size());
    m_first = m_origin = m_size * coord;
    for (int z = 0; z <= 1; ++z)
        for (int y = 0; y <= 1; ++y)
            for (int x = 0; x <= m_bricks; ++x)
                m_records[std::size_t(x + (m_bricks + 1) * (y + 2 * z))] =
                    snapshot.record_at(coord + Vec3i{x, y, z});
    m_reach = reach;
    if (!find_use(touched, field, coord)) return false;
    m_frame = frame_of_strip(snapshot, field.grid(), m_size, coord, reach);
    if (m_frame.is_wild) return true;
    list_rows();
    for (int axis = 0; axis < 3; ++axis) load_displacements(field.grid(), axis);
    bool is_within = within.size() == 1;
    for (int a = 0; a < 3; ++a)
        is_within &=
            m_reach.low[a] >= within[0].begin[a] && m_reach.high[a] <= within[0].end[a] - 1;
    if (!is_within) {
        if (!keep_cells_near(*this, within, m_use)) return false;
        list_rows();
    }
    load_values(original);
    return true;
}

bool StripNodes::find_use(const TouchedCells& touched, const Field& field, Vec3i coord) {
    std::fill(m_use.begin(), m_use.end(), 0);
    bool any = false;
    for (int x = 0; x < m_bricks; ++x) {
        const BitWord* cells = touched.cells(coord + Vec3i{x, 0, 0});
        if (!cells) continue;
        any = true;
        with_bit_layout(m_size, [&](auto layout) {
            RowBits* use = m_use.data();
            for (int z = 0; z < layout.size; ++z)
                for (int y = 0; y < layout.size; ++y)
                    *use++ |= layout.row(cells, y, z) << (x * m_size);
        });
    }
    if (!any) return false;
    const bool edited = std::any_of(m_records.begin(), m_records.end(),
                                    [](const auto* record) { return record && record->edits; });
    if (edited || field.is_void({-1, 0, 0})) drop_broken_cells(field);
    return true;
}

void StripNodes::list_rows() {
    m_rows.clear();
    // A cell needs the rows on both of its sides.
    RowBits below = 0;
    for (int z = 0; z <= m_size; ++z) {
        RowBits cells = 0;
        for (int y = 0; z < m_size && y < m_size; ++y)
            cells |= RowBits(m_use[std::size_t(y + m_size * z)] != 0) << y;
        const RowBits both = cells | below;
        for (RowBits left = both | both << 1; left; left &= left - 1)
            m_rows.push_back({std::countr_zero(left), z});
        below = cells;
    }
}

void StripNodes::drop_broken_cells(const Field& field) {
    const bool bounded = field.is_void({-1, 0, 0});
    const Vec3i size = field.grid().size;
    for (int z = 0; z < m_size; ++z)
        for (int y = 0; y < m_size; ++y)
            for (int x = 0; x < cells(); ++x) {
                const Vec3i low = m_first + Vec3i{x, y, z};
                const bool beyond = low.x < 0 || low.y < 0 || low.z < 0 || low.x + 1 >= size.x ||
                                    low.y + 1 >= size.y || low.z + 1 >= size.z;
                if (!(bounded && beyond) && cell_is_whole(*this, {x, y, z})) continue;
                m_use[std::size_t(y + m_size * z)] &= ~(RowBits(1) << x);
            }
}

/// @param[out] element  index in the brick
const BrickRecord* StripNodes::record_of(Vec3i p, int& element) const {
    const bool hy = p.y == m_size, hz = p.z == m_size;
    const InBrick x = m_in_brick[std::size_t(p.x)];
    element = x.element + m_size * ((hy ? 0 : p.y) + m_size * (hz ? 0 : p.z));
    return record(x.brick, hy, hz);
}

Vec3<Fixed> StripNodes::displacement(Vec3i p) const {
    int n;
    const BrickRecord* found = record_of(p, n);
    return found ? found->displacement(n) : Vec3<Fixed>{0, 0, 0};
}

int StripNodes::edits(Vec3i p) const {
    int n;
    const BrickRecord* found = record_of(p, n);
    return found && found->edits ? found->edits[n] : 0;
}

void StripNodes::note(const Snapshot& snapshot, Vec3i coord, Ahead& ahead) const {
    const auto side = std::size_t(m_size), layer = side * side;
    // Bricks, and the adjacent faces and edges of their neighbours. A face along x touches all
    // lines of its brick.
    const auto want = [&](Vec3i offset, std::size_t row_count, std::size_t row_size) {
        const BrickRecord* next = snapshot.record_at(coord + offset);
        if (!next) return;
        for (const Fixed* u : next->u)
            for (std::size_t row = 0; u && row < row_count; ++row)
                ahead.want(u + row * layer, row_size * sizeof(Fixed));
    };
    const bool is_beside = m_size * (coord - Vec3i{m_bricks, 0, 0}) == m_first;
    for (int x = is_beside ? 1 : 0; x <= m_bricks; ++x) {
        want({x, 0, 0}, 1, side * layer);
        want({x, 1, 0}, side, side);
        want({x, 0, 1}, 1, layer);
        want({x, 1, 1}, 1, side);
    }
}

void StripNodes::load_displacements(const Grid& grid, int axis) {
    const Fixed base = m_frame.base[axis];
    const double scale = voxels_per_unit(grid)[axis], voxels = scale * base;
    const int whole = int(std::lround(voxels));
    m_origin[axis] = m_first[axis] + whole;
    for (std::size_t b = 0; b < m_records.size(); ++b) {
        const Fixed* u = m_records[b] ? m_records[b]->u[std::size_t(axis)] : nullptr;
        m_from[b] = u ? u : m_at_rest.data();
    }
    convert_displacements(m_from, m_rows, m_size, base, float(scale / 8),
                          float((voxels - whole) / 8), m_u[std::size_t(axis)].data());
}

void StripNodes::load_values(const Volume& original) {
    const Grid& grid = original.grid;
    const Box3i box = voxel_box(grid);
    const Vec3i last = m_first + Vec3i{cells(), m_size, m_size};
    const bool inside = contains(box, m_first) && contains(box, last);
    std::visit(
        [&](const auto& voxels) {
            if (inside) {
                convert_values(voxels.data() + voxel_index(grid, m_first), grid.size, m_rows, m_row,
                               m_size + 1, m_values.data());
                return;
            }
            for (const NodeRow row : m_rows)
                for (int x = 0; x < m_row; ++x) {
                    const Vec3i e = m_first + Vec3i{x, row.y, row.z};
                    m_values[std::size_t(index(x, row.y, row.z))] =
                        contains(box, e) ? float(voxels[voxel_index(grid, e)])
                                         : original.background;
                }
        },
        original.voxels);
}

bool cell_is_whole(const StripNodes& strip, Vec3i cell) {
    std::array<int, 8> edits;
    for (int c = 0; c < 8; ++c) {
        edits[std::size_t(c)] = strip.edits(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (edits[std::size_t(c)] & kVoid) return false;
    }
    constexpr int kCut[3] = {kCutX, kCutY, kCutZ};
    for (int c = 0; c < 8; ++c)
        for (int axis = 0; axis < 3; ++axis) {
            if (c >> axis & 1 || !(edits[std::size_t(c)] & kCut[axis])) continue;
            const int d = c | 1 << axis;
            if (strip.displacement(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}) !=
                strip.displacement(cell + Vec3i{d & 1, d >> 1 & 1, d >> 2}))
                return false;
        }
    return true;
}

void TouchedCells::find(const Snapshot& snapshot, int brick_size, const TaskArena& arena) {
    m_size = brick_size;
    m_words_per_brick = std::size_t(BitLayout<int>{m_size}.words());
    list_bricks(snapshot);
    m_cells.resize(m_bricks.size() * m_words_per_brick);
    m_is_full.resize(m_bricks.size());
    m_bounds.resize(m_bricks.size());
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        with_bit_layout(m_size, [&](auto layout) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
                const BlockRecords records = snapshot.records_around(m_bricks[n]);
                m_bounds[n] = bounds_of(records);
                m_is_full[n] =
                    find_cells(snapshot, layout, records, m_cells.data() + n * m_words_per_brick);
            }
        });
    };
    // By reference: a copy of the captures would allocate.
    arena.for_each(std::int64_t(m_bricks.size()), kBricksPerTask, std::ref(task));
}

void TouchedCells::list_bricks(const Snapshot& snapshot) {
    m_bricks.clear();
    m_index_of.clear();
    m_box = {};
    if (snapshot.records().empty()) return;
    m_box = {snapshot.box().begin - Vec3i{1, 1, 1}, snapshot.box().end};
    const Vec3i n = m_box.end - m_box.begin;
    m_index_of.assign(std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z), -1);
    for (const BrickRecord& record : snapshot.records())
        for (int c = 0; c < 8; ++c)
            m_index_of[slot_of(record.coord - Vec3i{c & 1, c >> 1 & 1, c >> 2})] = 0;
    std::size_t slot = 0;
    for (int z = m_box.begin.z; z < m_box.end.z; ++z)
        for (int y = m_box.begin.y; y < m_box.end.y; ++y)
            for (int x = m_box.begin.x; x < m_box.end.x; ++x, ++slot) {
                if (m_index_of[slot] < 0) continue;
                m_index_of[slot] = std::int32_t(m_bricks.size());
                m_bricks.push_back({x, y, z});
            }
}

TouchedCells::Bounds TouchedCells::bounds_of(const BlockRecords& records) {
    Bounds bounds{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (const BrickRecord* record : records)
        for (int a = 0; a < 3; ++a) {
            bounds.low[a] = std::min(bounds.low[a], record ? record->u_min[a] : 0);
            bounds.high[a] = std::max(bounds.high[a], record ? record->u_max[a] : 0);
        }
    return bounds;
}

CellReach TouchedCells::reach(const Grid& grid, Vec3i first, int bricks) const {
    const auto bounds_at = [&](int x) {
        const int index = find(first + Vec3i{x, 0, 0});
        return index < 0 ? Bounds{} : m_bounds[std::size_t(index)];
    };
    Bounds all = bounds_at(0);
    for (int x = 1; x < bricks; ++x) {
        const Bounds bounds = bounds_at(x);
        for (int a = 0; a < 3; ++a) {
            all.low[a] = std::min(all.low[a], bounds.low[a]);
            all.high[a] = std::max(all.high[a], bounds.high[a]);
        }
    }
    const Vec3d scale = voxels_per_unit(grid);
    const Vec3i begin = m_size * first, end = begin + m_size * Vec3i{bricks, 1, 1};
    CellReach reach;
    for (int a = 0; a < 3; ++a) {
        reach.low[a] = begin[a] + scale[a] * all.low[a];
        reach.high[a] = end[a] + scale[a] * all.high[a];
    }
    return reach;
}

Share TouchedCells::changeable(Vec3i brick, BitWord* voxels) const {
    std::array<const BitWord*, 8> cells;
    bool full = true;
    int own = -1;
    for (int c = 0; c < 8; ++c) {
        const int index = find(brick - Vec3i{c & 1, c >> 1 & 1, c >> 2});
        if (c == 0) own = index;
        cells[std::size_t(c)] = index < 0 ? kNone.data() : bits_of(index);
        full &= index >= 0 && m_is_full[std::size_t(index)];
    }
    return with_bit_layout(m_size, [&](auto layout) {
        const int words = layout.words();
        if (full || own < 0) {
            std::fill_n(voxels, words, full ? layout.all() : 0);
            return full ? Share::All : Share::None;
        }
        combine_around<false>(layout, cells, std::bit_and<BitWord>(), voxels);
        const bool any = std::any_of(voxels, voxels + words, [](BitWord word) { return word; });
        return any ? Share::Some : Share::None;
    });
}

}  // namespace pliant
