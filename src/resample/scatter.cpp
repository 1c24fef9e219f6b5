// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/scatter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <new>
#include <tuple>

#include "chainmail/cell_block.h"

namespace pliant {
namespace {

constexpr int kSlabsPerThread = 2;  ///< if there are several; strips between two are visited twice
constexpr std::size_t kFewBricks = 128;  ///< that one thread writes before another is awake
constexpr std::int64_t kBlocksPerTask = 64;
constexpr double kReachSlack = 1e-3;  ///< for rounding [voxels]

Box3i voxels_within(const CellReach& reach, const Box3i& within) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const double low = std::ceil(reach.low[a] - kReachSlack);
        const double high = std::floor(reach.high[a] + kReachSlack) + 1;
        box.begin[a] = int(std::clamp<double>(low, within.begin[a], within.end[a]));
        box.end[a] = int(std::clamp<double>(high, within.begin[a], within.end[a]));
    }
    return box;
}

/// The smallest box around two, each of which may be empty.
Box3i hull(const Box3i& a, const Box3i& b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::min(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::max(a.end[axis], b.end[axis]);
    }
    return both;
}

std::size_t dense_index(Vec3i p, Vec3i n) {
    return std::size_t(p.x) +
           std::size_t(n.x) * (std::size_t(p.y) + std::size_t(n.y) * std::size_t(p.z));
}
std::size_t dense_count(Vec3i n) {
    return std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
}

}  // namespace

Scatter::Scatter(const Volume& original, const TaskArena& arena)
    : m_original(original), m_arena(arena) {
    // Memory that nobody writes to stays unused: only pages with open voxels become resident.
    m_open.reset(static_cast<std::uint8_t*>(std::calloc(voxel_count(original.grid), 1)));
    if (!m_open) throw std::bad_alloc();
}

OpenVoxels Scatter::look(const Lattice& lattice, Mapping mapping, Volume& deformed) {
    std::swap(m_now, m_before);
    m_now.take(lattice, m_before, m_arena);
    m_touched.find(m_now, lattice.brick_size(), m_arena);
    find_dirty(lattice);
    list_strips(lattice);
    list_slabs();
    if (m_writers.size() < m_slabs.size()) m_writers.resize(m_slabs.size());
    const ScatterJob job = job_of(lattice, mapping);
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto s = std::size_t(begin); s < std::size_t(end); ++s) {
            Slab& slab = m_slabs[s];
            slab.open = m_writers[s].open(
                job, target_of(box_of(slab, lattice.brick_size()), deformed),
                std::span(m_bricks).subspan(slab.first_brick, slab.last_brick - slab.first_brick));
        }
    };
    // By reference: a copy of the captures would be allocated.
    m_arena.for_each(std::int64_t(m_slabs.size()), 1, std::ref(task));
    OpenVoxels all;
    all.box = {{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (const Slab& slab : m_slabs) {
        all.count += slab.open.count;
        for (int a = 0; a < 3; ++a) {
            all.box.begin[a] = std::min(all.box.begin[a], slab.open.box.begin[a]);
            all.box.end[a] = std::max(all.box.end[a], slab.open.box.end[a]);
        }
    }
    if (all.count == 0) all.box = {};
    return all;
}

std::int64_t Scatter::write(const Lattice& lattice, Mapping mapping, Volume& deformed,
                            Vec3f* inverse_mm, const Box3i& inverse_box) {
    const ScatterJob job = job_of(lattice, mapping);
    const bool one_to_one =
        mapping == Mapping::Cells && !m_now.has_edits() && !lattice.is_void({-1, 0, 0});
    if (one_to_one) {
        CellTarget target = target_of(voxel_box(m_original.grid), deformed);
        target.inverse_mm = inverse_mm;
        target.inverse_box = inverse_box;
        write_strips(job, target);
    }
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto s = std::size_t(begin); s < std::size_t(end); ++s) {
            Slab& slab = m_slabs[s];
            CellTarget target = target_of(box_of(slab, lattice.brick_size()), deformed);
            target.inverse_mm = inverse_mm;
            target.inverse_box = inverse_box;
            slab.gaps = m_writers[s].write(
                job, target,
                std::span(m_bricks).subspan(slab.first_brick, slab.last_brick - slab.first_brick),
                one_to_one);
        }
    };
    m_arena.for_each(std::int64_t(m_slabs.size()), 1, std::ref(task));
    std::int64_t gaps = 0;
    for (const Slab& slab : m_slabs) gaps += slab.gaps;
    list_boxes(lattice.brick_size());
    return gaps;
}

