// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/check.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "chainmail/cell_block.h"
#include "core/hash.h"

namespace pliant {
namespace {

/// By how much a link is outside of its limits [mm].
double violation_mm(const ElementLimits& low, const ElementLimits& high, int axis, int b,
                    double spacing_mm, double difference_mm) {
    const auto mean = [&](Vec3d ElementLimits::*field) {
        return spacing_mm * ((low.*field)[b] + (high.*field)[b]) / 2;
    };
    if (b != axis) return std::abs(difference_mm) - mean(&ElementLimits::shear);
    return std::max(difference_mm - mean(&ElementLimits::stretch),
                    -difference_mm - mean(&ElementLimits::compress));
}

/// A block's elements and those that its links lead to.
struct Elements {
    std::vector<ElementLimits> limits;  ///< by CellBlock::index
    std::vector<bool> is_void;
};

/// Calls visit(low, high, b, n) for the links along b from a block's elements up where an end
/// moved; n is the lower end's index in its brick.
template <class Visit>
void for_each_moved_link(const CellBlock& block, const Visit& visit) {
    int n = 0;
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x, ++n)
                for (int b = 0; b < 3; ++b) {
                    const int low = block.index(x, y, z);
                    const int high = block.index(x + (b == 0), y + (b == 1), z + (b == 2));
                    if (block.is_moved(low) || block.is_moved(high)) visit(low, high, b, n);
                }
}

/// Limits straight from the law, looked up only where something moved.
Elements elements_of(const Lattice& lattice, const LimitsAt& limits_at, const CellBlock& block) {
    Elements elements;
    const int last = block.size();
    const auto count = std::size_t(block.index(last, last, last)) + 1;
    std::vector<bool> is_needed(count);
    for_each_moved_link(block, [&](int low, int high, int, int) {
        is_needed[std::size_t(low)] = is_needed[std::size_t(high)] = true;
    });
    elements.limits.resize(count);
    elements.is_void.resize(count);
    for (int z = 0; z <= last; ++z)
        for (int y = 0; y <= last; ++y)
            for (int x = 0; x <= last; ++x) {
                const auto n = std::size_t(block.index(x, y, z));
                if (!is_needed[n]) continue;
                const Vec3i e = block.first_element() + Vec3i{x, y, z};
                elements.limits[n] = limits_at(e);
                elements.is_void[n] = lattice.is_void(e);
            }
    return elements;
}

struct Checked {
    double worst_mm = 0;
    std::int64_t excused = 0;
};

/// A link outside of its limits is excused up to what it was when the materials changed.
void check_link(Checked& checked, double violation, Vec3i coord, int index, int b, int a,
                Fixed difference, const Allowance* allowance) {
    const Fixed excused = violation > 0 && allowance ? allowance->excused(coord, index, b, a) : 0;
    if (excused != 0 && (excused > 0) == (difference > 0)) {
        checked.excused += 1;
        violation = std::abs(mm_from_units(difference)) - std::abs(mm_from_units(excused));
    }
    checked.worst_mm = std::max(checked.worst_mm, violation);
}

Checked check_links(const Lattice& lattice, Vec3i coord, const CellBlock& block,
                    const LimitsAt& limits_at, const Allowance* allowance) {
    Checked checked;
    const Elements elements = elements_of(lattice, limits_at, block);
    const BrickEdits* edits = lattice.edits_of(coord);
    for_each_moved_link(block, [&](int low, int high, int b, int n) {
        const auto from = std::size_t(low), to = std::size_t(high);
        if (elements.is_void[from] || elements.is_void[to]) return;
        if (edits && ((*edits)[std::size_t(n)] & (kCutX << b))) return;
        for (int a = 0; a < 3; ++a) {
            const Fixed difference = block.displacement(high)[a] - block.displacement(low)[a];
            const double violation =
                violation_mm(elements.limits[from], elements.limits[to], a, b,
                             lattice.grid().spacing_mm[b], mm_from_units(difference));
            check_link(checked, violation, coord, n, b, a, difference, allowance);
        }
    });
    return checked;
}

/// A cell is folded if space is turned inside out, or flat, at one of its corners.
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

/// Whether one of a cell's twelve links is cut or one of its corners void: it is a gap then.
bool is_torn(const Lattice& lattice, Vec3i lowest) {
    for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 4; ++c) {
            Vec3i e = lowest;
            e[(b + 1) % 3] += c & 1;
            e[(b + 2) % 3] += c >> 1;
            if (!lattice.is_linked(e, b)) return true;
        }
    return false;
}

