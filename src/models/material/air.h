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
// Values along a stretched link are stretched with it: between tissue and air that would smear the
// wall into the lumen. So air clings to its wall. Along an axis the first elements beside a wall
// (*skin*) stretch and shear only like the main law's softest material, and the stretched links are
// further away, with only air on both ends. Skin is up to three elements deep, since scans blur a
// wall over about as many, and leaves at least one element in the middle of the gap. A gap of one
// or two elements has no skin: the walls come apart freely, at the price of a smear between them.

#pragma once

#include <pliant/models/material.h>

#include <array>

namespace pliant {

/// Limits of air, by the axes along which it is skin: bit 0 for i, 1 for j, 2 for k.
std::array<ElementLimits, 8> air_limits(const ChainMailSettings& settings);

/// Largest depth of skin [elements].
inline constexpr int kSkinDepth = 3;
/// Largest distance of the elements on which the skin state of an element depends.
inline constexpr int kSkinReach = kSkinDepth + 1;

/// Axes along which an air element is skin. @param is_air  (axis, steps) → whether the element that
/// many steps away along the axis is air; called for up to kSkinReach steps
template <class IsAir>
unsigned skin_axes(const IsAir& is_air) {
    // Steps to the wall on one side; kSkinReach + 1: farther.
    const auto distance = [&](int axis, int sign) {
        int steps = 1;
        while (steps <= kSkinReach && is_air(axis, sign * steps)) ++steps;
        return steps;
    };
    unsigned axes = 0;
    for (int b = 0; b < 3; ++b) {
        const int low = distance(b, -1), high = distance(b, 1);
        const int near = low < high ? low : high, far = low < high ? high : low;
        axes |= unsigned(near <= kSkinDepth && far >= near + 2) << b;
    }
    return axes;
}

}  // namespace pliant
