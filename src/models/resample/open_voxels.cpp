// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/open_voxels.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/byte_order.h"

namespace pliant {
namespace {

constexpr Box3i kNothing{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};

constexpr RowBits kEachByte = 0x0101010101010101u;

/// @param yes  new state of voxels whose bit is set; others can't change
void open_row(Open* open, int count, RowBits bits, Open yes) {
    // Eight bits become eight bytes: byte i keeps bit i of its copy, and a set bit becomes 1.
    for (; count >= 8; count -= 8, open += 8, bits >>= 8) {
        const RowBits kept = (bits & 0xff) * kEachByte & 0x8040201008040201u;
        const RowBits bytes =
            little_endian(((kept + 0x7f7f7f7f7f7f7f7fu) >> 7 & kEachByte) * RowBits(yes));
        std::memcpy(open, &bytes, 8);
    }
    for (int x = 0; x < count; ++x) open[x] = bits >> x & 1 ? yes : Open::Never;
}

/// Whether any voxel of a row has one of some bits.
bool any_in_row(const Open* open, int count, Open bits) {
    RowBits any = 0, eight;
    for (; count >= 8; count -= 8, open += 8) {
        std::memcpy(&eight, open, 8);
        any |= eight;
    }
    for (; count > 0; --count) any |= RowBits(*open++);
    return (any & RowBits(bits) * kEachByte) != 0;
}

/// Copies a row. Most are eight voxels long, a compile-time constant.
template <class T>
void copy_row(const T* from, int count, T* to) {
    if (count == 8)
        std::memcpy(to, from, 8 * sizeof(T));
    else
        std::copy_n(from, count, to);
}

/// Restores rows of a brick with voxels that no cell will write again.
/// @param before  voxels that the last update could change. @param now  voxels that this one can
///                change
template <class Size>
void put_back(const CellTarget& target, const Volume& original, const Box3i& box,
              const BitLayout<Size>& layout, const BitWord* before, const BitWord* now) {
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            const T* from = voxels.data();
            for_each_row(box, [&](Vec3i p) {
                const Vec3i local = p - box.begin;
                if (!(layout.row(before, local.y, local.z) & ~layout.row(now, local.y, local.z)))
                    return;
                const std::size_t at = voxel_index(original.grid, p);
                const int count = box.end.x - box.begin.x;
                if constexpr (std::is_integral_v<T>)
                    copy_row(from + at, count, target.voxels16 + at);
                else
                    copy_row(from + at, count, target.voxels32 + at);
            });
        },
        original.voxels);
}

/// Clears the bits of voxels beyond the scan. @param n  size of the brick's part inside of it
template <class Size>
void clip(const BitLayout<Size>& layout, Vec3i n, BitWord* bits) {
    const int size = layout.size;
    if (n == Vec3i{size, size, size}) return;
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y) {
            const RowBits kept = y < n.y && z < n.z ? low_bits(n.x) : 0;
            if (layout.has_layers())
                bits[z] &= ~((low_bits(size) & ~kept) << y * size);
            else
                bits[y + size * z] &= kept;
        }
}

/// Whether a box continues another one along x.
bool goes_on(const Box3i& box, const Box3i& before) {
    return !is_empty(before) && box.begin.x == before.end.x && box.begin.y == before.begin.y &&
           box.begin.z == before.begin.z;
}

bool any_in_box(const CellTarget& target, const Box3i& box, Open bits) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            if (any_in_row(open_at(target, {box.begin.x, y, z}), box.end.x - box.begin.x, bits))
                return true;
    return false;
}

/// Box around a brick's set bits. @pre there are some
template <class Size>
Box3i around(const BitLayout<Size>& layout, const BitWord* bits, Vec3i first) {
    const int size = layout.size, n = layout.words_per_layer();
    std::array<BitWord, kLargestBrick> layer{};  // or of all layers
    RowBits x = 0, y = 0, z = 0;
    for (int i = 0; i < size; ++i) {
        BitWord any = 0;
        for (int w = 0; w < n; ++w)
            any |= bits[w + n * i], layer[std::size_t(w)] |= bits[w + n * i];
        z |= RowBits(any != 0) << i;
    }
    for (int i = 0; i < size; ++i) {
        const RowBits row = layout.row(layer.data(), i, 0);
        x |= row, y |= RowBits(row != 0) << i;
    }
    const Vec3i low{std::countr_zero(x), std::countr_zero(y), std::countr_zero(z)};
    const Vec3i high{int(std::bit_width(x)), int(std::bit_width(y)), int(std::bit_width(z))};
    return {first + low, first + high};
}

/// Adds voxel x of a row that begins at p.
void include(Box3i& box, Vec3i p, int x) {
    box.begin = {std::min(box.begin.x, p.x + x), std::min(box.begin.y, p.y),
                 std::min(box.begin.z, p.z)};
    box.end = {std::max(box.end.x, p.x + x + 1), std::max(box.end.y, p.y + 1),
               std::max(box.end.z, p.z + 1)};
}

