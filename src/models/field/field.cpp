// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "field/field.h"

#include <algorithm>
#include <bit>
#include <new>
#include <tuple>
#include <utility>

#include "base/memory_budget.h"
#include "volume/boxes.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace pliant {
namespace {

/// ⌊a / b⌋: a shift where possible, as for the usual bricks.
int floor_div(int a, int b) {
    if (std::has_single_bit(unsigned(b))) return a >> std::countr_zero(unsigned(b));
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

constexpr std::size_t kHugePage = std::size_t(2) << 20;
/// The first slabs are small. The system is asked for memory at the next, and every so many.
constexpr std::size_t kSmallSlabs = 6, kSlabsPerLook = 16;

Vec3i bricks_of(Vec3i elements, int brick_size) {
    return {floor_div(elements.x - 1, brick_size) + 1, floor_div(elements.y - 1, brick_size) + 1,
            floor_div(elements.z - 1, brick_size) + 1};
}

std::size_t round_up(std::size_t bytes, std::size_t to) {
    return (bytes + to - 1) / to * to;
}

/// Reserves memory for a number of values, at least doubling the capacity when it grows.
template <class T>
void make_room(std::vector<T>& values, std::size_t count) {
    if (values.capacity() < count) values.reserve(std::max(count, 2 * values.capacity()));
}

}  // namespace

Field::Field(const Grid& grid, int brick_size, bool bounded, BrickLayout layout)
    : m_grid(grid),
      m_size(brick_size),
      m_bounded(bounded),
      m_layout(layout),
      m_index_of(bricks_of(grid.size, brick_size)),
      m_spare_at(bricks_of(grid.size, brick_size)) {}

Vec3i Field::brick_of(Vec3i ijk) const {
    if (m_size == 8) return {ijk.x >> 3, ijk.y >> 3, ijk.z >> 3};  // divisions are slow
    return {floor_div(ijk.x, m_size), floor_div(ijk.y, m_size), floor_div(ijk.z, m_size)};
}

Vec3i Field::element_of(Vec3i brick_coord, int index) const {
    const Vec3i local{index % m_size, index / m_size % m_size, index / (m_size * m_size)};
    return m_size * brick_coord + local;
}

bool Field::is_void(Vec3i ijk) const {
    if (m_bounded && !contains(voxel_box(grid()), ijk)) return true;
    if (m_edits.empty()) return false;
    const BrickEdits* edits = edits_of(brick_of(ijk));
    return edits && ((*edits)[std::size_t(index_in_brick(ijk))] & kVoid);
}

Vec3<Fixed> Field::displacement_at(Vec3i ijk) const {
    const int found = find_brick(brick_of(ijk));
    if (found < 0) return {0, 0, 0};
    const auto index = std::size_t(index_in_brick(ijk));
    const auto& u = brick(found).u;
    return {u[0][index], u[1][index], u[2][index]};
}

int Field::add_brick(Vec3i coord) {
    make_room_for(coord);
    FieldBrick& made = take_brick(coord);
    const int index = m_free_indices.back();
    m_free_indices.pop_back();
    m_bricks[std::size_t(index)] = &made;
    m_index_of.insert(coord, index);
    ++m_resident_count;
    made.serial = ++m_made_count;
    made.neighbours = m_index_of.find_neighbours(coord);
    for (int side = 0; side < 6; ++side) {
        const int neighbour = made.neighbours[std::size_t(side)];
        if (neighbour >= 0) brick_to_write(neighbour).neighbours[std::size_t(side ^ 1)] = index;
    }
    const BrickEdits* edits = edits_of(coord);
    made.edits = edits ? edits->data() : nullptr;
    return index;
}

/// Reserves all memory that a brick needs beside its own, so that neither its creation nor its
/// removal can fail half way.
void Field::make_room_for(Vec3i coord) {
    if (m_free_indices.empty()) {
        make_room(m_free_indices, m_bricks.size() + 1);
        m_bricks.emplace_back();
        m_free_indices.push_back(int(m_bricks.size()) - 1);
    }
    make_room(m_spare, m_spare.size() + std::size_t(m_resident_count) + 1);
    if (m_index_of.is_inside(coord)) return;
    const std::size_t outside = m_index_of.outside_count() + 1;
    m_index_of.reserve_outside(outside);
    m_spare_at.reserve_outside(outside + m_spare_at.outside_count());
}

void Field::place_at_rest(FieldBrick& brick) const {
    for (std::size_t a = 0; a < 3; ++a)
        if (!brick.holds_zeros[a]) std::fill_n(brick.u[a], elements_per_brick(), 0);
    brick.is_unplaced = false;
}

FieldBrick& Field::take_brick(Vec3i coord) {
    const int index = m_spare_at.find(coord);
    FieldBrick& taken = index >= 0        ? take_spare(index)
                        : m_spare.empty() ? carve_brick()
                                          : take_spare(int(m_spare.size()) - 1);
    taken.coord = coord;
    for (int a = 0; a < 3; ++a)
        if (!taken.is_unplaced)
            taken.holds_zeros[std::size_t(a)] = taken.u_min[a] == 0 && taken.u_max[a] == 0;
    taken.is_unplaced = true;
    taken.changed_at = m_clock;
    taken.u_min = taken.u_max = {0, 0, 0};
    begin_brick(taken, index < 0);
    return taken;
}

FieldBrick& Field::take_spare(int index) {
    FieldBrick* last = m_spare.back();
    m_spare.pop_back();
    FieldBrick*& slot = index < int(m_spare.size()) ? m_spare[std::size_t(index)] : last;
    m_spare_at.erase(slot->coord);
    if (slot == last) return *last;
    m_spare_at.erase(last->coord);
    m_spare_at.insert(last->coord, index);
    return *std::exchange(slot, last);
}

void Field::keep_spare(FieldBrick& dropped) {
    m_spare_at.insert(dropped.coord, int(m_spare.size()));
    m_spare.push_back(&dropped);
}

void Field::forget_all_dropped() noexcept {
    for (FieldBrick* brick : m_spare) forget_dropped(*brick);
}

/// Linux would end the process later, when the memory is used. The rest of the step may take half
/// as much again, for its undo.
void Field::look_at_memory() const {
    if (!has_memory_for((kSlabsPerLook + m_slabs.size() / 2) * kHugePage)) throw std::bad_alloc();
}

void Field::take_slab() {
    // Small slabs first: a small push must not allocate much.
    const std::size_t full = std::max<std::size_t>(1, kHugePage / m_layout.arrays);
    const std::size_t count =
        m_slabs.size() < kSmallSlabs ? std::min(full, std::size_t(8) << m_slabs.size()) : full;
    const bool huge = count == full;
    const std::size_t alignment = huge ? kHugePage : kLine;
    const std::size_t bytes = round_up(count * m_layout.arrays, alignment);
    if (m_slabs.size() % kSlabsPerLook == kSmallSlabs) look_at_memory();
    m_slabs.push_back(allocate_aligned<void>(bytes, alignment));
#ifdef MADV_HUGEPAGE
    if (huge) madvise(m_slabs.back().get(), bytes, MADV_HUGEPAGE);
#endif
    m_slab_rest = static_cast<std::byte*>(m_slabs.back().get());
    m_slab_bricks_left = count;
}

FieldBrick& Field::carve_brick() {
    if (m_slab_bricks_left == 0) take_slab();
    FieldBrick& carved = make_brick(m_slab_rest);
    carved.is_unplaced = true;
    m_slab_rest += m_layout.arrays;
    --m_slab_bricks_left;
    return carved;
}

Box3i Field::part_in_grid(Vec3i brick_coord) const {
    Box3i part;
    for (int a = 0; a < 3; ++a) {
        const int first = m_size * brick_coord[a];
        part.begin[a] = std::clamp(-first, 0, m_size);
        part.end[a] = std::clamp(m_grid.size[a] - first, part.begin[a], m_size);
    }
    return part;
}

void Field::update_bounds(FieldBrick& changed) const {
    for (int a = 0; a < 3; ++a) {
        const Fixed* u = changed.u[std::size_t(a)];
        const auto [low, high] = std::minmax_element(u, u + elements_per_brick());
        changed.u_min[a] = *low;
        changed.u_max[a] = *high;
    }
}

const BrickEdits* Field::edits_of(Vec3i brick_coord) const {
    if (m_edits.empty()) return nullptr;
    const auto found = m_edits.find(brick_coord);
    return found == m_edits.end() || found->second.empty() ? nullptr : &found->second;
}

bool Field::is_linked(Vec3i low, int axis) const {
    if (!may_have_gaps()) return true;
    const BrickEdits* edits = m_edits.empty() ? nullptr : edits_of(brick_of(low));
    if (edits && ((*edits)[std::size_t(index_in_brick(low))] & (kCutX << axis))) return false;
    return !is_void(low) && !is_void(low + Vec3i{axis == 0, axis == 1, axis == 2});
}

void Field::set_edits(Vec3i brick_coord, BrickEdits edits) {
    const bool any = std::any_of(edits.begin(), edits.end(), [](auto flags) { return flags != 0; });
    if (any)
        m_edits[brick_coord] = std::move(edits);
    else
        m_edits.erase(brick_coord);
    edits_changed(brick_coord);
}

void Field::prepare_edits(const EditMap& edits) {
    try {
        for (const auto& [coord, flags] : edits) m_edits.try_emplace(coord);
    } catch (...) {
        finish_edits(edits);
        throw;
    }
}

void Field::exchange_edits(EditMap& edits) noexcept {
    for (auto& [coord, flags] : edits) {
        if (std::all_of(flags.begin(), flags.end(), [](auto f) { return f == 0; })) flags.clear();
        m_edits.find(coord)->second.swap(flags);
        edits_changed(coord);
    }
}

void Field::finish_edits(const EditMap& edits) noexcept {
    for (const auto& [coord, flags] : edits)
        if (const auto own = m_edits.find(coord); own != m_edits.end() && own->second.empty())
            m_edits.erase(own);
}

void Field::restore_edits(EditMap& saved) noexcept {
    while (!saved.empty()) {
        // Nodes move between the maps, and room for them is reserved.
        auto node = saved.extract(saved.begin());
        const Vec3i coord = node.key();
        const BrickEdits* now = edits_of(coord);
        if (now ? *now == node.mapped() : node.mapped().empty()) continue;
        m_edits.erase(coord);
        if (!node.mapped().empty()) m_edits.insert(std::move(node));
        edits_changed(coord);
    }
}

void Field::drop_all_edits() noexcept {
    while (!m_edits.empty()) {
        const Vec3i coord = m_edits.begin()->first;
        m_edits.erase(m_edits.begin());
        edits_changed(coord);
    }
}

void Field::edits_changed(Vec3i brick_coord) noexcept {
    count_links_change();
    if (const int index = m_spare_at.find(brick_coord); index >= 0)
        forget_dropped(*m_spare[std::size_t(index)]);
    const int index = find_brick(brick_coord);
    if (index < 0) return;
    FieldBrick& edited = brick_to_write(index);
    const BrickEdits* now = edits_of(brick_coord);
    edited.edits = now ? now->data() : nullptr;
    edited.changed_at = tick();
    follow_edits(edited);
}

void Field::drop_still_bricks() noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)] && is_at_rest(brick(index))) drop_brick(index);
}

