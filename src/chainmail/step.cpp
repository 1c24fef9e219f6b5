// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/step.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>

namespace pliant {
namespace {

/// Rounding the three components of a step towards zero can move its end by less than 2 units;
/// movement limits are met with this margin [units].
constexpr double kRoundingMargin = 4;

using Raises = Vec3<Fixed>;  ///< of one element, each between 0 and |shift_a|

/// First fraction at which |u(f)| exceeds the limit, or 1. Piecewise straight path: see step.h.
double fraction_within(Vec3<Fixed> u, Raises raise, Vec3<Fixed> shift, double limit) {
    const Vec3d start{double(u.x), double(u.y), double(u.z)};
    const double allowed = std::max(limit - kRoundingMargin, 0.0);
    // Each component moves one way, so the path stays in the box between its ends.
    Vec3d farthest = start;
    for (int a = 0; a < 3; ++a) {
        const double end = start[a] + (shift[a] > 0 ? raise[a] : -raise[a]);
        if (std::abs(end) > std::abs(farthest[a])) farthest[a] = end;
    }
    if (dot(farthest, farthest) <= allowed * allowed) return 1;
    const double bound = std::max(allowed * allowed, dot(start, start));
    double starts[5] = {0, 1, 1, 1, 1};  // where each component begins to move, and the end
    for (int a = 0; a < 3; ++a)
        if (shift[a] != 0) starts[a + 1] = 1 - raise[a] / std::abs(double(shift[a]));
    std::sort(starts, starts + 5);
    const auto place = [&](double f) {
        Vec3d p = start;
        for (int a = 0; a < 3; ++a) {
            const double amount = std::abs(double(shift[a]));
            const double moved = std::max(0.0, raise[a] - (1 - f) * amount);
            p[a] += shift[a] > 0 ? moved : -moved;
        }
        return p;
    };
    for (int piece = 0; piece < 4; ++piece) {
        const double begin = starts[piece], end = starts[piece + 1];
        if (end <= begin) continue;
        const Vec3d p = place(begin), q = place(end);
        if (dot(q, q) <= bound) continue;  // convex: the whole piece is inside
        // |p + t (q − p)|² = bound, the root with t ≥ 0.
        const Vec3d d = q - p;
        const double a = dot(d, d), b = dot(p, d), c = std::min(dot(p, p) - bound, 0.0);
        const double t = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
        return begin + std::clamp(t, 0.0, 1.0) * (end - begin);
    }
    return 1;
}

/// @returns the bound that one element sets; limited_by None if none
StepLimit limit_of_element(const HalfLimits& half, Vec3<Fixed> u, Raises raise, Vec3<Fixed> shift) {
    if (half.fixed) {
        double fraction = 1;
        for (int a = 0; a < 3; ++a)
            if (raise[a] > 0)
                fraction = std::min(fraction, 1 - raise[a] / std::abs(double(shift[a])));
        return {fraction, fraction < 1 ? LimitedBy::Bone : LimitedBy::None};
    }
    const double fraction = fraction_within(u, raise, shift, half.max_movement);
    return {fraction, fraction < 1 ? LimitedBy::Movement : LimitedBy::None};
}

/// The smaller fraction; bone before movement where they are equal.
void tighten(StepLimit& limit, StepLimit other) {
    const bool bone = other.limited_by == LimitedBy::Bone && other.fraction == limit.fraction;
    if (other.fraction < limit.fraction || bone) limit = other;
}

Vec3<Fixed> displacement(const Brick& brick, std::size_t n) {
    return {brick.u[0][n], brick.u[1][n], brick.u[2][n]};
}

Raises raises(const Brick& brick, std::size_t n, Vec3<Fixed> shift) {
    Raises raise{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const auto axis = std::size_t(a);
        if (!brick.reached[axis]) continue;
        const Fixed u = brick.u[axis][n];
        raise[a] = brick.raised[axis][n] - (shift[a] > 0 ? u : -u);
    }
    return raise;
}

bool is_reached(const Brick& brick) {
    return brick.reached[0] || brick.reached[1] || brick.reached[2];
}

}  // namespace

StepLimit limit_of_grabbed(const Lattice& lattice, std::span<const ElementRef> grabbed,
                           Vec3<Fixed> shift) {
    StepLimit limit;
    const Raises full{std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)};
    for (const ElementRef& element : grabbed) {
        const Brick& brick = lattice.brick(element.brick);
        const auto n = std::size_t(element.index);
        tighten(limit, limit_of_element(lattice.materials()[brick.material[n]],
                                        displacement(brick, n), full, shift));
    }
    return limit;
}

StepLimit limit_of_reached(const Lattice& lattice, std::span<const int> bricks, Vec3<Fixed> shift,
                           const TaskArena& arena) {
    StepLimit limit;
    std::mutex mutex;
    arena.for_each(std::int64_t(bricks.size()), 16, [&](std::int64_t begin, std::int64_t end) {
        StepLimit own;
        for (std::int64_t k = begin; k < end; ++k) {
            const Brick& brick = lattice.brick(bricks[std::size_t(k)]);
            if (!is_reached(brick)) continue;
            for (std::size_t n = 0; n < std::size_t(lattice.elements_per_brick()); ++n) {
                const Raises raise = raises(brick, n, shift);
                if (raise == Raises{0, 0, 0}) continue;
                tighten(own, limit_of_element(lattice.materials()[brick.material[n]],
                                              displacement(brick, n), raise, shift));
            }
        }
        const std::lock_guard lock(mutex);
        tighten(limit, own);
    });
    return limit;
}

Vec3<Fixed> fraction_of(Vec3<Fixed> shift, double fraction) {
    if (fraction >= 1) return shift;
    return {Fixed(std::trunc(fraction * shift.x)), Fixed(std::trunc(fraction * shift.y)),
            Fixed(std::trunc(fraction * shift.z))};
}

std::int64_t apply_shift(Lattice& lattice, std::span<const int> bricks, Vec3<Fixed> shift,
                         Vec3<Fixed> done, const TaskArena& arena) {
    std::vector<std::int64_t> moved(bricks.size(), 0);
    arena.for_each(std::int64_t(bricks.size()), 16, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t k = begin; k < end; ++k) {
            Brick& brick = lattice.brick(bricks[std::size_t(k)]);
            if (!is_reached(brick)) continue;
            for (std::size_t n = 0; n < std::size_t(lattice.elements_per_brick()); ++n) {
                const Raises raise = raises(brick, n, shift);
                bool any = false;
                for (int a = 0; a < 3; ++a) {
                    Fixed& u = brick.u[std::size_t(a)][n];
                    const Fixed left_undone = std::abs(shift[a]) - std::abs(done[a]);
                    if (const Fixed step = raise[a] - left_undone; step > 0) {
                        u += shift[a] > 0 ? step : -step;
                        any = true;
                    }
                }
                moved[std::size_t(k)] += any;
            }
            if (moved[std::size_t(k)] > 0) brick.changed_at = lattice.clock();
            brick.reached = {};
            lattice.update_bounds(bricks[std::size_t(k)]);
        }
    });
    std::int64_t total = 0;
    for (const std::int64_t count : moved) total += count;
    return total;
}

void discard_raises(Lattice& lattice, std::span<const int> bricks) {
    for (const int index : bricks) lattice.brick(index).reached = {};
}

}  // namespace pliant