void Scatter::write_strips(const ScatterJob& job, const CellTarget& target) {
    const std::size_t writers = m_slabs.size() > 1 ? std::size_t(m_arena.thread_count()) : 1;
    if (m_writers.size() < writers) m_writers.resize(writers);
    std::atomic<std::size_t> next = 0;
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto w = std::size_t(begin); w < std::size_t(end); ++w)
            m_writers[w].write_strips(job, target, next);
    };
    m_arena.for_each(std::int64_t(writers), 1, std::ref(task));
    m_edge.clear();
    for (std::size_t w = 0; w < writers; ++w)
        m_edge.insert(m_edge.end(), m_writers[w].edge_voxels().begin(),
                      m_writers[w].edge_voxels().end());
    std::sort(m_edge.begin(), m_edge.end(), [](const EdgeVoxel& a, const EdgeVoxel& b) {
        return std::tie(a.voxel, a.strip, a.cell) < std::tie(b.voxel, b.strip, b.cell);
    });
    for (const EdgeVoxel& edge : m_edge) write_edge(edge, target);
    m_contested.clear();
    for (std::size_t w = 0; w < writers; ++w)
        m_contested.insert(m_contested.end(), m_writers[w].contested().begin(),
                           m_writers[w].contested().end());
    open_again(job, target, m_contested);
}

void Scatter::find_dirty(const Lattice& lattice) {
    const Vec3i n = m_original.grid.size;
    const int size = lattice.brick_size();
    m_brick_count = {(n.x + size - 1) / size, (n.y + size - 1) / size, (n.z + size - 1) / size};
    m_dirty.assign(dense_count(m_brick_count), 0);
    m_changed.resize(dense_count(m_brick_count), 0);
    mark_changes(lattice);
    m_bricks.clear();
    std::size_t i = 0;
    for (int z = 0; z < m_brick_count.z; ++z)
        for (int y = 0; y < m_brick_count.y; ++y)
            for (int x = 0; x < m_brick_count.x; ++x, ++i)
                if (m_dirty[i]) m_bricks.push_back({{x, y, z}, m_changed[i] != 0});
}

/// Marks what the cells at changed elements cover at rest, covered before, and cover now.
void Scatter::mark_changes(const Lattice& lattice) {
    const int size = lattice.brick_size();
    const Box3i scan = voxel_box(m_original.grid), box = hull(m_before.box(), m_now.box());
    const Vec3i one{1, 1, 1}, first = box.begin - one, n = box.end - first;
    if (is_empty(box)) return;
    m_block_flags.assign(dense_count(n), 0);
    const auto mark_brick = [&](Vec3i coord) {
        mark({size * coord - one, size * (coord + one) + one}, size);
        for (int c = 0; c < 8; ++c)
            m_block_flags[dense_index(coord - Vec3i{c & 1, c >> 1 & 1, c >> 2} - first, n)] = 1;
    };
    for (const BrickRecord& record : m_now.records()) {
        const BrickRecord* old = m_before.record_at(record.coord);
        if (!old || old->stamp != record.stamp) mark_brick(record.coord);
    }
    for (const BrickRecord& record : m_before.records())
        if (!m_now.record_at(record.coord)) mark_brick(record.coord);
    m_changed_blocks.clear();
    std::size_t i = 0;
    for (int z = 0; z < n.z; ++z)
        for (int y = 0; y < n.y; ++y)
            for (int x = 0; x < n.x; ++x, ++i)
                if (m_block_flags[i]) m_changed_blocks.push_back({first + Vec3i{x, y, z}, {}, {}});
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        const auto covered = [&](const Snapshot& snapshot, Vec3i block) {
            return voxels_within(
                reach_of_block(records_of_block(snapshot, block), m_original.grid, size, block),
                scan);
        };
        for (auto b = std::size_t(begin); b < std::size_t(end); ++b) {
            ChangedBlock& block = m_changed_blocks[b];
            block.before = covered(m_before, block.coord);
            block.now = covered(m_now, block.coord);
        }
    };
    m_arena.for_each(std::int64_t(m_changed_blocks.size()), kBlocksPerTask, std::ref(task));
    for (const ChangedBlock& block : m_changed_blocks) {
        mark(block.before, size);
        mark(block.now, size);
    }
}

void Scatter::mark(Box3i voxels, int brick_size) {
    for (int a = 0; a < 3; ++a) {
        voxels.begin[a] = std::max(voxels.begin[a], 0);
        voxels.end[a] = std::min(voxels.end[a], m_original.grid.size[a]);
    }
    if (is_empty(voxels)) return;
    for (int z = voxels.begin.z / brick_size; z <= (voxels.end.z - 1) / brick_size; ++z)
        for (int y = voxels.begin.y / brick_size; y <= (voxels.end.y - 1) / brick_size; ++y)
            for (int x = voxels.begin.x / brick_size; x <= (voxels.end.x - 1) / brick_size; ++x)
                m_dirty[dense_index({x, y, z}, m_brick_count)] = 1;
}

