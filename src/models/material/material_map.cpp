// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/material_map.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "field/field.h"
#include "material/air.h"

namespace pliant {
namespace {

int nearest_number(float position) {
    return int(std::lround(std::clamp(position, -32768.0f, 32767.0f)));
}

/// Prefetches memory: a brick's rows lie far apart in the scan. It reads the memory, since
/// processors may drop a prefetch hint whose address isn't in the TLB.
void fetch(const void* where) {
    static_cast<void>(*static_cast<const volatile char*>(where));
}

template <class Voxel, class NumberOf>
void translate_row(const Voxel* voxels, int count, const NumberOf& number_of, const MaterialId* ids,
                   MaterialId* out) {
    for (int x = 0; x < count; ++x)
        out[x] = ids[std::max(number_of(voxels[x]), kLowestValue) - kLowestValue];
}

template <class Voxel>
bool is_row_of(Voxel value, const Voxel* row, int count) {
    if constexpr (sizeof(Voxel) == 2)
        if (count == 8) {
            std::array<Voxel, 8> all;
            all.fill(value);
            std::array<std::uint64_t, 2> a, b;
            std::memcpy(a.data(), row, sizeof a);
            std::memcpy(b.data(), all.data(), sizeof b);
            return a == b;
        }
    return std::all_of(row, row + count, [&](Voxel other) { return other == value; });
}

std::vector<MaterialLaw> all_laws(const ResolvedSettings& resolved) {
    const ChainMailSettings& settings = resolved.settings;
    std::vector<MaterialLaw> laws = {settings.custom_law ? settings.custom_law
                                                         : law_on_scale(settings, resolved.scale)};
    for (MaterialLaw& law : label_laws(settings, resolved.scale)) laws.push_back(std::move(law));
    return laws;
}

/// Limits of small bones: those of the hardest tissue that isn't bone.
ElementLimits stiff_limits(const ChainMailSettings& settings) {
    return draeger_limits(settings, settings.bone_threshold_hu);
}

/// Whether pieces above the threshold may be too small for a bone.
bool has_pieces(const ChainMailSettings& settings) {
    return settings.smallest_bone_mm3 > 0 && !settings.custom_law;
}

/// Materials that don't depend on a value: air, then small bones.
std::vector<ElementLimits> other_limits(const ChainMailSettings& settings,
                                        const std::array<ElementLimits, 8>& air, bool has_air,
                                        const ElementLimits& stiff) {
    std::vector<ElementLimits> others;
    if (has_air) others.assign(air.begin(), air.end());
    if (has_pieces(settings)) others.push_back(stiff);
    return others;
}

/// The lowest number that is bone by its value; bone has no upper end. Labels may have none, or
/// none but bone.
int lowest_bone(const MaterialLaw& law) {
    int low = kLowestValue, high = 32768;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (law(middle).fixed)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

Vec3i moved_along(Vec3i ijk, int axis, int steps) {
    ijk[axis] += steps;
    return ijk;
}

}  // namespace

MaterialMap::MaterialMap(const Volume& volume, const std::vector<MaterialLaw>& laws)
    : m_volume(&volume),
      m_laws(laws),
      m_outside(nearest_number(volume.background)),
      m_table(laws, {}, volume.grid.spacing_mm) {}

MaterialMap::MaterialMap(const Volume& volume, const ResolvedSettings& resolved)
    : m_volume(&volume),
      m_laws(all_laws(resolved)),
      m_air(air_limits(resolved.settings)),
      m_has_air(resolved.settings.air_enabled && !resolved.settings.custom_law),
      m_scale(resolved.scale),
      m_per_value(float(m_scale.per_value)),
      m_shift(float(m_scale.shift)),
      m_air_below(int(std::clamp(std::ceil(m_scale.position_of(resolved.settings.air_threshold_hu)),
                                 -32768.0, 32768.0))),
      m_outside(nearest_number(float(m_scale.position_of(double(volume.background))))),
      m_labels(resolved.settings),
      m_stiff(stiff_limits(resolved.settings)),
      m_table(m_laws, other_limits(resolved.settings, m_air, m_has_air, m_stiff),
              volume.grid.spacing_mm) {
    if (has_pieces(resolved.settings) && !m_table.fault() && m_table.fits())
        m_small_bones = find_small_bones(resolved.settings.smallest_bone_mm3);
}

SmallBones MaterialMap::find_small_bones(double smallest_mm3) const {
    std::vector<int> from;  // by law
    for (const MaterialLaw& law : m_laws) from.push_back(lowest_bone(law));
    const int lowest = *std::min_element(from.begin(), from.end());
    const auto look_at = [&](const auto& voxels, int y, int z, BoneElement* row) {
        const auto* values = voxels.data() + voxel_index(m_volume->grid, {0, y, z});
        const int count = m_volume->grid.size.x;
        int highest = kLowestValue;
        for (int x = 0; x < count; ++x) highest = std::max(highest, number_of(values[x]));
        if (highest < lowest) return false;
        for (int x = 0; x < count; ++x) {
            const int number = number_of(values[x]), law = m_labels.law_at({x, y, z});
            const int bone = from[std::size_t(1 + law)];
            row[x] = number < bone         ? BoneElement::None
                     : bone > kLowestValue ? BoneElement::ByValue
                                           : BoneElement::ByLabel;
        }
        return true;
    };
    return {m_volume->grid, smallest_mm3, [&](int y, int z, BoneElement* row) {
                return std::visit([&](const auto& voxels) { return look_at(voxels, y, z, row); },
                                  m_volume->voxels);
            }};
}

bool MaterialMap::is_small_bone(Vec3i ijk) const {
    return !m_small_bones.empty() && contains(voxel_box(m_volume->grid), ijk) &&
           m_small_bones.has(voxel_index(m_volume->grid, ijk));
}

bool MaterialMap::lay_small_bones(Vec3i first, int size, const Box3i& part, MaterialId* out) const {
    if (m_small_bones.empty() || is_empty(part) ||
        !m_small_bones.may_be_in({first + part.begin, first + part.end}))
        return false;
    bool any = false;
    for_each_y_z(part, [&](int y, int z) {
        const std::size_t row = voxel_index(m_volume->grid, first + Vec3i{part.begin.x, y, z});
        for (int x = part.begin.x; x < part.end.x; ++x) {
            if (!m_small_bones.has(row + std::size_t(x - part.begin.x))) continue;
            out[x + size * (y + size * z)] = stiff_id();
            any = true;
        }
    });
    return any;
}

int MaterialMap::number_of(float value) const {
    if (std::isnan(value)) return m_outside;
    return nearest_number(value * m_per_value + m_shift);
}

int MaterialMap::number_at(Vec3i ijk) const {
    const Grid& grid = m_volume->grid;
    if (!contains(voxel_box(grid), ijk)) return m_outside;
    const std::size_t n = voxel_index(grid, ijk);
    return std::visit([&](const auto& voxels) { return number_of(voxels[n]); }, m_volume->voxels);
}

bool MaterialMap::is_tissue(Vec3i ijk) const {
    return contains(voxel_box(m_volume->grid), ijk) && !is_air(ijk);
}

bool MaterialMap::is_air(Vec3i ijk) const {
    return m_has_air && number_at(ijk) < m_air_below && m_labels.law_at(ijk) < 0;
}

unsigned MaterialMap::air_axes(Vec3i ijk) const {
    // This far outside of the scan no wall is within reach.
    for (int a = 0; a < 3; ++a)
        if (ijk[a] < -kSkinReach || ijk[a] >= m_volume->grid.size[a] + kSkinReach) return 0;
    return skin_axes([&](int axis, int steps) { return is_air(moved_along(ijk, axis, steps)); });
}

MaterialId MaterialMap::at(Vec3i ijk) const {
    if (is_small_bone(ijk)) return stiff_id();
    const int label = m_labels.law_at(ijk);
    if (label >= 0) return m_table.id(1 + label, number_at(ijk));
    return is_air(ijk) ? m_table.other_id(int(air_axes(ijk))) : m_table.id(0, number_at(ijk));
}

ElementLimits MaterialMap::limits_at(Vec3i ijk) const {
    if (is_small_bone(ijk)) return m_stiff;
    const int label = m_labels.law_at(ijk);
    if (label >= 0) return m_laws[std::size_t(1 + label)](number_at(ijk));
    return is_air(ijk) ? m_air[air_axes(ijk)] : m_laws[0](number_at(ijk));
}

/// Bit set of the air elements of a row along x, the lowest bit for the first.
template <int kCount, class Voxel>
unsigned MaterialMap::air_of_row(const Voxel* voxels, Vec3i first) const {
    const Grid& grid = m_volume->grid;
    const unsigned all = (1u << kCount) - 1, outside = m_outside < m_air_below ? all : 0;
    const bool beside =
        first.y < 0 || first.z < 0 || first.y >= grid.size.y || first.z >= grid.size.z;
    const int begin = std::clamp(-first.x, 0, kCount);
    const int end = std::clamp(grid.size.x - first.x, begin, kCount);
    if (beside || begin == end) return outside;
    const Voxel* row = voxels + voxel_index(grid, first + Vec3i{begin, 0, 0});
    unsigned air = 0;
    if (end - begin == kCount) {
        for (int x = 0; x < kCount; ++x) air |= unsigned(number_of(row[x]) < m_air_below) << x;
        return air;
    }
    for (int x = 0; x < end - begin; ++x) air |= unsigned(number_of(row[x]) < m_air_below) << x;
    const unsigned inside = ((1u << (end - begin)) - 1) << begin;
    return air << begin | (outside & ~inside);
}

/// Adds the brick's surroundings, on which skin depends, to its air bits.
template <class Voxel>
void MaterialMap::look_around(const Voxel* voxels, Vec3i first, AirBits& air) const {
    constexpr int kSize = AirBits::kSize, kReach = kSkinReach;
    const auto row = [&](int y, int z) {
        return air_of_row<kSize>(voxels, first + Vec3i{0, y, z});
    };
    const auto beside = [&](int x, int y, int z) {
        return air_of_row<kReach>(voxels, first + Vec3i{x, y, z});
    };
    const auto fetch_row = [&](int y, int z) {
        const Vec3i start = first + Vec3i{0, y, z};
        if (contains(voxel_box(m_volume->grid), start))
            fetch(voxels + voxel_index(m_volume->grid, start));
    };
    for (const int from : {-kReach, kSize})
        for (int n = from; n < from + kReach; ++n)
            for (int m = 0; m < kSize; ++m) fetch_row(n, m), fetch_row(m, n);
    for (int n = 0; n < kSize; ++n)
        for (int y = 0; y < kSize; ++y)
            air.set_beside_row(y, n, beside(-kReach, y, n), beside(kSize, y, n));
    for (const int from : {-kReach, kSize})
        for (int n = from; n < from + kReach; ++n)
            for (int m = 0; m < kSize; ++m) {
                air.set_row_beside(n, m, row(n, m));
                air.set_row(m, n, row(m, n));
            }
}

/// Replaces the materials of air elements in a brick of 8³. @returns whether there are any
template <class Voxel>
bool MaterialMap::lay_air(const Voxel* voxels, Vec3i first, MaterialId* out) const {
    constexpr int kSize = AirBits::kSize;
    AirBits air;
    for (int z = 0; z < kSize; ++z)
        for (int y = 0; y < kSize; ++y)
            air.set_row(y, z, air_of_row<kSize>(voxels, first + Vec3i{0, y, z}));
    if (!air.any()) return false;
    look_around(voxels, first, air);
    for (int z = 0; z < kSize; ++z, out += kSize * kSize) {
        const auto [x_skin, y_skin, z_skin] = air.skin(z);
        for (std::uint64_t rest = air.slice(z); rest != 0; rest &= rest - 1) {
            const int n = std::countr_zero(rest);
            out[n] = m_table.other_id(
                int((x_skin >> n & 1) | (y_skin >> n & 1) << 1 | (z_skin >> n & 1) << 2));
        }
    }
    return true;
}

template <class Voxel>
bool MaterialMap::fill_by_value(const Voxel* voxels, Vec3i first, int size, const Box3i& part,
                                MaterialId* out) const {
    if (is_empty(part)) return false;
    const MaterialId* ids = m_table.ids(0);
    const int count = part.end.x - part.begin.x;
    const auto number = [this](Voxel value) { return number_of(value); };
    const auto row_at = [&](int y, int z) {
        return voxels + voxel_index(m_volume->grid, first + Vec3i{part.begin.x, y, z});
    };
    const auto out_at = [&](int y, int z) { return out + part.begin.x + size * (y + size * z); };
    const Voxel value = *row_at(part.begin.y, part.begin.z);
    bool is_one = true;
    for_each_y_z(part,
                 [&](int y, int z) { is_one = is_one && is_row_of(value, row_at(y, z), count); });
    if (!is_one) {
        for_each_y_z(part, [&](int y, int z) {
            translate_row(row_at(y, z), count, number, ids, out_at(y, z));
        });
    } else {
        MaterialId id;
        translate_row(&value, 1, number, ids, &id);
        for_each_y_z(part, [&](int y, int z) { std::fill_n(out_at(y, z), count, id); });
    }
    return is_one;
}

void MaterialMap::fetch_early(Vec3i first, const Box3i& part) const {
    if (is_empty(part)) return;
    std::visit(
        [&](const auto& voxels) {
            for_each_y_z(part, [&](int y, int z) {
                const Vec3i start = first + Vec3i{part.begin.x, y, z};
                fetch(voxels.data() + voxel_index(m_volume->grid, start));
            });
        },
        m_volume->voxels);
}

bool MaterialMap::fill(Vec3i first, int size, const Box3i& part, MaterialId* out) const {
    fetch_early(first, part);
    const bool whole = part == Box3i{{0, 0, 0}, {size, size, size}};
    return std::visit(
        [&](const auto& voxels) {
            if (!m_labels.empty() || (m_has_air && size != AirBits::kSize)) {
                fill_one_by_one(first, size, out);
                lay_small_bones(first, size, part, out);
                return false;
            }
            if (!whole) std::fill_n(out, size * size * size, m_table.id(0, m_outside));
            const bool is_one = fill_by_value(voxels.data(), first, size, part, out);
            const bool has_air = m_has_air && lay_air(voxels.data(), first, out);
            return !lay_small_bones(first, size, part, out) && !has_air && is_one;
        },
        m_volume->voxels);
}

/// Looks up values, labels and air once for the cube and its surroundings.
void MaterialMap::fill_one_by_one(Vec3i first, int size, MaterialId* out) const {
    const int reach = m_has_air ? kSkinReach : 0, row = size + 2 * reach;
    constexpr auto kMaxRow = std::size_t(kMaxBrickSize + 2 * kSkinReach);
    std::array<unsigned char, kMaxRow * kMaxRow * kMaxRow> air;  // filling in must not fail
    std::fill_n(air.begin(), row * row * row, 0);
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
                    *out++ = m_table.id(1 + m_labels.law_at(e), number_at(e));
                }
            }
}

}  // namespace pliant
