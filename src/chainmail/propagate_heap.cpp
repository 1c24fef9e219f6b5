// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The readable reference: one element at a time, the largest raise first.

#include <queue>

#include "chainmail/propagation.h"

namespace pliant {
namespace {

struct Candidate {
    Fixed raise;
    ElementRef element;
    friend bool operator<(const Candidate& a, const Candidate& b) { return a.raise < b.raise; }
};

}  // namespace

void begin_raise(const Lattice& lattice, Brick& brick, const ComponentPush& push) {
    const auto axis = std::size_t(push.axis);
    if (brick.reached[axis]) return;
    brick.reached[axis] = true;
    const Fixed* u = brick.u[axis].get();
    Fixed* w = brick.raised[axis].get();
    for (int n = 0; n < lattice.elements_per_brick(); ++n) w[n] = push.sign * u[n];
}

bool propagate_by_heap(Lattice& lattice, std::span<const ElementRef> grabbed,
                       const ComponentPush& push, int max_bricks) {
    const auto axis = std::size_t(push.axis);
    std::priority_queue<Candidate> open;
    // Raises element to w if that is higher than where it is.
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
        const Candidate candidate = open.top();
        open.pop();
        const auto from_index = std::size_t(candidate.element.index);
        const Brick& from = lattice.brick(candidate.element.brick);
        const Fixed w = from.raised[axis][from_index];
        if (w - push.sign * from.u[axis][from_index] != candidate.raise) continue;  // outdated
        const HalfLimits& half = lattice.materials()[from.material[from_index]];
        const Vec3i ijk = lattice.element_of(from.coord, candidate.element.index);
        for (int side = 0; side < 6; ++side) {
            const int b = side / 2;
            const bool up = side % 2;
            Vec3i to = ijk;
            to[b] += up ? 1 : -1;
            const HalfLimits& to_half = lattice.materials()[lattice.material_at(to)];
            const Fixed lag =
                up ? half_lag_forward(half, push, b) + half_lag_forward(to_half, push, b)
                   : half_lag_backward(half, push, b) + half_lag_backward(to_half, push, b);
            // An element without a brick is at rest; make one only if it really moves.
            if (w - lag <= 0 && lattice.find_brick(lattice.brick_of(to)) < 0) continue;
            offer(lattice.ensure_element(to), w - lag);
        }
        if (lattice.resident_brick_count() > max_bricks) return false;
    }
    return true;
}

}  // namespace pliant