void Field::drop_still_bricks(std::span<const int> bricks) noexcept {
    for (const int index : bricks)
        if (m_bricks[std::size_t(index)] && is_at_rest(brick(index))) drop_brick(index);
}

void Field::drop_made_since(std::uint64_t made_count) noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)] && brick(index).serial > made_count &&
            is_at_rest(brick(index)))
            drop_brick(index);
}

void Field::drop_all_bricks() noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)]) drop_brick(index);
}

void Field::drop_brick(int index) noexcept {
    FieldBrick& dropped = *std::exchange(m_bricks[std::size_t(index)], nullptr);
    for (int side = 0; side < 6; ++side) {
        const int neighbour = dropped.neighbours[std::size_t(side)];
        if (neighbour >= 0) brick_to_write(neighbour).neighbours[std::size_t(side ^ 1)] = -1;
    }
    m_index_of.erase(dropped.coord);
    --m_resident_count;
    m_free_indices.push_back(index);
    keep_spare(dropped);
}

std::vector<int> Field::resident_bricks() const {
    std::vector<int> indices;
    indices.reserve(std::size_t(m_resident_count));
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)]) indices.push_back(index);
    std::sort(indices.begin(), indices.end(), [&](int a, int b) {
        const Vec3i p = brick(a).coord, q = brick(b).coord;
        return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
    });
    return indices;
}

