// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/scatter.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "base/stopwatch.h"

namespace pliant {
namespace {

constexpr int kSlabsPerThread = 2;
constexpr std::size_t kFewBricks = 128;  ///< number that one thread writes before another is awake
constexpr std::int64_t kBricksPerScatter = 64, kStripsPerTask = 32;

constexpr std::int64_t kBlocksPerTask = 64;
constexpr double kReachSlack = 1e-3;  ///< for rounding [voxels]

}  // namespace

Scatter::Scatter(const Volume& original, const TaskArena& arena)
    : m_original(original),
      m_arena(arena),
      m_writers(std::size_t(arena.thread_count())),
      m_open(original.grid) {}

/// Calls work(bricks) for parts of the dirty bricks, on all threads.
template <class Work>
void Scatter::for_dirty(const Work& work) {
    const std::span bricks = m_dirty.bricks();
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        work(bricks.subspan(std::size_t(begin), std::size_t(end - begin)));
    };
    // By reference: a copy of the captures would allocate.
    m_arena.for_each(std::int64_t(bricks.size()), kBricksPerScatter, std::ref(task));
}

/// Calls work(writer) on several threads, one writer for each, as many as pay off.
template <class Work>
void Scatter::for_writers(const Work& work) {
    const bool few = m_dirty.bricks().size() <= kFewBricks;
    for (StripWriter& writer : m_writers) writer.forget();
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t w = begin; w < end; ++w) work(m_writers[std::size_t(w)]);
    };
    m_arena.for_each(few ? 1 : std::int64_t(m_writers.size()), 1, std::ref(task));
}

OpenVoxels Scatter::look(const Field& field, Mapping mapping, Volume& deformed) {
    std::swap(m_now, m_before);
    m_now.snapshot.take(field, m_before.snapshot, m_arena);
    m_now.touched.find(m_now.snapshot, field.brick_size(), m_arena);
    m_dirty.find(m_original.grid, field.brick_size(), m_before, m_now, m_arena);
    note_dirty();
    list_strips(field);
    m_open.set_brick_size(field.brick_size());
    m_open.close_all_but(m_dirty.flags());
    const ScatterJob job = job_of(field, mapping);
    const CellTarget target = target_of(deformed);
    for_dirty([&](std::span<DirtyBrick> bricks) { open_changeable(job, target, m_open, bricks); });
    OpenVoxels all;
    for (const DirtyBrick& brick : m_dirty.bricks()) {
        if (!brick.opened) continue;
        m_open.note_open(dense_index(brick.coord, job.bricks));
        all.count += brick.opened;
        all.box = hull(all.box, brick.open);
    }
    m_opened = all.count;
    return all;
}

std::int64_t Scatter::write(const Field& field, Mapping mapping, Volume& deformed,
                            Vec3f* inverse_mm, const Box3i& inverse_box) {
    const ScatterJob job = job_of(field, mapping);
    CellTarget target = target_of(deformed);
    target.inverse_mm = inverse_mm;
    target.inverse_box = inverse_box;
    bool any_open = true;
    if (mapping == Mapping::Cells) {
        if (job.has_gaps())
            write_slabs(job, target);
        else
            write_each_once(job, target);
        any_open = open_contested(job, target);
        if (any_open) {
            claim(job, target, {mapping, CellFaces::HalfOpen});
            // Beside a missing cell, the voxels on the face between belong to the other one.
            claim(job, target, {mapping, CellFaces::Closed});
        }
    } else {
        write_slabs(job, target);
    }
    // Inversion can fail in a strongly folded cell; the tetrahedra always converge.
    if (mapping != Mapping::Tetrahedra && any_open)
        claim(job, target, {Mapping::Tetrahedra, CellFaces::Closed});
    const std::int64_t gaps = any_open ? fill_gaps(target, m_dirty.bricks()) : 0;
    m_open.end_turn();
    list_boxes(field.brick_size());
    return gaps;
}

void Scatter::clear_inverse(const Field& field, Vec3f* inverse_mm) {
    for_dirty([&](std::span<DirtyBrick> bricks) {
        for (const DirtyBrick& brick : bricks) {
            if (!brick.opened && !brick.was_changed) continue;
            const Box3i box = box_of_brick(m_original.grid, brick.coord, field.brick_size());
            for_each_row(box, [&](Vec3i p) {
                std::fill_n(inverse_mm + voxel_index(m_original.grid, p), box.end.x - box.begin.x,
                            Vec3f{0, 0, 0});
            });
        }
    });
}

void Scatter::write_each_once(const ScatterJob& job, const CellTarget& target) {
    StripQueue queue(job.strips.size(), m_writers.size());
    for_writers([&](StripWriter& writer) { writer.write_each_once(job, target, queue); });
}