/// @param map  state and bits of the brick, which are replaced
template <class Size>
void open_brick(const ScatterJob& job, const CellTarget& target, const BitLayout<Size>& layout,
                OpenMap& map, DirtyBrick& brick) {
    const int size = layout.size, words = layout.words();
    AnyBrickBits now_bits;
    BitWord* now = now_bits.data();
    const Box3i box = box_of_brick(job.original.grid, brick.coord, size);
    const std::size_t index = dense_index(brick.coord, job.bricks);
    OpenMap::State& state = map.state(index);
    const Share share = job.touched.changeable(brick.coord, now);
    brick.opened = 0;
    brick.open = kNothing;
    brick.was_changed = state != OpenMap::State::AsScan;
    if (share == Share::None && !brick.was_changed) return;
    clip(layout, box.end - box.begin, now);
    BitWord* before = map.bits(index);
    if (brick.was_changed && share != Share::All)
        put_back(target, job.original, box, layout, before, now);
    const bool is_open = state == OpenMap::State::Open;
    if (!is_open || !std::equal(now, now + words, before))
        for_each_row(box, [&](Vec3i p) {
            const Vec3i local = p - box.begin;
            const RowBits row = layout.row(now, local.y, local.z);
            if (row != (is_open ? layout.row(before, local.y, local.z) : 0))
                open_row(open_at(target, p), box.end.x - box.begin.x, row, target.turn.yes());
        });
    for (int w = 0; w < words; ++w) brick.opened += count_of(before[w] = now[w]);
    state = brick.opened ? OpenMap::State::Open : OpenMap::State::AsScan;
    if (brick.opened) brick.open = around(layout, now, box.begin);
}

}  // namespace

void open_changeable(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                     std::span<DirtyBrick> bricks) {
    with_bit_layout(job.field.brick_size(), [&](auto layout) {
        for (DirtyBrick& brick : bricks) open_brick(job, target, layout, map, brick);
    });
}

void open_again(const ScatterJob& job, const CellTarget& target, OpenMap& map,
                std::span<const Box3i> boxes) {
    const BitLayout<int> layout{job.field.brick_size()};
    for (const Box3i& box : boxes) {
        const Vec3i brick = job.field.brick_of(box.begin);
        const std::size_t index = dense_index(brick, job.bricks);
        if (map.state(index) != OpenMap::State::Open) continue;
        for_each_in(box, [&](Vec3i p) {
            const Vec3i local = p - layout.size * brick;
            if (layout.row(map.bits(index), local.y, local.z) >> local.x & 1)
                put(*open_at(target, p), target.turn.shared());
        });
    }
}

void close_taken(const CellTarget& target, std::span<const DirtyBrick> bricks) {
    for (const DirtyBrick& brick : bricks)
        for_each_in(brick.open, [&](Vec3i p) {
            Open& open = *open_at(target, p);
            if (open == target.turn.taken()) open = target.turn.no();
        });
}

bool any_open(const CellTarget& target, const Box3i& box) {
    return any_in_box(target, box, target.turn.yes());
}
bool any_shared(const CellTarget& target, const Box3i& box) {
    return any_in_box(target, box, Open::Several);
}

void find_open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks) {
    const int size = job.field.brick_size();
    const auto whole = [&](const DirtyBrick& brick) {
        return box_of_brick(job.original.grid, brick.coord, size);
    };
    // Adjacent bricks of a row are processed together: their rows are contiguous.
    for (std::size_t first = 0, end; first < bricks.size(); first = end) {
        end = first + 1;
        if (is_empty(bricks[first].open)) continue;
        Box3i run = whole(bricks[first]);
        for (; end < bricks.size() && !is_empty(bricks[end].open); ++end) {
            const Box3i next = whole(bricks[end]);
            if (!goes_on(next, run)) break;
            run.end.x = next.end.x;
        }
        for (DirtyBrick& brick : bricks.subspan(first, end - first)) brick.open = kNothing;
        for_each_row(run, [&](Vec3i p) {
            const Open* open = open_at(target, p);
            const int width = run.end.x - run.begin.x;
            if (!any_in_row(open, width, target.turn.yes())) return;
            for (int x = 0; x < width; ++x)
                if (target.turn.is_open(open[x]))
                    include(bricks[first + std::size_t(x / size)].open, p, x);
        });
    }
}

std::int64_t fill_gaps(const CellTarget& target, std::span<const DirtyBrick> bricks) {
    std::int64_t gaps = 0;
    for (const DirtyBrick& brick : bricks) {
        if (is_empty(brick.open)) continue;
        for_each_in(brick.open, [&](Vec3i p) {
            const std::ptrdiff_t at = voxel_at(target, p);
            if (!target.turn.is_open(target.open[at])) return;
            target.open[at] = target.turn.no();
            if (target.voxels16)
                target.voxels16[at] = std::int16_t(std::lrint(target.background));
            else
                target.voxels32[at] = target.background;
            ++gaps;
        });
    }
    return gaps;
}

bool OpenBoxes::list(std::span<const DirtyBrick> dirty, Vec3i bricks, int brick_size) {
    m_brick_size = brick_size;
    m_boxes.clear();
    for (const std::size_t index : m_set) m_at[index] = -1;
    m_set.clear();
    if (m_at.size() != dense_count(bricks)) m_at.assign(dense_count(bricks), -1);
    m_bricks = bricks;
    for (const DirtyBrick& brick : dirty) {
        if (is_empty(brick.open)) continue;
        const std::size_t index = dense_index(brick.coord, bricks);
        m_set.push_back(index);
        m_at[index] = std::int32_t(m_boxes.size());
        m_boxes.push_back(brick.open);
    }
    return !m_boxes.empty();
}

void OpenBoxes::within(const Box3i& voxels, std::vector<Box3i>& parts) const {
    parts.clear();
    if (is_empty(voxels)) return;
    for_each_in(bricks_of(voxels, m_brick_size), [&](Vec3i brick) {
        const std::int32_t at = m_at[dense_index(brick, m_bricks)];
        if (at < 0) return;
        const Box3i part = overlap(m_boxes[std::size_t(at)], voxels);
        if (!is_empty(part)) parts.push_back(part);
    });
}

}  // namespace pliant
