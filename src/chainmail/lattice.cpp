// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <tuple>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace pliant {
namespace {

/// ⌊a / b⌋: a shift where it can be one, as for the usual bricks.
int floor_div(int a, int b) {
    if (std::has_single_bit(unsigned(b))) return a >> std::countr_zero(unsigned(b));
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

constexpr std::size_t kHugePage = std::size_t(2) << 20;

Vec3i bricks_of(Vec3i elements, int brick_size) {
    return {floor_div(elements.x - 1, brick_size) + 1, floor_div(elements.y - 1, brick_size) + 1,
            floor_div(elements.z - 1, brick_size) + 1};
}

constexpr std::size_t kLine = 64;  ///< of the caches, and alignment of arrays [bytes]

std::size_t round_up(std::size_t bytes, std::size_t to) {
    return (bytes + to - 1) / to * to;
}

/// Room for so many values, at least doubled where it has to grow.
template <class T>
void make_room(std::vector<T>& values, std::size_t count) {
    if (values.capacity() < count) values.reserve(std::max(count, 2 * values.capacity()));
}

}  // namespace

Lattice::Lattice(const Volume& volume, MaterialMap materials, int brick_size, bool bounded)
    : m_volume(volume),
      m_materials(std::move(materials)),
      m_size(brick_size),
      m_bounded(bounded),
      m_index_of(bricks_of(volume.grid.size, brick_size)),
      m_spare_at(bricks_of(volume.grid.size, brick_size)) {
    for (int axis = 0; axis < 3; ++axis) {
        const int s = stride(axis), t = stride((axis + 1) % 3), v = stride((axis + 2) % 3);
        for (int q = 0; q < m_size; ++q) {
            for (int p = 0; p < m_size; ++p) {
                m_faces[std::size_t(2 * axis)].push_back(p * t + q * v);
                m_faces[std::size_t(2 * axis + 1)].push_back(p * t + q * v + (m_size - 1) * s);
            }
        }
    }
}

Vec3i Lattice::brick_of(Vec3i ijk) const {
    if (m_size == 8) return {ijk.x >> 3, ijk.y >> 3, ijk.z >> 3};  // divisions take their time
    return {floor_div(ijk.x, m_size), floor_div(ijk.y, m_size), floor_div(ijk.z, m_size)};
}

Vec3i Lattice::element_of(Vec3i brick_coord, int index) const {
    const Vec3i local{index % m_size, index / m_size % m_size, index / (m_size * m_size)};
    return m_size * brick_coord + local;
}

MaterialId Lattice::material_at(Vec3i ijk) const {
    return is_void(ijk) ? kVoidMaterial : m_materials.at(ijk);
}

bool Lattice::is_void(Vec3i ijk) const {
    if (m_bounded && !contains(voxel_box(grid()), ijk)) return true;
    if (m_edits.empty()) return false;
    const BrickEdits* edits = edits_of(brick_of(ijk));
    return edits && ((*edits)[std::size_t(index_in_brick(ijk))] & kVoid);
}

Vec3<Fixed> Lattice::displacement_at(Vec3i ijk) const {
    const int found = find_brick(brick_of(ijk));
    if (found < 0) return {0, 0, 0};
    const auto index = std::size_t(index_in_brick(ijk));
    const auto& u = brick(found).u;
    return {u[0][index], u[1][index], u[2][index]};
}

int Lattice::find_brick(Vec3i coord) const {
    return m_index_of.find(coord);
}

int Lattice::ensure_brick(Vec3i coord) {
    if (const int found = find_brick(coord); found >= 0) return found;
    const int index = add_brick(coord);
    Brick& made = brick(index);
    if (made.is_blank) fill_in(made);
    place_at_rest(made);
    return index;
}

int Lattice::ensure_blank_brick(Vec3i coord) {
    if (const int found = find_brick(coord); found >= 0) return found;
    return add_brick(coord);
}

int Lattice::add_brick(Vec3i coord) {
    make_room_for(coord);
    std::unique_ptr<Brick> taken = take_brick(coord);
    const int index = m_free_indices.back();
    m_free_indices.pop_back();
    m_bricks[std::size_t(index)] = std::move(taken);
    m_index_of.insert(coord, index);
    ++m_resident_count;
    Brick& made = brick(index);
    made.serial = ++m_made_count;
    made.neighbours = m_index_of.find_neighbours(coord);
    for (int side = 0; side < 6; ++side) {
        const int neighbour = made.neighbours[std::size_t(side)];
        if (neighbour >= 0) brick(neighbour).neighbours[std::size_t(side ^ 1)] = index;
    }
    const BrickEdits* edits = edits_of(coord);
    made.edits = edits ? edits->data() : nullptr;
    return index;
}

/// All memory that a brick needs beside its own, so that neither making nor dropping it can fail
/// half way.
void Lattice::make_room_for(Vec3i coord) {
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

void Lattice::place_at_rest(Brick& brick) const {
    for (std::size_t a = 0; a < 3; ++a)
        if (!brick.holds_zeros[a]) std::fill_n(brick.u[a], elements_per_brick(), 0);
    brick.is_unplaced = false;
}

void Lattice::fill_in(Brick& brick) const {
    const bool is_one = fill_materials(brick);
    brick.least_movement = m_materials.table().movements()[brick.material[0]];
    if (is_one)
        brick.traits = traits_of_one(brick);
    else
        look_at_materials(brick);
    brick.is_blank = false;
}

void Lattice::fetch_early(const Brick& brick) const {
    if (brick.is_blank) m_materials.fetch_early(m_size * brick.coord, part_in_scan(brick.coord));
}

bool Lattice::is_beyond_border(Vec3i brick_coord) const {
    if (!m_bounded) return false;
    for (int a = 0; a < 3; ++a) {
        if (brick_coord[a] < 0 || m_size * brick_coord[a] >= grid().size[a]) return true;
    }
    return false;
}

ElementRef Lattice::ensure_element(Vec3i ijk) {
    return {ensure_brick(brick_of(ijk)), index_in_brick(ijk)};
}

std::unique_ptr<Brick> Lattice::take_brick(Vec3i coord) {
    const int place = m_spare_at.find(coord);
    std::unique_ptr<Brick> taken = place >= 0        ? take_spare(place)
                                   : m_spare.empty() ? carve_brick()
                                                     : take_spare(int(m_spare.size()) - 1);
    if (place < 0) {
        taken->coord = coord;
        taken->is_blank = true;
    }
    for (int a = 0; a < 3; ++a)
        if (!taken->is_unplaced)
            taken->holds_zeros[std::size_t(a)] = taken->u_min[a] == 0 && taken->u_max[a] == 0;
    taken->is_unplaced = true;
    taken->reached = {};
    taken->changed_at = m_clock;
    taken->saved_for = 0;
    taken->u_min = taken->u_max = {0, 0, 0};
    return taken;
}

std::unique_ptr<Brick> Lattice::take_spare(int place) {
    std::unique_ptr<Brick> last = std::move(m_spare.back());
    m_spare.pop_back();
    auto& slot = place < int(m_spare.size()) ? m_spare[std::size_t(place)] : last;
    m_spare_at.erase(slot->coord);
    if (slot == last) return last;
    m_spare_at.erase(last->coord);
    m_spare_at.insert(last->coord, place);
    return std::exchange(slot, std::move(last));
}

void Lattice::keep_spare(std::unique_ptr<Brick> dropped) {
    m_spare_at.insert(dropped->coord, int(m_spare.size()));
    m_spare.push_back(std::move(dropped));
}

void Lattice::take_slab() {
    // Small slabs first: a small push must not ask for much.
    const std::size_t full = std::max<std::size_t>(1, kHugePage / brick_bytes());
    const std::size_t count =
        m_slabs.size() < 6 ? std::min(full, std::size_t(8) << m_slabs.size()) : full;
    const bool huge = count == full;
    const std::size_t alignment = huge ? kHugePage : kLine;
    const std::size_t bytes = round_up(count * brick_bytes(), alignment);
    m_slabs.push_back(allocate_aligned<void>(bytes, alignment));
#ifdef MADV_HUGEPAGE
    if (huge) madvise(m_slabs.back().get(), bytes, MADV_HUGEPAGE);
#endif
    m_slab_rest = static_cast<std::byte*>(m_slabs.back().get());
    m_slab_bricks_left = count;
}

std::unique_ptr<Brick> Lattice::carve_brick() {
    if (m_slab_bricks_left == 0) take_slab();
    const auto n = std::size_t(elements_per_brick());
    auto carved = std::make_unique<Brick>();
    carved->is_unplaced = true;
    std::byte* piece = std::exchange(m_slab_rest, m_slab_rest + brick_bytes());
    --m_slab_bricks_left;
    const auto next = [&](std::size_t bytes) {
        return std::exchange(piece, piece + round_up(bytes, kLine));
    };
    for (auto* arrays : {&carved->u, &carved->raised})
        for (Fixed*& array : *arrays) array = reinterpret_cast<Fixed*>(next(n * sizeof(Fixed)));
    carved->material = reinterpret_cast<MaterialId*>(next(n * sizeof(MaterialId)));
    return carved;
}

std::size_t Lattice::brick_bytes() const {
    const auto n = std::size_t(elements_per_brick());
    return 6 * round_up(n * sizeof(Fixed), kLine) + round_up(n * sizeof(MaterialId), kLine);
}

Box3i Lattice::part_in_scan(Vec3i brick_coord) const {
    Box3i part;
    for (int a = 0; a < 3; ++a) {
        const int first = m_size * brick_coord[a];
        part.begin[a] = std::clamp(-first, 0, m_size);
        part.end[a] = std::clamp(grid().size[a] - first, part.begin[a], m_size);
    }
    return part;
}

template <class Value>
void Lattice::set_beyond(const Brick& brick, Value* values, Value value) const {
    const Box3i part = part_in_scan(brick.coord);
    const int slice = m_size * m_size;
    std::fill(values, values + slice * part.begin.z, value);
    std::fill(values + slice * part.end.z, values + slice * m_size, value);
    for (int z = part.begin.z; z < part.end.z; ++z) {
        Value* rows = values + slice * z;
        std::fill(rows, rows + m_size * part.begin.y, value);
        std::fill(rows + m_size * part.end.y, rows + slice, value);
        if (part.begin.x == 0 && part.end.x == m_size) continue;
        for (int y = part.begin.y; y < part.end.y; ++y) {
            Value* row = rows + m_size * y;
            std::fill(row, row + part.begin.x, value);
            std::fill(row + part.end.x, row + m_size, value);
        }
    }
}

bool Lattice::is_whole(const Box3i& part) const {
    return part.begin == Vec3i{0, 0, 0} && part.end == Vec3i{m_size, m_size, m_size};
}

bool Lattice::fill_materials(Brick& brick) const {
    const Vec3i first = m_size * brick.coord;
    const Box3i part = part_in_scan(brick.coord);
    const bool is_one = m_materials.fill(first, m_size, part, brick.material);
    const BrickEdits* edits = edits_of(brick.coord);
    if (m_bounded && !is_whole(part)) set_beyond(brick, brick.material, kVoidMaterial);
    for (std::size_t n = 0; edits && n < edits->size(); ++n)
        if ((*edits)[n] & kVoid) brick.material[n] = kVoidMaterial;
    return is_one && !edits && (m_bounded || is_whole(part));
}

void Lattice::exchange_materials(MaterialMap& materials) noexcept {
    std::swap(m_materials, materials);
    ++m_links_version;
    for (auto& brick : m_bricks)
        if (brick && !brick->is_blank) fill_in(*brick);
    for (auto& brick : m_spare) brick->is_blank = true;
}

template void Lattice::set_beyond(const Brick&, Fixed*, Fixed) const;

std::uint8_t Lattice::traits_of_one(const Brick& brick) const {
    // A bounded lattice has no bricks before its first element, so that the first is inside.
    const std::uint8_t traits = m_materials.table().traits()[brick.material[0]];
    const bool partly = m_bounded && !is_whole(part_in_scan(brick.coord));
    return std::uint8_t(traits | (partly ? kPartlyBeyond : 0));
}

void Lattice::look_at_materials(Brick& brick) const {
    const MaterialId* ids = brick.material;
    const std::uint8_t* traits = m_materials.table().traits();
    brick.traits = traits_of_one(brick);
    const Box3i part = part_in_scan(brick.coord);
    bool mixed = false;
    for_each_y_z(m_bounded ? part : Box3i{{0, 0, 0}, {m_size, m_size, m_size}}, [&](int y, int z) {
        const MaterialId* row = ids + m_size * (y + m_size * z);
        const int end = m_bounded ? part.end.x : m_size;
        MaterialId differs = 0;
        for (int x = 0; x < end; ++x) differs |= MaterialId(row[x] ^ ids[0]);
        mixed |= differs != 0;
    });
    if (!mixed) return;
    brick.traits |= kMixedMaterials;
    const Fixed* movements = m_materials.table().movements();
    for (int n = 0; n < elements_per_brick(); ++n) {
        brick.traits |= traits[ids[n]];
        brick.least_movement = std::min(brick.least_movement, movements[ids[n]]);
    }
}

void Lattice::update_bounds(int index) {
    Brick& changed = brick(index);
    for (int a = 0; a < 3; ++a) {
        const Fixed* u = changed.u[std::size_t(a)];
        const auto [low, high] = std::minmax_element(u, u + elements_per_brick());
        changed.u_min[a] = *low;
        changed.u_max[a] = *high;
    }
}

const BrickEdits* Lattice::edits_of(Vec3i brick_coord) const {
    if (m_edits.empty()) return nullptr;
    const auto found = m_edits.find(brick_coord);
    return found == m_edits.end() || found->second.empty() ? nullptr : &found->second;
}

bool Lattice::is_linked(Vec3i low, int axis) const {
    if (!may_have_gaps()) return true;
    const BrickEdits* edits = m_edits.empty() ? nullptr : edits_of(brick_of(low));
    if (edits && ((*edits)[std::size_t(index_in_brick(low))] & (kCutX << axis))) return false;
    return !is_void(low) && !is_void(low + Vec3i{axis == 0, axis == 1, axis == 2});
}

void Lattice::set_edits(Vec3i brick_coord, BrickEdits edits) {
    if (m_observer) m_observer->before_edit(brick_coord, edits_of(brick_coord));
    const bool any = std::any_of(edits.begin(), edits.end(), [](auto flags) { return flags != 0; });
    if (any)
        m_edits[brick_coord] = std::move(edits);
    else
        m_edits.erase(brick_coord);
    follow_edits(brick_coord);
}

void Lattice::prepare_edits(const EditMap& edits) {
    try {
        for (const auto& [coord, flags] : edits) {
            if (m_observer) m_observer->before_edit(coord, edits_of(coord));
            m_edits.try_emplace(coord);
        }
    } catch (...) {
        finish_edits(edits);
        throw;
    }
}

void Lattice::exchange_edits(EditMap& edits) noexcept {
    for (auto& [coord, flags] : edits) {
        if (std::all_of(flags.begin(), flags.end(), [](auto f) { return f == 0; })) flags.clear();
        m_edits.find(coord)->second.swap(flags);
        follow_edits(coord);
    }
}

void Lattice::finish_edits(const EditMap& edits) noexcept {
    for (const auto& [coord, flags] : edits)
        if (const auto own = m_edits.find(coord); own != m_edits.end() && own->second.empty())
            m_edits.erase(own);
}

void Lattice::restore_edits(EditMap& saved) noexcept {
    while (!saved.empty()) {
        // Nodes move from map to map, which has had room for as many.
        auto node = saved.extract(saved.begin());
        const Vec3i coord = node.key();
        const BrickEdits* now = edits_of(coord);
        if (now ? *now == node.mapped() : node.mapped().empty()) continue;
        m_edits.erase(coord);
        if (!node.mapped().empty()) m_edits.insert(std::move(node));
        follow_edits(coord);
    }
}

void Lattice::follow_edits(Vec3i brick_coord) noexcept {
    ++m_links_version;
    if (const int place = m_spare_at.find(brick_coord); place >= 0)
        m_spare[std::size_t(place)]->is_blank = true;
    const int index = find_brick(brick_coord);
    if (index < 0) return;
    Brick& edited = brick(index);
    const BrickEdits* now = edits_of(brick_coord);
    edited.edits = now ? now->data() : nullptr;
    edited.changed_at = tick();
    fill_in(edited);
}

void Lattice::drop_still_bricks() noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)] && is_at_rest(brick(index))) drop_brick(index);
}