/// Continues after the voxels of single cells: writes claims on their edges, and opens voxels that
/// several cells may hold. @returns whether there may be any
bool Scatter::open_contested(const ScatterJob& job, const CellTarget& target) {
    std::int64_t written = write_claims(target);
    bool any_contested = job.has_gaps();
    for (const StripWriter& writer : m_writers) {
        written += writer.written();
        any_contested |= !writer.contested().empty();
    }
    if (!any_contested && written == m_opened) return false;
    if (job.has_gaps())
        for_dirty([&](std::span<DirtyBrick> bricks) { close_taken(target, bricks); });
    const auto reopen = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t w = begin; w < end; ++w)
            open_again(job, target, m_open, m_writers[std::size_t(w)].contested());
    };
    m_arena.for_each(std::int64_t(m_writers.size()), 1, std::ref(reopen));
    for_dirty([&](std::span<DirtyBrick> bricks) { find_open(job, target, bricks); });
    return true;
}

void Scatter::claim(const ScatterJob& job, const CellTarget& target, ClaimPass pass) {
    if (!m_open_boxes.list(m_dirty.bricks(), job.bricks, job.field.brick_size())) return;
    NextStrip next = 0;
    for_writers([&](StripWriter& writer) { writer.claim(job, target, m_open_boxes, pass, next); });
    write_claims(target);
    for_dirty([&](std::span<DirtyBrick> bricks) { find_open(job, target, bricks); });
}

/// Writes, for each claimed voxel, the claim of the first cell that surely holds it. @returns the
/// number of written voxels
std::int64_t Scatter::write_claims(const CellTarget& target) {
    m_claims.clear();
    for (const StripWriter& writer : m_writers)
        m_claims.insert(m_claims.end(), writer.claims().begin(), writer.claims().end());
    std::sort(m_claims.begin(), m_claims.end(), [](const Claim& a, const Claim& b) {
        return std::tie(a.voxel, a.is_edge, a.strip, a.cell) <
               std::tie(b.voxel, b.is_edge, b.strip, b.cell);
    });
    return std::count_if(m_claims.begin(), m_claims.end(),
                         [&](const Claim& claim) { return write_claim(claim, target); });
}

void Scatter::write_slabs(const ScatterJob& job, const CellTarget& target) {
    const std::vector<DirtyBrick>& bricks = m_dirty.bricks();
    if (bricks.empty()) return;
    const int size = job.field.brick_size();
    const int first = size * bricks.front().coord.z;
    const int layers = std::min(size * (bricks.back().coord.z + 1), m_original.grid.size.z) - first;
    const int writers = bricks.size() <= kFewBricks ? 1 : int(m_writers.size());
    const int slabs = std::min(layers, writers > 1 ? kSlabsPerThread * writers : 1);
    std::atomic<int> next = 0;
    for_writers([&](StripWriter& writer) {
        for (int slab; (slab = next++) < slabs;) {
            CellTarget part = target;
            part.takes = true;
            part.box.begin.z = first + layers * slab / slabs;
            part.box.end.z = first + layers * (slab + 1) / slabs;
            if (job.mapping == Mapping::Cells)
                writer.write_each_once(job, part);
            else
                writer.write_in_order(job, part);
        }
    });
    if (job.mapping != Mapping::Cells)
        for_dirty([&](std::span<DirtyBrick> parts) { find_open(job, target, parts); });
}

/// Lists all strips that can hold a touched cell and reach into the scan, sorted by coordinate: the
/// list doesn't depend on the history.
void Scatter::list_strips(const Field& field) {
    m_strips.clear();
    const StripLayout layout(field.brick_size());
    Vec3i last{INT32_MIN, 0, 0};
    for (const Vec3i brick : m_now.touched.bricks()) {
        const Vec3i coord{layout.first_of(brick.x), brick.y, brick.z};
        if (coord == last) continue;
        last = coord;
        m_strips.push_back({coord, {}, {}});
    }
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto s = std::size_t(begin); s < std::size_t(end); ++s) {
            ReachingStrip& strip = m_strips[s];
            strip.reach = m_now.touched.reach(m_original.grid, strip.coord, layout.bricks);
            strip.voxels = voxels_within(strip.reach, voxel_box(m_original.grid));
        }
    };
    m_arena.for_each(std::int64_t(m_strips.size()), kStripsPerTask, std::ref(task));
    std::erase_if(m_strips, [](const ReachingStrip& strip) { return is_empty(strip.voxels); });
}

void Scatter::note_dirty() {
    const Vec3i count = m_dirty.brick_count();
    if (m_put_back.empty()) {
        m_differs.assign(dense_count(count), 0);
        m_put_back.assign(dense_count(count), 0);
    }
    for (const DirtyBrick& brick : m_dirty.bricks()) m_differs[dense_index(brick.coord, count)] = 1;
}

