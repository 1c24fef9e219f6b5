// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Material of each element: by its label, if that has a material; else air, if it is enabled and
// the value is below the threshold; else by the main law and the value. Elements that are bone by
// value alone, in a piece too small for a bone, are stiff instead. Nothing else is stored per
// element.

#pragma once

#include <pliant/models/material.h>

#include <array>
#include <vector>

#include "material/air_bits.h"
#include "material/labels.h"
#include "material/material.h"
#include "material/small_bones.h"

namespace pliant {

class MaterialMap {
  public:
    /// Keeps a reference to the volume. @param laws  the first one applies to all elements
    MaterialMap(const Volume& volume, const std::vector<MaterialLaw>& laws);
    MaterialMap(const Volume& volume, const ChainMailSettings& settings)
        : MaterialMap(volume, resolve(settings, volume)) {}

    const MaterialTable& table() const { return m_table; }
    MaterialId at(Vec3i ijk) const;
    /// Writes the materials of a cube of elements, i fastest. @param part  of the cube inside of
    /// the scan
    /// @returns true only if the elements of the part have one material
    bool fill(Vec3i first, int size, const Box3i& part, MaterialId* out) const;
    /// Prefetches the values of the part.
    void fetch_early(Vec3i first, const Box3i& part) const;
    /// Limits of an element directly from its law, not from the quantised table.
    ElementLimits limits_at(Vec3i ijk) const;
    /// Whether an element above the threshold of bone is in a piece too small for a bone.
    bool is_small_bone(Vec3i ijk) const;
    /// Whether an element is in the scan and isn't air.
    bool is_tissue(Vec3i ijk) const;
    /// The scan's value, rounded to the scale of materials; the background beyond it.
    double value_at(Vec3i ijk) const { return m_scale.value_of(number_at(ijk)); }

  private:
    MaterialMap(const Volume& volume, const ResolvedSettings& resolved);
    /// Numbers on the scale.
    int number_of(std::int16_t value) const { return value; }
    int number_of(float value) const;
    int number_at(Vec3i ijk) const;
    bool is_air(Vec3i ijk) const;
    unsigned air_axes(Vec3i ijk) const;
    template <int kCount, class Voxel>
    unsigned air_of_row(const Voxel* voxels, Vec3i first) const;
    template <class Voxel>
    void look_around(const Voxel* voxels, Vec3i first, AirBits& air) const;
    template <class Voxel>
    bool lay_air(const Voxel* voxels, Vec3i first, MaterialId* out) const;
    template <class Voxel>
    bool fill_by_value(const Voxel* voxels, Vec3i first, int size, const Box3i& part,
                       MaterialId* out) const;
    void fill_one_by_one(Vec3i first, int size, MaterialId* out) const;
    SmallBones find_small_bones(double smallest_mm3) const;
    MaterialId stiff_id() const { return m_table.other_id(m_has_air ? int(m_air.size()) : 0); }
    /// Replaces the materials of elements in small bones. @returns whether there are any
    bool lay_small_bones(Vec3i first, int size, const Box3i& part, MaterialId* out) const;

    const Volume* m_volume;
    std::vector<MaterialLaw> m_laws;  ///< the main law, then the labels' laws
    std::array<ElementLimits, 8> m_air{};
    bool m_has_air = false;
    LookupScale m_scale;
    float m_per_value = 1, m_shift = 0;  ///< the scale, for rows of floats
    int m_air_below = 0;                 ///< numbers below it are air
    int m_outside = kAirHu;              ///< number of the background
    LabelMap m_labels;
    ElementLimits m_stiff;  ///< of small bones
    MaterialTable m_table;
    SmallBones m_small_bones;
};

/// Calls visit(y, z) for the rows of a box.
template <class Visit>
void for_each_y_z(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y) visit(y, z);
}

}  // namespace pliant
