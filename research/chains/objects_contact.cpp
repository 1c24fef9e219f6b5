// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chains/objects_contact.h"

#include <algorithm>
#include <cstdlib>

namespace pliant {

OverlapTime overlap_time(std::int64_t distance, std::int64_t reach, Fixed raise, Fixed shift) {
    // Mirrored so that motion increases the distance.
    const std::int64_t start = shift < 0 ? -distance : distance;
    const std::int64_t amount = std::abs(std::int64_t(shift));
    const std::int64_t to_enter = -reach - start, to_leave = reach - start;
    if (to_leave <= 0) return {};
    // Time at which the element has moved by an amount: 1 − (raise − moved)/amount.
    const auto time = [&](std::int64_t moved) { return Ratio{amount - raise + moved, amount}; };
    OverlapTime overlap;
    if (to_enter < 0)
        overlap.enter = kBefore;
    else if (raise > to_enter)
        overlap.enter = time(to_enter);
    if (raise >= to_leave) overlap.leave = time(to_leave);
    return overlap;
}

Impact impact_of(const Position& distance, const Position& reach, Vec3<Fixed> raise,
                 Vec3<Fixed> shift) {
    Impact impact{kBefore, kAfter, 0};
    for (int a = 0; a < 3; ++a) {
        const OverlapTime time = overlap_time(distance[a], reach[a], raise[a], shift[a]);
        if (impact.enter < time.enter) impact.enter = time.enter;
        if (!(time.leave < impact.leave)) continue;
        impact.leave = time.leave;
        impact.leave_axis = a;
    }
    return impact;
}

Ratio wall_time(std::int64_t gap, int side, Fixed raise, Fixed shift) {
    if (raise <= gap || (shift > 0) == (side > 0)) return kAfter;
    const std::int64_t amount = std::abs(std::int64_t(shift));
    return {amount - raise + gap, amount};
}

Vec3<Fixed> ratio_of(Vec3<Fixed> shift, Ratio fraction) {
    Vec3<Fixed> part{};
    for (int a = 0; a < 3; ++a)  // integer division rounds towards zero
        part[a] = Fixed(shift[a] * fraction.num / fraction.den);
    return part;
}

}  // namespace pliant
