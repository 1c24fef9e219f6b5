// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/open_voxels.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace pliant {
namespace {

constexpr Box3i kNothing{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};

constexpr RowBits kEachByte = 0x0101010101010101u;

RowBits low_bits(int count) {
    return (RowBits(1) << count) - 1;
}

/// std::popcount is a call where the processor isn't known to count bits.
int count_of(RowBits bits) {
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    return int(((bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu) * kEachByte >> 56);
}

void open_row(Open* open, int count, RowBits bits) {
    // Eight bits become eight bytes: byte i keeps bit i of its copy, and any bit of it becomes 1.
    static_assert(std::endian::native == std::endian::little);
    for (; count >= 8; count -= 8, open += 8, bits >>= 8) {
        const RowBits kept = (bits & 0xff) * kEachByte & 0x8040201008040201u;
        const RowBits bytes = (kept + 0x7f7f7f7f7f7f7f7fu) >> 7 & kEachByte;
        std::memcpy(open, &bytes, 8);
    }
    for (int x = 0; x < count; ++x) open[x] = bits >> x & 1 ? Open::Yes : Open::No;
}

/// Whether any has one of some bits.
bool any_in_row(const Open* open, int count, Open bits) {
    RowBits any = 0, eight;
    for (; count >= 8; count -= 8, open += 8) {
        std::memcpy(&eight, open, 8);
        any |= eight;
    }
    for (; count > 0; --count) any |= RowBits(*open++);
    return (any & RowBits(bits) * kEachByte) != 0;
}

/// Copies a row. Most are eight voxels long, which the compiler may know.
template <class T>
void copy_row(const T* from, int count, T* to) {
    if (count == 8)
        std::memcpy(to, from, 8 * sizeof(T));
    else
        std::copy_n(from, count, to);
}

/// Puts rows of a brick back that hold what nobody else will write again.
/// @param before  at least the voxels that the last update could change
/// @param now  those that this one can
void put_back(const CellTarget& target, const Volume& original, const Box3i& box,
              const RowBits* before, const RowBits* now, int brick_size) {
    const RowBits all = low_bits(box.end.x - box.begin.x);
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            const T* from = voxels.data();
            for_each_row(box, [&](Vec3i p) {
                const Vec3i local = p - box.begin;
                const int row = local.y + brick_size * local.z;
                if ((before[row] & ~now[row] & all) == 0) return;
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

/// Whether a box goes on where another one ends, along x.
bool goes_on(const Box3i& box, const Box3i& before) {
    return !is_empty(before) && box.begin.x == before.end.x && box.begin.y == before.begin.y &&
           box.begin.z == before.begin.z;
}

void open_all(const CellTarget& target, const Box3i& box) {
    static_assert(int(Open::Yes) == 1 && sizeof(Open) == 1);
    const auto count = std::size_t(box.end.x - box.begin.x);
    for_each_row(box, [&](Vec3i p) { std::memset(open_at(target, p), 1, count); });
}

bool any_in_box(const CellTarget& target, const Box3i& box, Open bits) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            if (any_in_row(open_at(target, {box.begin.x, y, z}), box.end.x - box.begin.x, bits))
                return true;
    return false;
}

/// The box around what has bits along each axis, from a place on.
Box3i around(Vec3i first, RowBits x, RowBits y, RowBits z) {
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

}  // namespace

void open_changeable(const ScatterJob& job, const CellTarget& target,
                     std::span<DirtyBrick> bricks) {
    const int size = job.lattice.brick_size();
    std::array<RowBits, 32 * 32> rows, before;
    // Neighbours in a row are opened together: their rows lie side by side.
    Box3i run{};
    for (DirtyBrick& brick : bricks) {
        const Box3i box = box_of_brick(job.original.grid, brick.coord, size);
        const int width = box.end.x - box.begin.x;
        const RowBits all = low_bits(width);
        const Share share = job.touched.changeable_rows(brick.coord, rows.data());
        brick.opened = 0;
        brick.open = kNothing;
        if (share == Share::All) {
            if (goes_on(box, run)) {
                run.end.x = box.end.x;
            } else {
                open_all(target, run);
                run = box;
            }
            const Vec3i n = box.end - box.begin;
            brick.opened = std::int64_t(dense_count(n));
            brick.open = box;
            continue;
        }
        if (brick.was_changed) {
            job.touched_before.bound_changeable(brick.coord, before.data());
            put_back(target, job.original, box, before.data(), rows.data(), size);
        }
        if (share == Share::None) continue;
        RowBits in_x = 0, in_y = 0, in_z = 0;
        for_each_row(box, [&](Vec3i p) {
            const Vec3i local = p - box.begin;
            const RowBits bits = rows[std::size_t(local.y + size * local.z)] & all;
            if (!bits) return;
            open_row(open_at(target, p), width, bits);
            brick.opened += count_of(bits);
            in_x |= bits, in_y |= RowBits(1) << local.y, in_z |= RowBits(1) << local.z;
        });
        if (in_x) brick.open = around(box.begin, in_x, in_y, in_z);
    }
    open_all(target, run);
}

void open_again(const ScatterJob& job, const CellTarget& target, std::span<const Box3i> boxes) {
    const int size = job.lattice.brick_size();
    std::array<RowBits, 32 * 32> rows;
    Vec3i last{-1, -1, -1};
    bool can_change = false;
    for (const Box3i& box : boxes) {
        const Vec3i brick = job.lattice.brick_of(box.begin);
        if (brick != last)
            can_change = job.dirty[dense_index(brick, job.bricks)] &&
                         job.touched.changeable_rows(brick, rows.data()) != Share::None;
        last = brick;
        if (!can_change) continue;
        for_each_in(box, [&](Vec3i p) {
            const Vec3i local = p - size * brick;
            if (rows[std::size_t(local.y + size * local.z)] >> local.x & 1)
                put(*open_at(target, p), Open::Shared);
        });
    }
}

void close_taken(const CellTarget& target, std::span<const DirtyBrick> bricks) {
    for (const DirtyBrick& brick : bricks)
        for_each_in(brick.open, [&](Vec3i p) {
            Open& open = *open_at(target, p);
            if (open == Open::Taken) open = Open::No;
        });
}

bool any_open(const CellTarget& target, const Box3i& box) {
    return any_in_box(target, box, Open::Yes);
}
bool any_shared(const CellTarget& target, const Box3i& box) {
    return any_in_box(target, box, Open::Taken);  // the bit that makes it shared
}

void find_open(const ScatterJob& job, const CellTarget& target, std::span<DirtyBrick> bricks) {
    const int size = job.lattice.brick_size();
    const auto whole = [&](const DirtyBrick& brick) {
        return box_of_brick(job.original.grid, brick.coord, size);
    };
    // Neighbours in a row are looked at together: their rows lie side by side.
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
            if (!any_in_row(open, width, Open::Yes)) return;
            for (int x = 0; x < width; ++x)
                if (is_open(open[x])) include(bricks[first + std::size_t(x / size)].open, p, x);
        });
    }
}

std::int64_t fill_gaps(const CellTarget& target, std::span<const DirtyBrick> bricks) {
    std::int64_t gaps = 0;
    for (const DirtyBrick& brick : bricks) {
        if (is_empty(brick.open)) continue;
        for_each_in(brick.open, [&](Vec3i p) {
            const std::ptrdiff_t at = voxel_at(target, p);
            if (!is_open(target.open[at])) return;
            target.open[at] = Open::No;
            if (target.voxels16)
                target.voxels16[at] = std::int16_t(std::lrint(kAirHu));
            else
                target.voxels32[at] = float(kAirHu);
            ++gaps;
        });
    }
    return gaps;
}

bool OpenBoxes::list(std::span<const DirtyBrick> dirty, Vec3i bricks, int brick_size) {
    m_brick_size = brick_size;
    m_boxes.clear();
    for (const std::size_t place : m_set) m_at[place] = -1;
    m_set.clear();
    if (m_at.size() != dense_count(bricks)) m_at.assign(dense_count(bricks), -1);
    m_bricks = bricks;
    for (const DirtyBrick& brick : dirty) {
        if (is_empty(brick.open)) continue;
        const std::size_t place = dense_index(brick.coord, bricks);
        m_set.push_back(place);
        m_at[place] = std::int32_t(m_boxes.size());
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