void Lattice::drop_still_bricks(std::span<const int> bricks) noexcept {
    for (const int index : bricks)
        if (m_bricks[std::size_t(index)] && is_at_rest(brick(index))) drop_brick(index);
}

void Lattice::drop_made_since(std::uint64_t made_count) noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)] && brick(index).serial > made_count &&
            is_at_rest(brick(index)))
            drop_brick(index);
}

void Lattice::drop_all_bricks() noexcept {
    for (int index = 0; index < int(m_bricks.size()); ++index)
        if (m_bricks[std::size_t(index)]) drop_brick(index);
}

void Lattice::drop_brick(int index) noexcept {
    auto& slot = m_bricks[std::size_t(index)];
    for (int side = 0; side < 6; ++side) {
        const int neighbour = slot->neighbours[std::size_t(side)];
        if (neighbour >= 0) brick(neighbour).neighbours[std::size_t(side ^ 1)] = -1;
    }
    m_index_of.erase(slot->coord);
    --m_resident_count;
    m_free_indices.push_back(index);
    keep_spare(std::move(slot));
}

std::vector<int> Lattice::resident_bricks() const {
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

std::size_t Lattice::resident_bytes() const {
    const auto edited = m_edits.size() * std::size_t(elements_per_brick());
    return std::size_t(resident_brick_count()) * (sizeof(Brick) + brick_bytes()) + edited;
}

}  // namespace pliant
