// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The readable reference: one element at a time, the largest raise first.

#include <algorithm>
#include <queue>

#include "propagate/propagation.h"

namespace pliant {
namespace {

struct RaisedElement {
    Fixed raise;
    ElementRef element;
    friend bool operator<(const RaisedElement& a, const RaisedElement& b) {
        return a.raise < b.raise;
    }
};

bool is_cut(const Lattice& lattice, Vec3i low, int b) {
    if (!lattice.may_have_gaps()) return false;
    const BrickEdits* edits = lattice.edits_of(lattice.brick_of(low));
    return edits && ((*edits)[std::size_t(lattice.index_in_brick(low))] & (kCutX << b));
}

}  // namespace

Fixed link_lag(const Lattice& lattice, Vec3i element, int side, const ComponentPush& push) {
    const int b = side / 2;
    const bool up = side % 2;
    Vec3i to = element;
    to[b] += up ? 1 : -1;
    if (is_cut(lattice, up ? element : to, b)) return kUnlinked;
    const HalfLimits& half = lattice.materials()[lattice.material_at(element)];
    const HalfLimits& to_half = lattice.materials()[lattice.material_at(to)];
    const Fixed lag = up ? half_lag_forward(half, push, b) + half_lag_forward(to_half, push, b)
                         : half_lag_backward(half, push, b) + half_lag_backward(to_half, push, b);
    if (!lattice.may_exceed_limits()) return lag;
    const Fixed present = push.sign * (lattice.displacement_at(element)[push.axis] -
                                       lattice.displacement_at(to)[push.axis]);
    return std::max(lag, present);
}

void begin_raise(const Lattice& lattice, Brick& brick, const ComponentPush& push) {
    const auto axis = std::size_t(push.axis);
    if (brick.reached[axis]) return;
    brick.reached[axis] = true;
    const Fixed* u = brick.u[axis];
    Fixed* w = brick.raised[axis];
    for (int n = 0; n < lattice.elements_per_brick(); ++n) w[n] = push.sign * u[n];
}

bool propagate_by_heap(Lattice& lattice, std::span<const ElementRef> grabbed,
                       const ComponentPush& push, int max_bricks) {
    const auto axis = std::size_t(push.axis);
    std::priority_queue<RaisedElement> open;
    // Raises an element to w if that is above its position.
    const auto offer = [&](ElementRef element, Fixed w) {
        Brick& brick = lattice.brick(element.brick);
        begin_raise(lattice, brick, push);
        Fixed& current = brick.raised[axis][std::size_t(element.index)];
        if (w <= current) return;
        current = w;
        open.push({w - push.sign * brick.u[axis][std::size_t(element.index)], element});
    };
    for (const ElementRef& element : grabbed) {
        const Brick& brick = lattice.brick(element.brick);
        offer(element, push.sign * brick.u[axis][std::size_t(element.index)] + push.amount);
    }
    while (!open.empty()) {
        const RaisedElement candidate = open.top();
        open.pop();
        const auto from_index = std::size_t(candidate.element.index);
        const Brick& from = lattice.brick(candidate.element.brick);
        const Fixed w = from.raised[axis][from_index];
        if (w - push.sign * from.u[axis][from_index] != candidate.raise) continue;  // outdated
        const Vec3i ijk = lattice.element_of(from.coord, candidate.element.index);
        for (int side = 0; side < 6; ++side) {
            Vec3i to = ijk;
            to[side / 2] += side % 2 ? 1 : -1;
            const Fixed lag = link_lag(lattice, ijk, side, push);
            // An element without a brick is at rest; create one only if it moves.
            if (w - lag <= 0 && lattice.find_brick(lattice.brick_of(to)) < 0) continue;
            offer(lattice.ensure_element(to), w - lag);
        }
        if (lattice.resident_brick_count() > max_bricks) return false;
    }
    return true;
}

}  // namespace pliant
