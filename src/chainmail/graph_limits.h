// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What an element contributes to the limits of a link: half of what it would allow by itself,
// rounded towards tighter, so that limit = half of one end + half of the other, as in material.h.

#pragma once

#include <pliant/chainmail_graph.h>

#include "chainmail/fixed_point.h"

namespace pliant {

/// −low ≤ u(j) − u(i) ≤ high, one end's share [fixed-point units], both ≥ 0.
struct HalfLink {
    Vec3<Fixed> low, high;
};

/// @param offset_mm  from i to j at rest
HalfLink half_link(const ElementLimits& limits, Vec3d offset_mm);

/// @returns InvalidArgument that names the material and its field
Status check_materials(std::span<const ElementLimits> materials);

/// @returns InvalidArgument that names the element or the push
Status check_push(const ChainGraph& graph, std::span<const std::int32_t> elements, Vec3d push_mm);

inline Vec3d mm_from_units(Vec3<Fixed> units) {
    return {mm_from_units(units.x), mm_from_units(units.y), mm_from_units(units.z)};
}
inline Vec3<Fixed> units_from_mm(Vec3d mm) {
    return {units_from_mm(mm.x), units_from_mm(mm.y), units_from_mm(mm.z)};
}

}  // namespace pliant