void count_edits(const Lattice& lattice, LatticeState& state) {
    for (const auto& [coord, edits] : lattice.all_edits())
        for (const std::uint8_t flags : edits) {
            state.carved_elements += (flags & kVoid) != 0;
            for (const ElementEdit cut : {kCutX, kCutY, kCutZ})
                state.cut_links += (flags & cut) != 0;
        }
}

void look_at_elements(const Lattice& lattice, const CellBlock& block, LatticeState& state) {
    const Vec3d scale = voxels_per_unit(lattice.grid());
    const bool edited = lattice.may_have_gaps();
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
                if (edited && is_torn(lattice, first + Vec3i{x, y, z})) continue;
                state.folded_cells +=
                    is_folded(deformed_corners(block, block.corners(x, y, z), scale));
            }
}

}  // namespace

LatticeState check_lattice(const Lattice& lattice, const LimitsAt& limits_at,
                           const TaskArena& arena, const Allowance* allowance) {
    const std::vector<Vec3i> coords = cell_blocks(lattice);
    LatticeState state;
    std::mutex mutex;
    arena.for_each(std::int64_t(coords.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        CellBlock block;
        LatticeState own;
        for (std::int64_t n = begin; n < end; ++n) {
            block.load(lattice, coords[std::size_t(n)]);
            look_at_elements(lattice, block, own);
            const Checked checked =
                check_links(lattice, coords[std::size_t(n)], block, limits_at, allowance);
            own.max_violation_mm = std::max(own.max_violation_mm, checked.worst_mm);
            own.excused_links += checked.excused;
        }
        const std::lock_guard lock(mutex);
        state.moved_elements += own.moved_elements;
        state.folded_cells += own.folded_cells;
        state.excused_links += own.excused_links;
        state.max_movement_mm = std::max(state.max_movement_mm, own.max_movement_mm);
        state.max_violation_mm = std::max(state.max_violation_mm, own.max_violation_mm);
    });
    count_edits(lattice, state);
    state.resident_bricks = lattice.resident_brick_count();
    if (state.resident_bricks > 0)
        state.bytes_per_resident_element =
            double(lattice.resident_bytes()) /
            (double(state.resident_bricks) * lattice.elements_per_brick());
    return state;
}

Box3i moved_box(const Lattice& lattice) {
    Box3i box{{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (const int index : lattice.resident_bricks()) {
        const Brick& brick = lattice.brick(index);
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const auto i = std::size_t(n);
            if ((brick.u[0][i] | brick.u[1][i] | brick.u[2][i]) == 0) continue;
            const Vec3i e = lattice.element_of(brick.coord, n);
            for (int a = 0; a < 3; ++a) {
                box.begin[a] = std::min(box.begin[a], e[a]);
                box.end[a] = std::max(box.end[a], e[a] + 1);
            }
        }
    }
    return is_empty(box) ? Box3i{} : box;
}

namespace {

std::uint64_t hash_edits(const Lattice& lattice) {
    std::uint64_t sum = 0;
    for (const auto& [coord, edits] : lattice.all_edits())
        for (std::size_t n = 0; n < edits.size(); ++n) {
            if (edits[n] == 0) continue;
            const Vec3i e = lattice.element_of(coord, int(n));
            Hash64 hash;
            for (const std::int32_t word : {e.x, e.y, e.z, std::int32_t(edits[n])})
                hash.add_word(std::uint32_t(word));
            sum += hash.value();
        }
    return sum;
}

}  // namespace

std::uint64_t hash_state(const Lattice& lattice) {
    std::uint64_t sum = 0;
    lattice.for_each_brick([&](const Brick& brick) {  // a sum: the same in any order
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const auto i = std::size_t(n);
            const Vec3<Fixed> u{brick.u[0][i], brick.u[1][i], brick.u[2][i]};
            if (u == Vec3<Fixed>{0, 0, 0}) continue;
            const Vec3i e = lattice.element_of(brick.coord, n);
            Hash64 hash;
            for (const std::int32_t word : {e.x, e.y, e.z, u.x, u.y, u.z})
                hash.add_word(std::uint32_t(word));
            sum += hash.value();
        }
    });
    return sum + hash_edits(lattice);
}

}  // namespace pliant
