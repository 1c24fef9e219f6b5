// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The material law, evaluated once for every voxel value and quantised towards tighter limits.
//
// A link's limit is the mean of its two ends times its length h, so each end contributes half:
// limit(i, j) = half(i) + half(j), half = ⌊h·fraction/2⌋ in fixed-point units.

#pragma once

#include <pliant/chainmail.h>

#include <cstdint>
#include <vector>

#include "chainmail/fixed_point.h"

namespace pliant {

/// Index into the table: the voxel value, shifted to be unsigned.
using MaterialId = std::uint16_t;

constexpr MaterialId material_from_hu(int value_hu) {
    const int shifted = value_hu + 32768;
    return MaterialId(shifted < 0 ? 0 : shifted > 65535 ? 65535 : shifted);
}

/// One value's contribution to the links along each axis [fixed-point units]. 44 bytes.
struct HalfLimits {
    Fixed compress[3];
    Fixed stretch[3];
    Fixed shear[3];
    Fixed max_movement;
    bool fixed;
};

class MaterialTable {
  public:
    MaterialTable(const MaterialLaw& law, Vec3d spacing_mm);

    const HalfLimits& operator[](MaterialId id) const { return m_entries[id]; }

  private:
    std::vector<HalfLimits> m_entries;  ///< 65,536
};

}  // namespace pliant
