// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/lattice.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace pliant {
namespace {

int floor_div(int a, int b) {
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

MaterialId material_of_value(std::int16_t value) {
    return material_from_hu(value);
}
MaterialId material_of_value(float value) {
    return material_from_hu(int(std::lround(std::clamp(value, -32768.0f, 32767.0f))));
}

}  // namespace

Lattice::Lattice(const Volume& volume, const MaterialLaw& law, int brick_size)
    : m_volume(volume), m_materials(law, volume.grid.spacing_mm), m_size(brick_size) {
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

MaterialId Lattice::material_at(Vec3i ijk) const {
    if (!contains(voxel_box(grid()), ijk)) return material_from_hu(kAirHu);
    const std::size_t n = voxel_index(grid(), ijk);
    return std::visit([&](const auto& voxels) { return material_of_value(voxels[n]); },
                      m_volume.voxels);
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
        for (int a = 0; a < 3; ++a) {
            taken->u[std::size_t(a)] = std::make_unique_for_overwrite<Fixed[]>(n);
            taken->raised[std::size_t(a)] = std::make_unique_for_overwrite<Fixed[]>(n);
        }
        taken->material = std::make_unique_for_overwrite<MaterialId[]>(n);
    } else {
        taken = std::move(m_spare.back());
        m_spare.pop_back();
    }
    for (auto& component : taken->u) std::fill_n(component.get(), n, 0);
    taken->reached = {};
    taken->u_min = taken->u_max = {0, 0, 0};
    return taken;
}

void Lattice::fill_materials(Brick& brick) const {
    const Vec3i first = m_size * brick.coord;
    const Vec3i last = first + Vec3i{m_size - 1, m_size - 1, m_size - 1};
    const Box3i box = voxel_box(grid());
    MaterialId* out = brick.material.get();
    if (!contains(box, first) || !contains(box, last)) {
        for (int n = 0; n < elements_per_brick(); ++n)
            out[n] = material_at(element_of(brick.coord, n));
        return;
    }
    std::visit(
        [&](const auto& voxels) {
            for (int z = first.z; z <= last.z; ++z)
                for (int y = first.y; y <= last.y; ++y) {
                    const auto* row = voxels.data() + voxel_index(grid(), {first.x, y, z});
                    for (int x = 0; x < m_size; ++x) *out++ = material_of_value(row[x]);
                }
        },
        m_volume.voxels);
}

void Lattice::update_bounds(int index) {
    Brick& changed = brick(index);
    for (int a = 0; a < 3; ++a) {
        const Fixed* u = changed.u[std::size_t(a)].get();
        const auto [low, high] = std::minmax_element(u, u + elements_per_brick());
        changed.u_min[a] = *low;
        changed.u_max[a] = *high;
    }
}

void Lattice::drop_still_bricks() {
    const auto n = std::size_t(elements_per_brick());
    for (int index = 0; index < int(m_bricks.size()); ++index) {
        auto& slot = m_bricks[std::size_t(index)];
        if (!slot) continue;
        const bool still = std::all_of(slot->u.begin(), slot->u.end(), [&](const auto& component) {
            return std::all_of(component.get(), component.get() + n,
                               [](Fixed v) { return v == 0; });
        });
        if (!still) continue;
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
    const auto n = std::size_t(elements_per_brick());
    const std::size_t per_brick = sizeof(Brick) + n * (6 * sizeof(Fixed) + sizeof(MaterialId));
    return std::size_t(resident_brick_count()) * per_brick;
}

}  // namespace pliant
