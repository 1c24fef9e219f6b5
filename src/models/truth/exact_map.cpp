// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "truth/exact_map.h"

#include <algorithm>

#include "field/field.h"
#include "resample/find_source.h"
#include "volume/boxes.h"

namespace pliant::truth {
namespace {

constexpr double kPositive = 1e-6;  ///< smallest triple product of a regular cell [voxels]
constexpr double kBeside = 1e-7;    ///< slack of boxes around cells [voxels]
constexpr double kNearFace = 1e-5;  ///< a point at rest, which is rounded, is in both cells
constexpr double kSame = 1e-5;      ///< sources closer than this are one [voxels]
static_assert(kBeside > kOnFace);

}  // namespace

/// Cell interface required by find_source(), for a walk through regular cells only.
class ExactMap::Cells {
  public:
    explicit Cells(const ExactMap& map) : m_map(map) {}
    bool corners(Vec3i cell, std::array<Vec3d, 8>& points) const {
        return contains(m_map.m_cells, cell) && m_map.find_corners(cell, points);
    }
    bool is_whole(Vec3i cell) const { return m_map.state_of(cell) == CellState::Regular; }

  private:
    const ExactMap& m_map;
};

CellState state_of_shape(const std::array<Vec3d, 8>& p) {
    // Edges along each axis, by the two other coordinates.
    std::array<Vec3d, 4> x, y, z;
    for (std::size_t n = 0; n < 4; ++n) {
        x[n] = p[2 * n + 1] - p[2 * n];
        const std::size_t low = (n & 1) + 4 * (n >> 1);
        y[n] = p[low + 2] - p[low];
        z[n] = p[n + 4] - p[n];
    }
    for (const Vec3d& dx : x)
        for (const Vec3d& dy : y) {
            const Vec3d across = cross(dx, dy);
            for (const Vec3d& dz : z)
                if (!(dot(across, dz) > kPositive)) return CellState::Folded;
        }
    return CellState::Regular;
}

ExactMap::ExactMap(const Deformation& deformation, const TaskArena& arena)
    : m_grid(deformation.grid()) {
    const Field& field = deformation.field();
    for (int a = 0; a < 3; ++a) m_voxels_per_unit[a] = 1 / (m_grid.spacing_mm[a] * kUnitsPerMm);
    m_elements = deformation.moved_box();
    const int size = field.brick_size();
    for (const auto& [coord, edits] : field.all_edits()) {
        const Vec3i first = size * coord;
        m_elements = hull(m_elements, {first, first + Vec3i{size, size, size}});
    }
    if (is_empty(m_elements)) return;
    m_elements = {m_elements.begin - Vec3i{1, 1, 1}, m_elements.end + Vec3i{1, 1, 1}};
    m_cells = {m_elements.begin, m_elements.end - Vec3i{1, 1, 1}};
    load(field, arena);
    find_states(arena);
    list_blocks(arena);
}

std::size_t ExactMap::index_of(Vec3i e) const {
    return dense_index(e - m_elements.begin, m_elements.end - m_elements.begin);
}
std::size_t ExactMap::cell_index(Vec3i c) const {
    return dense_index(c - m_cells.begin, m_cells.end - m_cells.begin);
}
bool ExactMap::Bounds::hold(Vec3d y) const {
    for (int a = 0; a < 3; ++a)
        if (y[a] < low[a] - kBeside || y[a] > high[a] + kBeside) return false;
    return true;
}

void ExactMap::load(const Field& field, const TaskArena& arena) {
    m_u.assign(dense_count(m_elements.end - m_elements.begin), {0, 0, 0});
    if (!field.all_edits().empty()) m_edits.assign(m_u.size(), 0);
    const int size = field.brick_size();
    const std::vector<int> bricks = field.resident_bricks();
    arena.for_each(std::int64_t(bricks.size()), 16, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin) {
            const FieldBrick& brick = field.brick(bricks[std::size_t(begin)]);
            const Vec3i first = size * brick.coord;
            const Box3i part = overlap({first, first + Vec3i{size, size, size}}, m_elements);
            if (brick.is_unplaced || is_empty(part)) continue;
            for_each_in(part, [&](Vec3i e) {
                const auto n = std::size_t(field.index_in_brick(e, brick.coord));
                m_u[index_of(e)] = {brick.u[0][n], brick.u[1][n], brick.u[2][n]};
            });
        }
    });
    for (const auto& [coord, edits] : field.all_edits())
        for (std::size_t n = 0; n < edits.size(); ++n) {
            const Vec3i e = field.element_of(coord, int(n));
            if (edits[n] && contains(m_elements, e)) m_edits[index_of(e)] = edits[n];
        }
}

