// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which material each element has: by its label, if that has a material; else air, if it is enabled
// and the value is below the threshold; else the main law by value. Nothing is stored per element.

#pragma once

#include <pliant/chainmail.h>

#include <array>
#include <vector>

#include "chainmail/labels.h"
#include "chainmail/material.h"

namespace pliant {

class MaterialMap {
  public:
    /// Keeps a reference to the volume. @param laws  the first one is for all elements
    MaterialMap(const Volume& volume, const std::vector<MaterialLaw>& laws);
    MaterialMap(const Volume& volume, const ChainMailSettings& settings);

    const MaterialTable& table() const { return m_table; }
    MaterialId at(Vec3i ijk) const;
    /// Materials of a cube of elements, i fastest.
    void fill(Vec3i first, int size, MaterialId* out) const;
    /// Limits of an element straight from its law, not from the quantised table.
    ElementLimits limits_at(Vec3i ijk) const;
    /// The scan's value, rounded; air beyond it [HU].
    int value_at(Vec3i ijk) const;

  private:
    bool is_air(Vec3i ijk) const;
    unsigned air_axes(Vec3i ijk) const;
    bool is_uniformly_tissue(Vec3i first, int size) const;
    void fill_with_air(Vec3i first, int size, MaterialId* out) const;

    const Volume* m_volume;
    std::vector<MaterialLaw> m_laws;  ///< the main one, then those of labels
    std::array<ElementLimits, 8> m_air{};
    bool m_has_air = false;
    double m_air_threshold_hu = 0;
    LabelMap m_labels;
    MaterialTable m_table;
};

}  // namespace pliant