void Scatter::list_boxes(int brick_size) {
    const Vec3i count = m_dirty.brick_count();
    m_boxes.clear();
    if (m_has_put_back)
        for_each_in({{0, 0, 0}, count}, [&](Vec3i brick) {
            const std::size_t index = dense_index(brick, count);
            if (m_differs[index] || m_put_back[index]) add_box(brick, brick_size);
        });
    else
        for (const DirtyBrick& brick : m_dirty.bricks())
            if (brick.opened || brick.was_changed) add_box(brick.coord, brick_size);
    // All memory is allocated: nothing fails from here on.
    for (const DirtyBrick& brick : m_dirty.bricks())
        m_differs[dense_index(brick.coord, count)] = brick.opened > 0;
    if (m_has_put_back) std::fill(m_put_back.begin(), m_put_back.end(), std::uint8_t(0));
    m_has_put_back = false;
}

/// Adds a brick's box. Neighbours in a row become one box.
void Scatter::add_box(Vec3i brick, int brick_size) {
    const Box3i box = box_of_brick(m_original.grid, brick, brick_size);
    if (!m_boxes.empty() && m_boxes.back().end.x == box.begin.x &&
        m_boxes.back().begin.y == box.begin.y && m_boxes.back().begin.z == box.begin.z)
        m_boxes.back().end.x = box.end.x;
    else
        m_boxes.push_back(box);
}

void Scatter::start_over(Volume& deformed, Vec3f* inverse_mm) noexcept {
    const CellTarget target = target_of(deformed);
    const auto put_back = [&](const auto& original, auto* voxels) {
        m_open.for_boxes(m_differs, [&](const Box3i& box) {
            for_each_row(box, [&](Vec3i p) {
                const std::size_t at = voxel_index(m_original.grid, p);
                const int width = box.end.x - box.begin.x;
                std::copy_n(original.data() + at, width, voxels + at);
                if (inverse_mm) std::fill_n(inverse_mm + at, width, Vec3f{0, 0, 0});
            });
        });
    };
    if (const auto* original = std::get_if<VoxelArray<std::int16_t>>(&m_original.voxels))
        put_back(*original, target.voxels16);
    else if (const auto* floats = std::get_if<VoxelArray<float>>(&m_original.voxels))
        put_back(*floats, target.voxels32);
    m_open.close_all(m_differs);
    for (std::size_t n = 0; n < m_differs.size(); ++n) m_put_back[n] |= m_differs[n];
    std::fill(m_differs.begin(), m_differs.end(), std::uint8_t(0));
    m_now = {};
    m_before = {};
    m_dirty = {};
    m_open_boxes = {};
    for (StripWriter& writer : m_writers) writer = {};
    m_has_put_back = true;
}

CellTarget Scatter::target_of(Volume& deformed) {
    const Grid& grid = m_original.grid;
    CellTarget target;
    target.box = voxel_box(grid);
    target.grid_size = grid.size;
    target.open = m_open.voxels();
    target.turn = m_open.turn();
    target.background = m_original.background;
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

ScatterJob Scatter::job_of(const Field& field, Mapping mapping) const {
    return {m_original, field,    m_now.snapshot,  m_now.touched,
            mapping,    m_strips, m_dirty.flags(), m_dirty.brick_count()};
}

Deformed deform_by_field(const Volume& original, const Field& field, Mapping mapping,
                         bool with_inverse, const TaskArena& arena) {
    Deformed deformed;
    deformed.volume = original;
    const Stopwatch watch;
    Scatter scatter(original, arena);
    const OpenVoxels open = scatter.look(field, mapping, deformed.volume);
    deformed.dirty_box = open.box;
    deformed.written_voxels = open.count;
    const Vec3i n = open.box.end - open.box.begin;
    if (with_inverse) deformed.inverse_mm.assign(dense_count(n), Vec3f{0, 0, 0});
    deformed.gap_voxels =
        scatter.write(field, mapping, deformed.volume,
                      with_inverse ? deformed.inverse_mm.data() : nullptr, open.box);
    deformed.resample_ms = watch.ms();
    return deformed;
}

Box3i voxels_within(const CellReach& reach, const Box3i& within) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int first = within.begin[a], last = within.end[a];
        const double low = std::clamp<double>(reach.low[a] - kReachSlack, first, last);
        const double high = std::clamp<double>(reach.high[a] + kReachSlack, first - 1, last - 1);
        // Floor and ceiling without function calls: clamped values fit.
        box.begin[a] = int(low) + (int(low) < low);
        box.end[a] = int(high) - (int(high) > high) + 1;
    }
    return box;
}