Vec3d ExactMap::image_of(Vec3i e) const {
    const Vec3<Fixed> u = units_at(e);
    return {e.x + m_voxels_per_unit.x * u.x, e.y + m_voxels_per_unit.y * u.y,
            e.z + m_voxels_per_unit.z * u.z};
}

bool ExactMap::find_corners(Vec3i cell, std::array<Vec3d, 8>& points) const {
    const Vec3i n = m_elements.end - m_elements.begin;
    const std::size_t row = std::size_t(n.x), slice = row * std::size_t(n.y);
    const Vec3<Fixed>* const u = m_u.data() + index_of(cell);
    Fixed any = 0;
    for (std::size_t c = 0; c < 8; ++c) {
        const std::size_t x = c & 1, y = c >> 1 & 1, z = c >> 2;
        const Vec3<Fixed>& here = u[x + y * row + z * slice];
        any |= here.x | here.y | here.z;
        points[c] = {double(x) + m_voxels_per_unit.x * here.x,
                     double(y) + m_voxels_per_unit.y * here.y,
                     double(z) + m_voxels_per_unit.z * here.z};
    }
    return any != 0;
}

bool ExactMap::is_broken(Vec3i cell) const {
    if (m_edits.empty()) return false;
    std::array<int, 8> edits;
    int any = 0;
    for (int c = 0; c < 8; ++c) {
        edits[std::size_t(c)] = m_edits[index_of(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2})];
        any |= edits[std::size_t(c)];
    }
    if (!any) return false;
    if (any & kVoid) return true;
    constexpr int kCut[3] = {kCutX, kCutY, kCutZ};
    for (int c = 0; c < 8; ++c)
        for (int axis = 0; axis < 3; ++axis) {
            if (c >> axis & 1 || !(edits[std::size_t(c)] & kCut[axis])) continue;
            const int d = c | 1 << axis;
            if (units_at(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}) !=
                units_at(cell + Vec3i{d & 1, d >> 1 & 1, d >> 2}))
                return true;
        }
    return false;
}

/// The rows of the Jacobian are diagonally dominant everywhere in the cell.
bool ExactMap::is_plainly_regular(Vec3i cell) const {
    const Vec3i n = m_elements.end - m_elements.begin;
    const std::size_t steps[3] = {1, std::size_t(n.x), std::size_t(n.x) * std::size_t(n.y)};
    const Vec3<Fixed>* const u = m_u.data() + index_of(cell);
    double lowest[3] = {1, 1, 1};  // of each row: the diagonal, less the others
    for (int b = 0; b < 3; ++b) {
        const std::size_t along = steps[b], p = steps[(b + 1) % 3], q = steps[(b + 2) % 3];
        const double per_unit = m_voxels_per_unit[b];
        for (int a = 0; a < 3; ++a) {
            std::int64_t low = 0, high = 0;
            bool is_first = true;
            for (const std::size_t at : {std::size_t(0), p, q, p + q}) {
                const std::int64_t d = std::int64_t(u[at + along][a]) - u[at][a];
                low = is_first ? d : std::min(low, d);
                high = is_first ? d : std::max(high, d);
                is_first = false;
            }
            // The gradient along b in mm per mm, whatever the row's component.
            lowest[a] += per_unit * (a == b ? double(low) : -double(std::max(high, -low)));
        }
    }
    return lowest[0] > 0.01 && lowest[1] > 0.01 && lowest[2] > 0.01;
}

CellState ExactMap::shape_of(Vec3i cell) const {
    std::array<Vec3d, 8> corners;
    return find_corners(cell, corners) ? state_of_shape(corners) : CellState::Regular;
}