/// All strips that can hold a touched cell and reach into the scan, sorted by coordinate: the same
/// for any history.
void Scatter::list_strips(const Lattice& lattice) {
    m_strips.clear();
    const int bricks = bricks_per_strip(lattice.brick_size());
    Vec3i last{INT32_MIN, 0, 0};
    for (const Vec3i brick : m_touched.bricks()) {
        const Vec3i coord{bricks * int(std::floor(double(brick.x) / bricks)), brick.y, brick.z};
        if (coord == last) continue;
        last = coord;
        const CellReach reach = reach_of_strip(m_now, m_original.grid, lattice.brick_size(), coord);
        const Box3i voxels = voxels_within(reach, voxel_box(m_original.grid));
        if (!is_empty(voxels)) m_strips.push_back({coord, reach, voxels});
    }
}

/// m_bricks is sorted by layer.
void Scatter::list_slabs() {
    m_slabs.clear();
    if (m_bricks.empty()) return;
    const int first = m_bricks.front().coord.z, last = m_bricks.back().coord.z;
    const int threads = m_bricks.size() <= kFewBricks ? 1 : m_arena.thread_count();
    const int thickness = 1 + (last - first) / (threads > 1 ? kSlabsPerThread * threads : 1);
    std::size_t brick = 0;
    for (int begin = first; begin <= last; begin += thickness) {
        Slab slab{begin, begin + thickness, brick, brick, {}, 0};
        while (brick < m_bricks.size() && m_bricks[brick].coord.z < slab.end) ++brick;
        slab.last_brick = brick;
        m_slabs.push_back(slab);
    }
}

void Scatter::list_boxes(int brick_size) {
    m_boxes.clear();
    const Vec3i n = m_original.grid.size;
    for (const DirtyBrick& brick : m_bricks) {
        m_changed[dense_index(brick.coord, m_brick_count)] = brick.is_changeable;
        if (!brick.is_changeable && !brick.was_changed) continue;
        const Vec3i first = brick_size * brick.coord;
        const Box3i box{first,
                        {std::min(first.x + brick_size, n.x), std::min(first.y + brick_size, n.y),
                         std::min(first.z + brick_size, n.z)}};
        // Neighbours in a row are one box.
        if (!m_boxes.empty() && m_boxes.back().end.x == box.begin.x &&
            m_boxes.back().begin.y == box.begin.y && m_boxes.back().begin.z == box.begin.z)
            m_boxes.back().end.x = box.end.x;
        else
            m_boxes.push_back(box);
    }
}

Box3i Scatter::box_of(const Slab& slab, int brick_size) const {
    Box3i box = voxel_box(m_original.grid);
    box.begin.z = slab.begin * brick_size;
    box.end.z = std::min(slab.end * brick_size, box.end.z);
    return box;
}

CellTarget Scatter::target_of(const Box3i& box, Volume& deformed) {
    const Grid& grid = m_original.grid;
    CellTarget target;
    target.box = box;
    target.grid_size = grid.size;
    target.open = m_open.get();
    if (auto* voxels = std::get_if<VoxelArray<std::int16_t>>(&deformed.voxels))
        target.voxels16 = voxels->data();
    else
        target.voxels32 = std::get<VoxelArray<float>>(deformed.voxels).data();
    for (int a = 0; a < 3; ++a) {
        const Vec3d step = grid.spacing_mm[a] * grid.direction.columns[a];
        target.world_from_voxels[a] = {float(step.x), float(step.y), float(step.z)};
    }
    return target;
}

ScatterJob Scatter::job_of(const Lattice& lattice, Mapping mapping) const {
    return {m_original, lattice, m_now, m_touched, mapping, m_strips, m_dirty, m_brick_count};
}

Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena) {
    Deformed deformed;
    deformed.volume = original;
    const auto start = std::chrono::steady_clock::now();
    Scatter scatter(original, arena);
    const OpenVoxels open = scatter.look(lattice, mapping, deformed.volume);
    deformed.dirty_box = open.box;
    deformed.written_voxels = open.count;
    const Vec3i n = open.box.end - open.box.begin;
    if (with_inverse) deformed.inverse_mm.assign(dense_count(n), Vec3f{0, 0, 0});
    deformed.gap_voxels =
        scatter.write(lattice, mapping, deformed.volume,
                      with_inverse ? deformed.inverse_mm.data() : nullptr, open.box);
    deformed.resample_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return deformed;
}

}  // namespace pliant
