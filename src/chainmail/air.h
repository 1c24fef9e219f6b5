// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Air as a material: compressed almost to nothing, stretched and sheared far, so that walls that
// face each other move independently until they touch, and then push each other.
//
//     wall   air   air   air   wall           a gap of n air elements has n + 1 links; each takes
//      o------o-----o-----o------o            the mean of its ends, so together they give way by
//        skin                skin             n·compress(air) + compress(wall): closed, the walls
//                                             are linked as if they were neighbours
//
// A link from tissue to air must not be drawn out like one in air: the scan's values along it would
// be drawn out too, and the wall would smear into the lumen. So along an axis with a wall on one
// side, an air element (*skin*) stretches and shears only as the main law's softest material does:
// the first layer of air clings to its wall, and what is drawn out is air on both ends. In a gap of
// one or two air elements there is no such link, and the skin is left out: the walls come apart
// freely, at the price of a smear between them.

#pragma once

#include <pliant/chainmail.h>

#include <array>

namespace pliant {

/// Limits of air, by the axes along which it is skin: bit 0 for i, 1 for j, 2 for k.
std::array<ElementLimits, 8> air_limits(const ChainMailSettings& settings);

/// Axes along which an air element is skin. @param is_air  (axis, steps) → whether the element that
/// many steps away along the axis is air
template <class IsAir>
unsigned skin_axes(const IsAir& is_air) {
    unsigned axes = 0;
    for (int b = 0; b < 3; ++b) {
        const bool low = is_air(b, -1), high = is_air(b, 1);
        if (low == high) continue;  // no wall, or one on either side
        // A wall on one side: skin unless the gap ends right behind the next element.
        const bool wide = is_air(b, high ? 2 : -2);
        axes |= unsigned(wide) << b;
    }
    return axes;
}

}  // namespace pliant