void ExactMap::find_states(const TaskArena& arena) {
    const Vec3i n = m_cells.end - m_cells.begin;
    m_states.assign(dense_count(n), CellState::Regular);
    const auto for_rows = [&](const auto& work) {
        arena.for_each(std::int64_t(n.y) * n.z, 32, [&](std::int64_t begin, std::int64_t end) {
            for (; begin < end; ++begin)
                work(m_cells.begin + Vec3i{0, int(begin % n.y), int(begin / n.y)});
        });
    };
    std::atomic<std::int64_t> folded = 0, bad = 0;
    for_rows([&](Vec3i row) {
        CellState* const states = m_states.data() + cell_index(row);
        std::int64_t folded_here = 0, bad_here = 0;
        for (int x = 0; x < n.x; ++x) {
            const Vec3i cell = row + Vec3i{x, 0, 0};
            if (is_broken(cell))
                states[x] = CellState::Broken;
            else if (!is_plainly_regular(cell))
                states[x] = shape_of(cell);
            folded_here += states[x] == CellState::Folded;
            bad_here += states[x] != CellState::Regular;
        }
        folded += folded_here;
        bad += bad_here;
    });
    m_folded_cells = folded;
    if (bad == 0) return;
    m_marks.assign(voxel_count(m_grid), 0);
    for_rows([&](Vec3i row) {
        const CellState* const states = m_states.data() + cell_index(row);
        for (int x = 0; x < n.x; ++x)
            if (states[x] != CellState::Regular) mark(row + Vec3i{x, 0, 0}, states[x]);
    });
}

void ExactMap::mark(Vec3i cell, CellState state) {
    std::array<Vec3d, 8> corners;
    find_corners(cell, corners);
    Vec3d low = corners[0], high = corners[0];
    for (const Vec3d& p : corners)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d slack{kBeside, kBeside, kBeside};
    const Box3i box =
        overlap({cell + floor_of(low - slack), cell + floor_of(high + slack) + Vec3i{1, 1, 1}},
                voxel_box(m_grid));
    if (is_empty(box)) return;
    const std::uint8_t bit = state == CellState::Folded ? kNearFolded : kNearBroken;
    for_each_in(box, [&](Vec3i p) {
        std::atomic_ref(m_marks[voxel_index(m_grid, p)]).fetch_or(bit, std::memory_order_relaxed);
    });
}

std::uint8_t ExactMap::mark_at(Vec3d y) const {
    if (m_marks.empty()) return 0;
    const Vec3i p = floor_of(y);
    return contains(voxel_box(m_grid), p) ? m_marks[voxel_index(m_grid, p)] : std::uint8_t(0);
}

ExactMap::Bounds ExactMap::bounds_of_block(Vec3i block) const {
    const Vec3i first = m_cells.begin + kBlock * block;
    const Box3i nodes =
        overlap({first, first + Vec3i{kBlock + 1, kBlock + 1, kBlock + 1}}, m_elements);
    Bounds bounds{image_of(nodes.begin), image_of(nodes.begin)};
    for_each_in(nodes, [&](Vec3i e) {
        const Vec3d y = image_of(e);
        for (int a = 0; a < 3; ++a) {
            bounds.low[a] = std::min(bounds.low[a], y[a]);
            bounds.high[a] = std::max(bounds.high[a], y[a]);
        }
    });
    return bounds;
}

void ExactMap::list_blocks(const TaskArena& arena) {
    for (int a = 0; a < 3; ++a) {
        m_tiles[a] = (m_grid.size[a] + kTile - 1) / kTile;
        m_blocks[a] = (m_cells.end[a] - m_cells.begin[a] + kBlock - 1) / kBlock;
    }
    m_block_bounds.resize(dense_count(m_blocks));
    const auto block_at = [&](std::int64_t n) {
        return Vec3i{int(n % m_blocks.x), int(n / m_blocks.x % m_blocks.y),
                     int(n / m_blocks.x / m_blocks.y)};
    };
    arena.for_each(std::int64_t(m_block_bounds.size()), 256,
                   [&](std::int64_t begin, std::int64_t end) {
                       for (; begin < end; ++begin)
                           m_block_bounds[std::size_t(begin)] = bounds_of_block(block_at(begin));
                   });
    // Twice: counts, then the lists.
    const auto for_tiles = [&](const auto& visit) {
        for (std::size_t block = 0; block < m_block_bounds.size(); ++block) {
            const Bounds& b = m_block_bounds[block];
            const Vec3i low = floor_of(b.low), high = floor_of(b.high);
            Box3i tiles;
            for (int a = 0; a < 3; ++a) {
                tiles.begin[a] = std::max(low[a] - 1, 0) / kTile;
                tiles.end[a] = std::min(std::max(high[a] + 1, -1) / kTile + 1, m_tiles[a]);
                if (high[a] + 1 < 0) tiles.end[a] = 0;
            }
            if (is_empty(tiles)) continue;
            for_each_in(tiles,
                        [&](Vec3i t) { visit(dense_index(t, m_tiles), std::uint32_t(block)); });
        }
    };
    m_tile_begin.assign(dense_count(m_tiles) + 1, 0);
    for_tiles([&](std::size_t tile, std::uint32_t) { ++m_tile_begin[tile + 1]; });
    for (std::size_t n = 1; n < m_tile_begin.size(); ++n) m_tile_begin[n] += m_tile_begin[n - 1];
    m_tile_blocks.resize(m_tile_begin.back());
    std::vector<std::uint32_t> next(m_tile_begin.begin(), m_tile_begin.end() - 1);
    for_tiles([&](std::size_t tile, std::uint32_t block) { m_tile_blocks[next[tile]++] = block; });
}

