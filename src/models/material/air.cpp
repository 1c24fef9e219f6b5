// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/air.h"

#include "material/limit_units.h"
#include "material/material.h"

namespace pliant {

std::array<ElementLimits, 8> air_limits(const ChainMailSettings& settings) {
    const ElementLimits soft = draeger_limits(settings, settings.range.low);
    std::array<ElementLimits, 8> limits;
    for (unsigned axes = 0; axes < 8; ++axes) {
        ElementLimits& air = limits[axes];
        air.max_movement_mm = kMaxMovementMm;
        for (int b = 0; b < 3; ++b) {
            const bool is_skin = axes >> b & 1;
            air.compress[b] = settings.air_compress;
            air.stretch[b] = is_skin ? soft.stretch[b] : settings.air_stretch;
            air.shear[b] = is_skin ? soft.shear[b] : settings.air_shear;
        }
    }
    return limits;
}

}  // namespace pliant
