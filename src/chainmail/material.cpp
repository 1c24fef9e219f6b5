// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/material.h"

#include <algorithm>

namespace pliant {

MaterialLaw draeger_law(const ChainMailSettings& settings) {
    return [offset = settings.offset, max_movement_mm = settings.max_movement_mm,
            bone_threshold_hu = settings.bone_threshold_hu](int value_hu) {
        // The thesis divides by 4096 in its text and keeps values up to 4095; with 4095 the
        // hardest value gets exactly no play.
        const double w = std::clamp((value_hu + 1000) / 4095.0, 0.0, 1.0);
        const double softness = 1 - w * w;
        const double region = offset * softness;
        return ElementLimits{.compress = {region, region, region},
                             .stretch = {region, region, region},
                             .shear = {region, region, region},
                             .max_movement_mm = softness * max_movement_mm,
                             .fixed = value_hu > bone_threshold_hu};
    };
}

MaterialTable::MaterialTable(const MaterialLaw& law, Vec3d spacing_mm) : m_entries(65536) {
    for (int id = 0; id < 65536; ++id) {
        const ElementLimits limits = law(id - 32768);
        HalfLimits& half = m_entries[std::size_t(id)];
        for (int b = 0; b < 3; ++b) {
            half.compress[b] = limit_units_from_mm(spacing_mm[b] * limits.compress[b] / 2);
            half.stretch[b] = limit_units_from_mm(spacing_mm[b] * limits.stretch[b] / 2);
            half.shear[b] = limit_units_from_mm(spacing_mm[b] * limits.shear[b] / 2);
        }
        half.max_movement =
            Fixed(std::floor(std::min(limits.max_movement_mm, kMaxMovementMm) * kUnitsPerMm));
        half.fixed = limits.fixed;
    }
}

}  // namespace pliant
