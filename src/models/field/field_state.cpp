// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/field_state.h"

#include <algorithm>
#include <mutex>

#include "base/hash.h"

namespace pliant {
namespace {

/// Whether space is inverted, or flat, at a corner of a cell.
bool is_folded(const std::array<Vec3d, 8>& p) {
    for (std::size_t c = 0; c < 8; ++c) {
        const double sign_x = c & 1 ? -1 : 1, sign_y = c & 2 ? -1 : 1, sign_z = c & 4 ? -1 : 1;
        const Vec3d ex = sign_x * (p[c ^ 1] - p[c]);
        const Vec3d ey = sign_y * (p[c ^ 2] - p[c]);
        const Vec3d ez = sign_z * (p[c ^ 4] - p[c]);
        if (dot(ex, cross(ey, ez)) <= 0) return true;
    }
    return false;
}

/// Whether one of a cell's twelve links is cut or one of its corners void: it is then a gap.
bool is_torn(const Field& field, Vec3i lowest) {
    for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 4; ++c) {
            Vec3i e = lowest;
            e[(b + 1) % 3] += c & 1;
            e[(b + 2) % 3] += c >> 1;
            if (!field.is_linked(e, b)) return true;
        }
    return false;
}

void count_edits(const Field& field, DeformationState& state) {
    for (const auto& [coord, edits] : field.all_edits())
        for (const std::uint8_t flags : edits) {
            state.carved_elements += (flags & kVoid) != 0;
            for (const ElementEdit cut : {kCutX, kCutY, kCutZ})
                state.cut_links += (flags & cut) != 0;
        }
}

void look_at_elements(const Field& field, const CellBlock& block, DeformationState& state) {
    const Vec3d scale = voxels_per_unit(field.grid());
    const bool edited = field.may_have_gaps();
    const Vec3i first = block.first_element();
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x) {
                if (const int n = block.index(x, y, z); block.is_moved(n)) {
                    const Vec3<Fixed> u = block.displacement(n);
                    const Vec3d mm{mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
                    state.moved_elements += 1;
                    state.max_movement_mm = std::max(state.max_movement_mm, norm(mm));
                }
                if (!block.is_touched(block.index(x, y, z))) continue;
                if (edited && is_torn(field, first + Vec3i{x, y, z})) continue;
                state.folded_cells +=
                    is_folded(deformed_corners(block, block.corners(x, y, z), scale));
            }
}

std::uint64_t hash_edits(const Field& field) {
    std::uint64_t sum = 0;
    for (const auto& [coord, edits] : field.all_edits())
        for (std::size_t n = 0; n < edits.size(); ++n) {
            if (edits[n] == 0) continue;
            const Vec3i e = field.element_of(coord, int(n));
            Hash64 hash;
            for (const std::int32_t word : {e.x, e.y, e.z, std::int32_t(edits[n])})
                hash.add_word(std::uint32_t(word));
            sum += hash.value();
        }
    return sum;
}

}  // namespace

DeformationState state_of_field(const Field& field, const TaskArena& arena,
                                const VisitBlock& visit) {
    const std::vector<Vec3i> coords = cell_blocks(field);
    DeformationState state;
    std::mutex mutex;
    arena.for_each(std::int64_t(coords.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        CellBlock block;
        DeformationState own;
        for (std::int64_t n = begin; n < end; ++n) {
            block.load(field, coords[std::size_t(n)]);
            look_at_elements(field, block, own);
            if (visit) visit(coords[std::size_t(n)], block);
        }
        const std::lock_guard lock(mutex);
        state.moved_elements += own.moved_elements;
        state.folded_cells += own.folded_cells;
        state.max_movement_mm = std::max(state.max_movement_mm, own.max_movement_mm);
    });
    count_edits(field, state);
    state.resident_bricks = field.resident_brick_count();
    if (state.resident_bricks > 0)
        state.bytes_per_resident_element =
            double(field.resident_bytes()) /
            (double(state.resident_bricks) * field.elements_per_brick());
    return state;
}

Box3i moved_box(const Field& field) {
    Box3i box{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (const int index : field.resident_bricks()) {
        const FieldBrick& brick = field.brick(index);
        for (int n = 0; n < field.elements_per_brick(); ++n) {
            const auto i = std::size_t(n);
            if ((brick.u[0][i] | brick.u[1][i] | brick.u[2][i]) == 0) continue;
            const Vec3i e = field.element_of(brick.coord, n);
            for (int a = 0; a < 3; ++a) {
                box.begin[a] = std::min(box.begin[a], e[a]);
                box.end[a] = std::max(box.end[a], e[a] + 1);
            }
        }
    }
    return is_empty(box) ? Box3i{} : box;
}

std::uint64_t hash_state(const Field& field) {
    std::uint64_t sum = 0;
    field.for_each_brick([&](const FieldBrick& brick) {  // a sum, independent of the order
        for (int n = 0; n < field.elements_per_brick(); ++n) {
            const auto i = std::size_t(n);
            const Vec3<Fixed> u{brick.u[0][i], brick.u[1][i], brick.u[2][i]};
            if (u == Vec3<Fixed>{0, 0, 0}) continue;
            const Vec3i e = field.element_of(brick.coord, n);
            Hash64 hash;
            for (const std::int32_t word : {e.x, e.y, e.z, u.x, u.y, u.z})
                hash.add_word(std::uint32_t(word));
            sum += hash.value();
        }
    });
    return sum + hash_edits(field);
}

}  // namespace pliant
