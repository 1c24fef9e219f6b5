// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/bricks.h"

#include <algorithm>

namespace pliant::render {
namespace {

template <class T>
void include(Range<T>& range, T low, T high) {
    range.min = low < range.min ? low : range.min;
    range.max = high > range.max ? high : range.max;
}

/// Makes a level whose bricks have `step` parts of the finer level on each axis.
template <class T>
BrickLevel<T> empty_level(Vec3i parts, int step) {
    BrickLevel<T> level;
    const auto count = [&](int n) { return (n + step - 1) / step; };
    level.size = {count(parts.x), count(parts.y), count(parts.z)};
    level.ranges.resize(std::size_t(level.size.x) * std::size_t(level.size.y) *
                        std::size_t(level.size.z));
    return level;
}

template <class T>
Range<T> range_of_voxels(const VoxelField<T>& field, Vec3i begin, Vec3i last) {
    Range<T> range{*field.at(begin), *field.at(begin)};
    for (int z = begin.z; z <= last.z; ++z)
        for (int y = begin.y; y <= last.y; ++y) {
            const T* row = field.at({begin.x, y, z});
            const int length = last.x - begin.x + 1;
            for (int x = 0; x < length; ++x) include(range, row[x], row[x]);
        }
    return range;
}

template <class T>
Range<T> range_of_bricks(const BrickLevel<T>& fine, Vec3i begin, Vec3i end) {
    Range<T> range = fine.at(begin);
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y)
            for (int x = begin.x; x < end.x; ++x) {
                const Range<T>& part = fine.at({x, y, z});
                include(range, part.min, part.max);
            }
    return range;
}

/// Computes a level's bricks in parallel rows. @param range_at  (first part, one past) → range
template <class T, class RangeAt>
void fill(BrickLevel<T>& level, Vec3i parts, int step, const TaskArena& arena,
          const RangeAt& range_at) {
    const std::int64_t rows = std::int64_t(level.size.y) * level.size.z;
    arena.for_each(rows, 4, [&](std::int64_t row_begin, std::int64_t row_end) {
        for (std::int64_t row = row_begin; row < row_end; ++row) {
            const int y = int(row % level.size.y), z = int(row / level.size.y);
            for (int x = 0; x < level.size.x; ++x) {
                const Vec3i begin{x * step, y * step, z * step};
                const Vec3i end{std::min(begin.x + step, parts.x),
                                std::min(begin.y + step, parts.y),
                                std::min(begin.z + step, parts.z)};
                level.ranges[std::size_t(row) * std::size_t(level.size.x) + std::size_t(x)] =
                    range_at(begin, end);
            }
        }
    });
}

/// The parts of brick b of a level.
Box3i parts_of(Vec3i b, int step, Vec3i parts) {
    const Vec3i begin = step * b;
    return {begin,
            {std::min(begin.x + step, parts.x), std::min(begin.y + step, parts.y),
             std::min(begin.z + step, parts.z)}};
}

template <class T>
Vec3i brick_of(const BrickLevel<T>& level, std::int32_t n) {
    return {n % level.size.x, n / level.size.x % level.size.y, n / level.size.x / level.size.y};
}

/// Lists the numbers of a level's bricks in boxes of bricks, each once.
template <class T>
void list_bricks(const BrickLevel<T>& level, std::span<const Box3i> boxes, const auto& bricks_of,
                 std::vector<std::int32_t>& list) {
    list.clear();
    for (const Box3i& box : boxes) {
        if (is_empty(box)) continue;
        const Box3i bricks = bricks_of(box);
        for (int z = bricks.begin.z; z < bricks.end.z; ++z)
            for (int y = bricks.begin.y; y < bricks.end.y; ++y)
                for (int x = bricks.begin.x; x < bricks.end.x; ++x)
                    list.push_back(x + level.size.x * (y + level.size.y * z));
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

template <class T>
void update_bricks(Bricks<T>& bricks, const VoxelField<T>& field, std::span<const Box3i> boxes,
                   std::vector<std::int32_t>& scratch, const TaskArena& arena) {
    if (bricks.fine.ranges.empty()) return;
    // A voxel on the face between two bricks belongs to both.
    const auto touched = [](const Box3i& voxels, int size, Vec3i count) {
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            box.begin[a] = std::max(voxels.begin[a] - 1, 0) / size;
            box.end[a] = std::min((voxels.end[a] - 1) / size + 1, count[a]);
        }
        return box;
    };
    const auto renew = [&](auto& level, int size, Vec3i parts, int step, const auto& range_at) {
        list_bricks(
            level, boxes, [&](const Box3i& box) { return touched(box, size, level.size); },
            scratch);
        const auto count = std::int64_t(scratch.size());
        arena.for_each(count, 16, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                const std::int32_t n = scratch[std::size_t(i)];
                const Box3i box = parts_of(brick_of(level, n), step, parts);
                level.ranges[std::size_t(n)] = range_at(box.begin, box.end);
            }
        });
    };
    renew(bricks.fine, kFineCells, bricks.cells, kFineCells,
          [&](Vec3i begin, Vec3i end) { return range_of_voxels(field, begin, end); });
    renew(bricks.coarse, kCoarseCells, bricks.fine.size, kCoarseCells / kFineCells,
          [&](Vec3i begin, Vec3i end) { return range_of_bricks(bricks.fine, begin, end); });
}

template <class T>
Bricks<T> make_bricks(const VoxelField<T>& field, const TaskArena& arena) {
    const Vec3i voxels = field.size();
    if (voxels.x < 2 || voxels.y < 2 || voxels.z < 2) return {};
    Bricks<T> bricks;
    bricks.cells = {voxels.x - 1, voxels.y - 1, voxels.z - 1};
    bricks.fine = empty_level<T>(bricks.cells, kFineCells);
    fill(bricks.fine, bricks.cells, kFineCells, arena,
         [&](Vec3i begin, Vec3i end) { return range_of_voxels(field, begin, end); });
    constexpr int kStep = kCoarseCells / kFineCells;
    bricks.coarse = empty_level<T>(bricks.fine.size, kStep);
    fill(bricks.coarse, bricks.fine.size, kStep, arena,
         [&](Vec3i begin, Vec3i end) { return range_of_bricks(bricks.fine, begin, end); });
    return bricks;
}

template Bricks<std::int16_t> make_bricks(const VoxelField<std::int16_t>&, const TaskArena&);
template Bricks<float> make_bricks(const VoxelField<float>&, const TaskArena&);
template void update_bricks(Bricks<std::int16_t>&, const VoxelField<std::int16_t>&,
                            std::span<const Box3i>, std::vector<std::int32_t>&, const TaskArena&);
template void update_bricks(Bricks<float>&, const VoxelField<float>&, std::span<const Box3i>,
                            std::vector<std::int32_t>&, const TaskArena&);

}  // namespace pliant::render