void Dirty::find(const Grid& grid, int brick_size, const Motion& before, const Motion& now,
                 const TaskArena& arena) {
    for (int a = 0; a < 3; ++a) m_brick_count[a] = (grid.size[a] + brick_size - 1) / brick_size;
    m_dirty.assign(dense_count(m_brick_count), 0);
    mark_changes(grid, brick_size, before, now, arena);
    m_bricks.clear();
    for_each_row({{0, 0, 0}, m_brick_count}, [&](Vec3i row) {
        const std::uint8_t* flags = m_dirty.data() + dense_index(row, m_brick_count);
        for (int x = 0; x < m_brick_count.x; ++x)
            if (flags[x]) m_bricks.push_back({.coord = {x, row.y, row.z}});
    });
}

/// Marks the bricks that cells at changed elements cover at rest, covered before, and cover now.
void Dirty::mark_changes(const Grid& grid, int size, const Motion& before, const Motion& now,
                         const TaskArena& arena) {
    const Box3i scan = voxel_box(grid), box = hull(before.snapshot.box(), now.snapshot.box());
    const Vec3i one{1, 1, 1}, first = box.begin - one, n = box.end - first;
    if (is_empty(box)) return;
    m_block_flags.assign(dense_count(n), 0);
    const auto mark_brick = [&](Vec3i coord) {
        mark({coord - one, coord + one + one});
        for (int c = 0; c < 8; ++c)
            put(m_block_flags[dense_index(coord - Vec3i{c & 1, c >> 1 & 1, c >> 2} - first, n)],
                std::uint8_t(1));
    };
    const auto compare = [&](std::int64_t begin, std::int64_t end) {
        for (auto r = std::size_t(begin); r < std::size_t(end); ++r) {
            const BrickRecord& record = now.snapshot.records()[r];
            const BrickRecord* old = before.snapshot.record_at(record.coord);
            if (!old || old->stamp != record.stamp) mark_brick(record.coord);
        }
    };
    // By reference: a copy of the captures would allocate.
    arena.for_each(std::int64_t(now.snapshot.records().size()), kBlocksPerTask, std::ref(compare));
    for (const BrickRecord& record : before.snapshot.records())
        if (!now.snapshot.record_at(record.coord)) mark_brick(record.coord);
    widen_to_strips(grid, size, before, now, {first, box.end});
    m_changed_blocks.clear();
    std::size_t i = 0;
    for_each_in({first, box.end}, [&](Vec3i block) {
        if (m_block_flags[i++]) m_changed_blocks.push_back(block);
    });
    const auto cover = [&](std::int64_t begin, std::int64_t end) {
        for (auto b = std::size_t(begin); b < std::size_t(end); ++b)
            for (const Motion* motion : {&before, &now}) {
                if (motion->snapshot.records().empty()) continue;  // marked as bricks at rest
                const CellReach reach = motion->touched.reach(grid, m_changed_blocks[b], 1);
                const Box3i voxels = voxels_within(reach, scan);
                if (!is_empty(voxels)) mark(bricks_of(voxels, size));
            }
    };
    arena.for_each(std::int64_t(m_changed_blocks.size()), kBlocksPerTask, std::ref(cover));
}

/// Adds whole strips whose frames changed: all bits that they write change with the frame.
void Dirty::widen_to_strips(const Grid& grid, int size, const Motion& before, const Motion& now,
                            const Box3i& blocks) {
    const StripLayout layout(size);
    const Vec3i n = blocks.end - blocks.begin;
    const auto frame = [&](const Motion& motion, Vec3i coord) {
        return frame_of_strip(motion.snapshot, grid, size, coord,
                              motion.touched.reach(grid, coord, layout.bricks));
    };
    for_each_row(blocks, [&](Vec3i row) {
        std::uint8_t* flags = m_block_flags.data() + dense_index(row - blocks.begin, n);
        for (int x = layout.first_of(row.x); x < blocks.end.x; x += layout.bricks) {
            const auto part =
                std::span(flags, std::size_t(n.x)).subspan(std::size_t(std::max(x - row.x, 0)));
            const auto strip = part.first(
                std::min(part.size(), std::size_t(x + layout.bricks - std::max(x, row.x))));
            const auto marked = std::count(strip.begin(), strip.end(), 1);
            const Vec3i coord{x, row.y, row.z};
            if (marked > 0 && marked < std::ptrdiff_t(strip.size()) &&
                frame(before, coord) != frame(now, coord))
                std::fill(strip.begin(), strip.end(), 1);
        }
    });
}

void Dirty::mark(const Box3i& bricks) {
    const Box3i inside = overlap(bricks, {{0, 0, 0}, m_brick_count});
    for_each_row(inside, [&](Vec3i row) {
        std::uint8_t* flags = m_dirty.data() + dense_index(row, m_brick_count);
        for (int x = 0; x < inside.end.x - inside.begin.x; ++x) put(flags[x], std::uint8_t(1));
    });
}

}  // namespace pliant