std::size_t Field::resident_bytes() const {
    const auto edited = m_edits.size() * std::size_t(elements_per_brick());
    return std::size_t(m_resident_count) * (m_layout.header + m_layout.arrays) + edited;
}

BrickIndex::BrickIndex(Vec3i size) : m_size(size) {
    const std::size_t count = std::max<std::size_t>(1, dense_count(size));
    m_inside.reset(static_cast<int*>(std::calloc(count, sizeof(int))));
    if (!m_inside) throw std::bad_alloc();
}

std::size_t BrickIndex::home_of(Vec3i coord) const {
    const std::uint64_t mixed = std::uint64_t(std::uint32_t(coord.x)) * 0x9E3779B97F4A7C15u ^
                                std::uint64_t(std::uint32_t(coord.y)) * 0xC2B2AE3D27D4EB4Fu ^
                                std::uint64_t(std::uint32_t(coord.z)) * 0x165667B19E3779F9u;
    return std::size_t(mixed ^ mixed >> 32) & (m_slots.size() - 1);
}

int BrickIndex::find_outside(Vec3i coord) const {
    if (m_slots.empty()) return -1;
    for (std::size_t n = home_of(coord);; n = (n + 1) & (m_slots.size() - 1)) {
        if (m_slots[n].brick_plus_one == 0) return -1;
        if (m_slots[n].coord == coord) return m_slots[n].brick_plus_one - 1;
    }
}

