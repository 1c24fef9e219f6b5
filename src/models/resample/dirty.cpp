// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/dirty.h"

#include <algorithm>
#include <functional>

namespace pliant {
namespace {

constexpr std::int64_t kBlocksPerTask = 64;
constexpr double kReachSlack = 1e-3;  ///< for rounding [voxels]

}  // namespace

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
