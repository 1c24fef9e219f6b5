// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

int floor_div(int a, int b) {
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

int whole_value(std::int16_t value) {
    return value;
}
int whole_value(float value) {
    return int(std::lround(std::clamp(value, -32768.0f, 32767.0f)));
}

std::size_t round_up_to_line(std::size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

}  // namespace

Lattice::Lattice(const Volume& volume, const std::vector<MaterialLaw>& laws, int brick_size,
                 bool bounded)
    : m_volume(volume),
      m_materials(laws, volume.grid.spacing_mm),
      m_size(brick_size),
      m_bounded(bounded) {
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
    return {floor_div(ijk.x, m_size), floor_div(ijk.y, m_size), floor_div(ijk.z, m_size)};
}

int Lattice::index_in_brick(Vec3i ijk) const {
    const Vec3i local = ijk - m_size * brick_of(ijk);
    return local.x + m_size * (local.y + m_size * local.z);
}

Vec3i Lattice::element_of(Vec3i brick_coord, int index) const {
    const Vec3i local{index % m_size, index / m_size % m_size, index / (m_size * m_size)};
    return m_size * brick_coord + local;
}

int Lattice::value_at(Vec3i ijk) const {
    if (!contains(voxel_box(grid()), ijk)) return kAirHu;
    const std::size_t n = voxel_index(grid(), ijk);
    return std::visit([&](const auto& voxels) { return whole_value(voxels[n]); }, m_volume.voxels);
}

MaterialId Lattice::material_at(Vec3i ijk) const {
    if (m_bounded && !contains(voxel_box(grid()), ijk)) return kVoidMaterial;
    const BrickEdits* edits = edits_of(brick_of(ijk));
    if (edits && ((*edits)[std::size_t(index_in_brick(ijk))] & kVoid)) return kVoidMaterial;
    return m_materials.id(0, value_at(ijk));
}

Vec3<Fixed> Lattice::displacement_at(Vec3i ijk) const {
    const int found = find_brick(brick_of(ijk));
    if (found < 0) return {0, 0, 0};
    const auto index = std::size_t(index_in_brick(ijk));
    const auto& u = brick(found).u;
    return {u[0][index], u[1][index], u[2][index]};
}

int Lattice::find_brick(Vec3i coord) const {
    const auto found = m_index_of.find(coord);
    return found == m_index_of.end() ? -1 : found->second;
}

int Lattice::ensure_brick(Vec3i coord) {
    if (const int found = find_brick(coord); found >= 0) return found;
    int index = int(m_bricks.size());
    if (m_free_indices.empty()) {
        m_bricks.push_back(take_brick());
    } else {
        index = m_free_indices.back();
        m_free_indices.pop_back();
        m_bricks[std::size_t(index)] = take_brick();
    }
    m_index_of.emplace(coord, index);
    Brick& made = brick(index);
    made.coord = coord;
    for (int side = 0; side < 6; ++side) {
        Vec3i there = coord;
        there[side / 2] += side % 2 ? 1 : -1;
        const int neighbour = find_brick(there);
        made.neighbours[std::size_t(side)] = neighbour;
        if (neighbour >= 0) brick(neighbour).neighbours[std::size_t(side ^ 1)] = index;
    }
    fill_materials(made);
    const BrickEdits* edits = edits_of(coord);
    made.edits = edits ? edits->data() : nullptr;
    return index;
}

ElementRef Lattice::ensure_element(Vec3i ijk) {
    return {ensure_brick(brick_of(ijk)), index_in_brick(ijk)};
}

std::unique_ptr<Brick> Lattice::take_brick() {
    const auto n = std::size_t(elements_per_brick());
    std::unique_ptr<Brick> taken;
    if (m_spare.empty()) {
        taken = std::make_unique<Brick>();
        taken->memory.reset(::operator new (brick_bytes(), std::align_val_t{64}));
        auto* piece = static_cast<std::byte*>(taken->memory.get());
        const auto next = [&](std::size_t bytes) {
            return std::exchange(piece, piece + round_up_to_line(bytes));
        };
        for (auto* arrays : {&taken->u, &taken->raised})
            for (Fixed*& array : *arrays) array = reinterpret_cast<Fixed*>(next(n * sizeof(Fixed)));
        taken->material = reinterpret_cast<MaterialId*>(next(n * sizeof(MaterialId)));
    } else {
        taken = std::move(m_spare.back());
        m_spare.pop_back();
    }
    for (Fixed* component : taken->u) std::fill_n(component, n, 0);
    taken->reached = {};
    taken->changed_at = m_clock;
    taken->u_min = taken->u_max = {0, 0, 0};
    return taken;
}

std::size_t Lattice::brick_bytes() const {
    const auto n = std::size_t(elements_per_brick());
    return 6 * round_up_to_line(n * sizeof(Fixed)) + round_up_to_line(n * sizeof(MaterialId));
}

void Lattice::fill_materials(Brick& brick) const {
    const Vec3i first = m_size * brick.coord;
    const Vec3i last = first + Vec3i{m_size - 1, m_size - 1, m_size - 1};
    const Box3i box = voxel_box(grid());
    MaterialId* out = brick.material;
    if (!contains(box, first) || !contains(box, last) || m_edits.contains(brick.coord)) {
        for (int n = 0; n < elements_per_brick(); ++n)
            out[n] = material_at(element_of(brick.coord, n));
        return;
    }
    std::visit(
        [&](const auto& voxels) {
            for (int z = first.z; z <= last.z; ++z)
                for (int y = first.y; y <= last.y; ++y) {
                    const auto* row = voxels.data() + voxel_index(grid(), {first.x, y, z});
                    for (int x = 0; x < m_size; ++x)
                        *out++ = m_materials.id(0, whole_value(row[x]));
                }
        },
        m_volume.voxels);
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
    return found == m_edits.end() ? nullptr : &found->second;
}

void Lattice::set_edits(Vec3i brick_coord, BrickEdits edits) {
    const bool any = std::any_of(edits.begin(), edits.end(), [](auto flags) { return flags != 0; });
    if (any)
        m_edits[brick_coord] = std::move(edits);
    else
        m_edits.erase(brick_coord);
    ++m_links_version;
    const int index = find_brick(brick_coord);
    if (index < 0) return;
    Brick& edited = brick(index);
    const BrickEdits* now = edits_of(brick_coord);
    edited.edits = now ? now->data() : nullptr;
    edited.changed_at = tick();
    fill_materials(edited);
}

void Lattice::drop_still_bricks() {
    for (int index = 0; index < int(m_bricks.size()); ++index) {
        auto& slot = m_bricks[std::size_t(index)];
        if (!slot) continue;
        if (slot->u_min != Vec3<Fixed>{0, 0, 0} || slot->u_max != Vec3<Fixed>{0, 0, 0}) continue;
        for (int side = 0; side < 6; ++side) {
            const int neighbour = slot->neighbours[std::size_t(side)];
            if (neighbour >= 0) brick(neighbour).neighbours[std::size_t(side ^ 1)] = -1;
        }
        m_index_of.erase(slot->coord);
        m_free_indices.push_back(index);
        m_spare.push_back(std::move(slot));
    }
}

std::vector<int> Lattice::resident_bricks() const {
    std::vector<int> indices;
    indices.reserve(m_index_of.size());
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