std::array<int, 6> BrickIndex::find_neighbours(Vec3i coord) const {
    const auto next = [&](int side) {
        Vec3i there = coord;
        there[side / 2] += side % 2 ? 1 : -1;
        return there;
    };
    std::array<int, 6> found;
    // All are inside if two opposite corners are.
    if (!is_inside(coord - Vec3i{1, 1, 1}) || !is_inside(coord + Vec3i{1, 1, 1})) {
        for (int side = 0; side < 6; ++side) found[std::size_t(side)] = find(next(side));
        return found;
    }
    const int* at = m_inside.get() + index_of(coord);
    const auto row = std::ptrdiff_t(m_size.x), slice = row * m_size.y;
    found = {at[-1] - 1, at[1] - 1, at[-row] - 1, at[row] - 1, at[-slice] - 1, at[slice] - 1};
    return found;
}

void BrickIndex::insert(Vec3i coord, int brick) {
    if (is_inside(coord)) {
        m_inside.get()[index_of(coord)] = brick + 1;
        return;
    }
    reserve_outside(m_outside_count + 1);
    std::size_t n = home_of(coord);
    while (m_slots[n].brick_plus_one != 0) n = (n + 1) & (m_slots.size() - 1);
    m_slots[n] = {coord, brick + 1};
    ++m_outside_count;
}

void BrickIndex::erase(Vec3i coord) {
    if (is_inside(coord)) {
        m_inside.get()[index_of(coord)] = 0;
        return;
    }
    const std::size_t mask = m_slots.size() - 1;
    std::size_t hole = home_of(coord);
    while (m_slots[hole].coord != coord || m_slots[hole].brick_plus_one == 0)
        hole = (hole + 1) & mask;
    // Entries after the hole move up if their search would otherwise end at it.
    for (std::size_t n = (hole + 1) & mask; m_slots[n].brick_plus_one != 0; n = (n + 1) & mask) {
        const std::size_t home = home_of(m_slots[n].coord);
        if (((n - home) & mask) < ((n - hole) & mask)) continue;
        m_slots[hole] = m_slots[n];
        hole = n;
    }
    m_slots[hole].brick_plus_one = 0;
    --m_outside_count;
}

void BrickIndex::grow() {
    std::vector<Slot> old(std::max<std::size_t>(64, 2 * m_slots.size()), Slot{{0, 0, 0}, 0});
    std::swap(old, m_slots);
    for (const Slot& slot : old) {
        if (slot.brick_plus_one == 0) continue;
        std::size_t n = home_of(slot.coord);
        while (m_slots[n].brick_plus_one != 0) n = (n + 1) & (m_slots.size() - 1);
        m_slots[n] = slot;
    }
}

}  // namespace pliant
