// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/material_map.h"

#include <algorithm>
#include <cmath>

#include "chainmail/air.h"

namespace pliant {
namespace {

int whole_value(std::int16_t value) {
    return value;
}
int whole_value(float value) {
    if (std::isnan(value)) return kAirHu;
    return int(std::lround(std::clamp(value, -32768.0f, 32767.0f)));
}

std::vector<MaterialLaw> all_laws(const ChainMailSettings& settings) {
    std::vector<MaterialLaw> laws = {settings.custom_law ? settings.custom_law
                                                         : draeger_law(settings)};
    for (MaterialLaw& law : label_laws(settings)) laws.push_back(std::move(law));
    return laws;
}

Vec3i moved_along(Vec3i ijk, int axis, int steps) {
    ijk[axis] += steps;
    return ijk;
}

}  // namespace

MaterialMap::MaterialMap(const Volume& volume, const std::vector<MaterialLaw>& laws)
    : m_volume(&volume), m_laws(laws), m_table(laws, {}, volume.grid.spacing_mm) {}

MaterialMap::MaterialMap(const Volume& volume, const ChainMailSettings& settings)
    : m_volume(&volume),
      m_laws(all_laws(settings)),
      m_air(air_limits(settings)),
      m_has_air(settings.air_enabled && !settings.custom_law),
      m_air_threshold_hu(settings.air_threshold_hu),
      m_labels(settings),
      m_table(m_laws,
              m_has_air ? std::vector(m_air.begin(), m_air.end()) : std::vector(0, m_air[0]),
              volume.grid.spacing_mm) {}

int MaterialMap::value_at(Vec3i ijk) const {
    const Grid& grid = m_volume->grid;
    if (!contains(voxel_box(grid), ijk)) return kAirHu;
    const std::size_t n = voxel_index(grid, ijk);
    return std::visit([&](const auto& voxels) { return whole_value(voxels[n]); }, m_volume->voxels);
}

bool MaterialMap::is_air(Vec3i ijk) const {
    return m_has_air && value_at(ijk) < m_air_threshold_hu && m_labels.law_at(ijk) < 0;
}

unsigned MaterialMap::air_axes(Vec3i ijk) const {
    return skin_axes([&](int axis, int steps) { return is_air(moved_along(ijk, axis, steps)); });
}

MaterialId MaterialMap::at(Vec3i ijk) const {
    const int label = m_labels.law_at(ijk);
    if (label >= 0) return m_table.id(1 + label, value_at(ijk));
    return is_air(ijk) ? m_table.other_id(int(air_axes(ijk))) : m_table.id(0, value_at(ijk));
}

ElementLimits MaterialMap::limits_at(Vec3i ijk) const {
    const int label = m_labels.law_at(ijk);
    if (label >= 0) return m_laws[std::size_t(1 + label)](value_at(ijk));
    return is_air(ijk) ? m_air[air_axes(ijk)] : m_laws[0](value_at(ijk));
}

bool MaterialMap::is_uniformly_tissue(Vec3i first, int size) const {
    if (!m_labels.empty()) return false;
    const Grid& grid = m_volume->grid;
    const Vec3i last = first + Vec3i{size - 1, size - 1, size - 1};
    if (!contains(voxel_box(grid), first) || !contains(voxel_box(grid), last)) return false;
    if (!m_has_air) return true;
    return std::visit(
        [&](const auto& voxels) {
            for (int z = first.z; z <= last.z; ++z)
                for (int y = first.y; y <= last.y; ++y) {
                    const auto* row = voxels.data() + voxel_index(grid, {first.x, y, z});
                    if (std::any_of(row, row + size,
                                    [&](auto v) { return whole_value(v) < m_air_threshold_hu; }))
                        return false;
                }
            return true;
        },
        m_volume->voxels);
}

void MaterialMap::fill(Vec3i first, int size, MaterialId* out) const {
    if (!is_uniformly_tissue(first, size)) return fill_with_air(first, size, out);
    const Grid& grid = m_volume->grid;
    std::visit(
        [&](const auto& voxels) {
            for (int z = first.z; z < first.z + size; ++z)
                for (int y = first.y; y < first.y + size; ++y) {
                    const auto* row = voxels.data() + voxel_index(grid, {first.x, y, z});
                    for (int x = 0; x < size; ++x) *out++ = m_table.id(0, whole_value(row[x]));
                }
        },
        m_volume->voxels);
}

/// Values, labels and what is air are looked up once for the cube and its surroundings.
void MaterialMap::fill_with_air(Vec3i first, int size, MaterialId* out) const {
    const int reach = m_has_air ? kSkinReach : 0, row = size + 2 * reach;
    static thread_local std::vector<unsigned char> air;
    air.assign(std::size_t(row) * std::size_t(row) * std::size_t(row), 0);
    const int strides[3] = {1, row, row * row};
    const auto index = [&](int x, int y, int z) {
        return std::size_t(x + reach + row * (y + reach + row * (z + reach)));
    };
    const auto inner = [&](int n) { return n >= 0 && n < size; };
    for (int z = -reach; m_has_air && z < size + reach; ++z)
        for (int y = -reach; y < size + reach; ++y)
            for (int x = -reach; x < size + reach; ++x)
                if (int(inner(x)) + int(inner(y)) + int(inner(z)) >= 2)
                    air[index(x, y, z)] = is_air(first + Vec3i{x, y, z});
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Vec3i e = first + Vec3i{x, y, z};
                const auto* here = air.data() + index(x, y, z);
                if (*here) {
                    const unsigned axes = skin_axes(
                        [&](int axis, int steps) { return here[steps * strides[axis]] != 0; });
                    *out++ = m_table.other_id(int(axes));
                } else {
                    *out++ = m_table.id(1 + m_labels.law_at(e), value_at(e));
                }
            }
}

}  // namespace pliant
