// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "lattice/lattice.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace pliant {

Lattice::Lattice(const Volume& volume, MaterialMap materials, int brick_size, bool bounded)
    : Field(volume.grid, brick_size, bounded,
            {sizeof(Brick),
             6 * array_bytes<Fixed>(brick_size) + array_bytes<MaterialId>(brick_size)}),
      m_materials(std::move(materials)) {
    for (int axis = 0; axis < 3; ++axis) {
        const int s = stride(axis), t = stride((axis + 1) % 3), v = stride((axis + 2) % 3);
        for (int q = 0; q < brick_size; ++q) {
            for (int p = 0; p < brick_size; ++p) {
                m_faces[std::size_t(2 * axis)].push_back(p * t + q * v);
                m_faces[std::size_t(2 * axis + 1)].push_back(p * t + q * v + (brick_size - 1) * s);
            }
        }
    }
}

FieldBrick& Lattice::make_brick(std::byte* memory) {
    Brick& made = m_made.emplace_back();
    for (auto* arrays : {&made.u, &made.raised})
        for (Fixed*& array : *arrays) array = next_array<Fixed>(memory);
    made.material = next_array<MaterialId>(memory);
    return made;
}

void Lattice::begin_brick(FieldBrick& brick, bool is_elsewhere) noexcept {
    Brick& begun = static_cast<Brick&>(brick);
    if (is_elsewhere) begun.is_blank = true;
    begun.reached = {};
    begun.saved_for = 0;
}

MaterialId Lattice::material_at(Vec3i ijk) const {
    return is_void(ijk) ? kVoidMaterial : m_materials.at(ijk);
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

ElementRef Lattice::ensure_element(Vec3i ijk) {
    return {ensure_brick(brick_of(ijk)), index_in_brick(ijk)};
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
    if (brick.is_blank)
        m_materials.fetch_early(brick_size() * brick.coord, part_in_grid(brick.coord));
}

bool Lattice::is_beyond_border(Vec3i brick_coord) const {
    if (!is_bounded()) return false;
    for (int a = 0; a < 3; ++a) {
        if (brick_coord[a] < 0 || brick_size() * brick_coord[a] >= grid().size[a]) return true;
    }
    return false;
}

template <class Value>
void Lattice::set_beyond(const Brick& brick, Value* values, Value value) const {
    const int size = brick_size();
    const Box3i part = part_in_grid(brick.coord);
    const int slice = size * size;
    std::fill(values, values + slice * part.begin.z, value);
    std::fill(values + slice * part.end.z, values + slice * size, value);
    for (int z = part.begin.z; z < part.end.z; ++z) {
        Value* rows = values + slice * z;
        std::fill(rows, rows + size * part.begin.y, value);
        std::fill(rows + size * part.end.y, rows + slice, value);
        if (part.begin.x == 0 && part.end.x == size) continue;
        for (int y = part.begin.y; y < part.end.y; ++y) {
            Value* row = rows + size * y;
            std::fill(row, row + part.begin.x, value);
            std::fill(row + part.end.x, row + size, value);
        }
    }
}

template void Lattice::set_beyond(const Brick&, Fixed*, Fixed) const;

bool Lattice::is_whole(const Box3i& part) const {
    const int size = brick_size();
    return part.begin == Vec3i{0, 0, 0} && part.end == Vec3i{size, size, size};
}

bool Lattice::fill_materials(Brick& brick) const {
    const Vec3i first = brick_size() * brick.coord;
    const Box3i part = part_in_grid(brick.coord);
    const bool is_one = m_materials.fill(first, brick_size(), part, brick.material);
    const BrickEdits* edits = edits_of(brick.coord);
    if (is_bounded() && !is_whole(part)) set_beyond(brick, brick.material, kVoidMaterial);
    for (std::size_t n = 0; edits && n < edits->size(); ++n)
        if ((*edits)[n] & kVoid) brick.material[n] = kVoidMaterial;
    return is_one && !edits && (is_bounded() || is_whole(part));
}

void Lattice::exchange_materials(MaterialMap& materials) noexcept {
    std::swap(m_materials, materials);
    count_links_change();
    for_each_brick([&](Brick& brick) {
        if (!brick.is_blank) fill_in(brick);
    });
    forget_all_dropped();
}

void Lattice::follow_edits(FieldBrick& brick) noexcept {
    fill_in(static_cast<Brick&>(brick));
}

void Lattice::forget_dropped(FieldBrick& brick) noexcept {
    static_cast<Brick&>(brick).is_blank = true;
}

std::uint8_t Lattice::traits_of_one(const Brick& brick) const {
    // A bounded lattice has no bricks before its first element, so that the first is inside.
    const std::uint8_t traits = m_materials.table().traits()[brick.material[0]];
    const bool partly = is_bounded() && !is_whole(part_in_grid(brick.coord));
    return std::uint8_t(traits | (partly ? kPartlyBeyond : 0));
}

void Lattice::look_at_materials(Brick& brick) const {
    const int size = brick_size();
    const MaterialId* ids = brick.material;
    const std::uint8_t* traits = m_materials.table().traits();
    brick.traits = traits_of_one(brick);
    const Box3i part = part_in_grid(brick.coord);
    bool mixed = false;
    for_each_y_z(is_bounded() ? part : Box3i{{0, 0, 0}, {size, size, size}}, [&](int y, int z) {
        const MaterialId* row = ids + size * (y + size * z);
        const int end = is_bounded() ? part.end.x : size;
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

void Lattice::set_edits(Vec3i brick_coord, BrickEdits edits) {
    if (m_observer) m_observer->before_edit(brick_coord, edits_of(brick_coord));
    Field::set_edits(brick_coord, std::move(edits));
}

void Lattice::prepare_edits(const EditMap& edits) {
    if (m_observer)
        for (const auto& [coord, flags] : edits) m_observer->before_edit(coord, edits_of(coord));
    Field::prepare_edits(edits);
}

}  // namespace pliant