std::optional<Vec3d> ExactMap::image_of(Vec3d x) const {
    const Vec3i low = floor_of(x);
    const Vec3d t = x - real_of(low);
    if (t == Vec3d{0, 0, 0}) {
        if (is_void(low)) return {};
        return image_of(low);
    }
    // A point on a face is in both cells.
    for (int c = 0; c < 27; ++c) {
        const Vec3i step{(c + 1) % 3 - 1, (c / 3 + 1) % 3 - 1, (c / 9 + 1) % 3 - 1};
        bool is_in = true;
        for (int a = 0; a < 3; ++a)
            is_in &= step[a] == 0 || (step[a] < 0 ? t[a] < kNearFace : t[a] > 1 - kNearFace);
        const Vec3i cell = low + step;
        if (!is_in || state_of(cell) == CellState::Broken) continue;
        if (!contains(m_cells, cell)) return x;
        std::array<Vec3d, 8> corners;
        if (!find_corners(cell, corners)) return x;
        return real_of(cell) + TrilinearCell(corners).at(x - real_of(cell));
    }
    return {};
}

/// Looks into all cells around y.
TruthMask ExactMap::search(Vec3d y, Vec3d& x) const {
    int found = 0;
    const auto take = [&](Vec3d source) {
        const Vec3d apart = source - x;
        if (found > 0 && dot(apart, apart) < kSame * kSame) return;
        if (found == 0) x = source;
        ++found;
    };
    bool is_inside = !is_empty(m_elements);
    for (int a = 0; a < 3; ++a)
        is_inside &= y[a] > m_elements.begin[a] && y[a] < m_elements.end[a] - 1;
    if (!is_inside) take(y);
    const auto look_into = [&](std::size_t block) {
        if (!m_block_bounds[block].hold(y)) return true;
        const auto n = std::int64_t(block);
        const Vec3i first =
            m_cells.begin + kBlock * Vec3i{int(n % m_blocks.x), int(n / m_blocks.x % m_blocks.y),
                                           int(n / m_blocks.x / m_blocks.y)};
        bool is_clear = true;
        for_each_in(
            overlap({first, first + Vec3i{kBlock, kBlock, kBlock}}, m_cells), [&](Vec3i cell) {
                const CellState state = m_states[cell_index(cell)];
                if (!is_clear || state == CellState::Broken) return;
                std::array<Vec3d, 8> corners;
                find_corners(cell, corners);
                const Vec3d point = y - real_of(cell);
                if (!is_near(corners, point)) return;
                if (state == CellState::Folded)
                    is_clear = false;
                else if (const auto t = TrilinearCell(corners).locate_from_corners(point, kOnFace))
                    take(real_of(cell) + *t);
            });
        return is_clear;
    };
    const Vec3i p = floor_of(y);
    if (contains(voxel_box(m_grid), p) && !m_tile_begin.empty()) {
        const std::size_t tile = dense_index({p.x / kTile, p.y / kTile, p.z / kTile}, m_tiles);
        for (std::uint32_t n = m_tile_begin[tile]; n < m_tile_begin[tile + 1]; ++n)
            if (!look_into(m_tile_blocks[n])) return TruthMask::Ambiguous;
    }
    return found == 0 ? TruthMask::Gap : found == 1 ? TruthMask::Exact : TruthMask::Ambiguous;
}

TruthMask ExactMap::source_of(Vec3d y, Vec3d guess, Vec3d& x) const {
    if (mark_at(y) != 0) return search(y, x);
    // Exactly one source, in a regular cell.
    Cells cells(*this);
    auto found = walk_to_source(cells, y, guess);
    if (!found) found = walk_to_source(cells, y, y);
    if (!found) return search(y, x);
    x = *found;
    return TruthMask::Exact;
}

}  // namespace pliant::truth
