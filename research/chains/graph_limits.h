// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contribution of an element to the limits of a link: half of the limit of a link between two such
// elements, rounded towards tighter. So limit = half of one end + half of the other, as in
// material.h.

#pragma once

#include <pliant/research/graph.h>

#include "material/limit_units.h"

namespace pliant {

/// −low ≤ u(j) − u(i) ≤ high, the share of one end [fixed-point units], both ≥ 0.
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
