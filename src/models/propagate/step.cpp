// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "propagate/step.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <utility>

namespace pliant {
namespace {

/// Rounding the three components of a step towards zero can move its end by less than 2 units;
/// movement limits are satisfied with this margin [units].
constexpr double kRoundingMargin = 4;
constexpr std::int64_t kTouchedPerTask = 32;

using Raises = Vec3<Fixed>;  ///< of one element, each in 0…|shift_a|

/// First fraction at which |u(f)| exceeds the limit, or 1. Piecewise straight path: see step.h.
double fraction_within(Vec3<Fixed> u, Raises raise, Vec3<Fixed> shift, double limit) {
    const Vec3d start{double(u.x), double(u.y), double(u.z)};
    const double allowed = std::max(limit - kRoundingMargin, 0.0);
    // Each component moves in one direction, so the path stays in the box between its ends.
    Vec3d farthest = start;
    for (int a = 0; a < 3; ++a) {
        const double end = start[a] + (shift[a] > 0 ? raise[a] : -raise[a]);
        if (std::abs(end) > std::abs(farthest[a])) farthest[a] = end;
    }
    if (dot(farthest, farthest) <= allowed * allowed) return 1;
    const double bound = std::max(allowed * allowed, dot(start, start));
    double starts[5] = {0, 1, 1, 1, 1};  // start of each component's motion, and the end
    for (int a = 0; a < 3; ++a)
        if (shift[a] != 0) starts[a + 1] = 1 - raise[a] / std::abs(double(shift[a]));
    std::sort(starts, starts + 5);
    const auto position = [&](double f) {
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
        const Vec3d p = position(begin), q = position(end);
        if (dot(q, q) <= bound) continue;  // convex: the whole piece is inside
        // |p + t (q − p)|² = bound, the root with t ≥ 0.
        const Vec3d d = q - p;
        const double a = dot(d, d), b = dot(p, d), c = std::min(dot(p, p) - bound, 0.0);
        const double t = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
        return begin + std::clamp(t, 0.0, 1.0) * (end - begin);
    }
    return 1;
}

Vec3<Fixed> displacement(const Brick& brick, std::size_t n) {
    return {brick.u[0][n], brick.u[1][n], brick.u[2][n]};
}

/// Likewise; zero in a brick that has no displacements yet.
Vec3<Fixed> placed(const Brick& brick, std::size_t n) {
    return brick.is_unplaced ? Vec3<Fixed>{0, 0, 0} : displacement(brick, n);
}

/// Motion of an element for the whole shift.
Raises raise_in(const Brick& brick, const BrickMotion& motion, std::size_t n) {
    const Vec3<Fixed> u = placed(brick, n);
    Raises raise{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const MovingComponent& c = motion[std::size_t(a)];
        if (c.raised) raise[a] = std::max(0, c.raised[n] - c.left - c.sign * u[a]);
    }
    return raise;
}

bool is_reached(const Brick& brick) {
    return brick.reached[0] || brick.reached[1] || brick.reached[2];
}

/// The whole step of a brick, from a solve.
BrickMotion motion_of(const Brick& brick, const SweepWork& work, Vec3<Fixed> shift) {
    BrickMotion motion{};
    for (int a = 0; a < 3; ++a) {
        const auto c = std::size_t(a);
        const bool moves = shift[a] != 0 && (work.shared || brick.reached[c]);
        const Fixed less = work.shared ? work.shared_amount - std::abs(shift[a]) : 0;
        motion[c] = {brick.u[c], moves ? brick.raised[work.shared ? 0 : c] : nullptr, less,
                     shift[a] < 0 ? -1 : 1};
    }
    return motion;
}

/// From rest, the raise of the last moving component becomes its displacement in place: that halves
/// the memory traffic if it moves alone. The raise is not read afterwards.
void move_in_place(Brick& brick, BrickMotion& motion) {
    for (std::size_t a = 3; a-- > 0;) {
        if (!motion[a].raised) continue;
        auto& raised = *std::find(brick.raised.begin(), brick.raised.end(), motion[a].raised);
        std::swap(brick.u[a], raised);
        motion[a].u = brick.u[a];
        return;
    }
}

/// Largest distance of its elements from rest, along each axis.
Vec3d farthest_of(const Brick& brick) {
    Vec3d farthest{0, 0, 0};
    for (int a = 0; a < 3; ++a)
        farthest[a] = std::max(-double(brick.u_min[a]), double(brick.u_max[a]));
    return farthest;
}

/// Whether all of its elements may be shifted as a whole.
bool moves_freely(const Brick& brick, Vec3<Fixed> shift) {
    if (brick.is_blank || brick.traits & kFixedTrait) return false;
    Vec3d after = farthest_of(brick);
    for (int a = 0; a < 3; ++a) after[a] += std::abs(double(shift[a]));
    return stays_inside(brick.least_movement, after);
}

/// Test of the brick as a whole, which suffices for nearly all.
bool is_unlimited(const Lattice& lattice, const Brick& brick, const BrickMotion& motion,
                  const SweepKernels& kernels, Vec3<Fixed> shift) {
    if (moves_freely(brick, shift)) return true;
    if (brick.traits & kFixedTrait) return false;
    Vec3d after = farthest_of(brick);
    for (std::size_t a = 0; a < 3; ++a) {
        if (!motion[a].raised) continue;
        const Fixed highest = kernels.largest(motion[a].raised, lattice.elements_per_brick());
        after[int(a)] = std::max(after[int(a)], double(highest - motion[a].left));
    }
    return stays_inside(brick.least_movement, after);
}

}  // namespace

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

void tighten(StepLimit& limit, StepLimit other) {
    const bool bone = other.limited_by == LimitedBy::Bone && other.fraction == limit.fraction;
    if (other.fraction < limit.fraction || bone) limit = other;
}

bool stays_inside(Fixed least_movement, const Vec3d& farthest) {
    const double allowed = least_movement - kRoundingMargin;
    return allowed > 0 && dot(farthest, farthest) <= allowed * allowed;
}

StepLimit limit_of_brick(const Lattice& lattice, const Brick& brick, const BrickMotion& motion,
                         Vec3<Fixed> shift, bool with_fixed) {
    StepLimit limit;
    for (std::size_t n = 0; n < std::size_t(lattice.elements_per_brick()); ++n) {
        const Raises raise = raise_in(brick, motion, n);
        if (raise == Raises{0, 0, 0}) continue;
        const HalfLimits& half = lattice.materials()[brick.material[n]];
        if (with_fixed || !half.fixed)
            tighten(limit, limit_of_element(half, placed(brick, n), raise, shift));
    }
    return limit;
}

StepLimit limit_of_grabbed(const Lattice& lattice, std::span<const ElementRef> grabbed,
                           Vec3<Fixed> shift) {
    StepLimit limit;
    const Raises full{std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)};
    // They are sorted by brick, and a test of the brick as a whole suffices for most.
    int looked_at = -1;
    bool is_free = false;
    for (const ElementRef& element : grabbed) {
        const Brick& brick = lattice.brick(element.brick);
        if (element.brick != looked_at) is_free = moves_freely(brick, shift);
        looked_at = element.brick;
        if (is_free) continue;
        const auto n = std::size_t(element.index);
        tighten(limit, limit_of_element(lattice.materials()[brick.material[n]],
                                        displacement(brick, n), full, shift));
    }
    return limit;
}

StepLimit limit_of_reached(const Lattice& lattice, const SweepWork& work,
                           const SweepKernels& kernels, Vec3<Fixed> shift, const TaskArena& arena) {
    StepLimit limit;
    std::mutex mutex;
    const auto look = [&](std::int64_t begin, std::int64_t end) {
        StepLimit own;
        for (std::int64_t k = begin; k < end; ++k) {
            const Brick& brick = lattice.brick(work.touched[std::size_t(k)]);
            if (!is_reached(brick)) continue;
            const BrickMotion motion = motion_of(brick, work, shift);
            if (!is_unlimited(lattice, brick, motion, kernels, shift))
                tighten(own, limit_of_brick(lattice, brick, motion, shift, true));
        }
        const std::lock_guard lock(mutex);
        tighten(limit, own);
    };
    arena.for_each(std::int64_t(work.touched.size()), kTouchedPerTask, std::ref(look));
    return limit;
}

std::vector<Vec3i> bone_at_limit(const Lattice& lattice, const SweepWork& work, Vec3<Fixed> shift,
                                 double fraction) {
    std::vector<Vec3i> found;
    const int size = lattice.brick_size();
    for (const int index : work.touched) {
        const Brick& brick = lattice.brick(index);
        if (!is_reached(brick) || !(brick.traits & kFixedTrait)) continue;
        const BrickMotion motion = motion_of(brick, work, shift);
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const auto at = std::size_t(n);
            const HalfLimits& half = lattice.materials()[brick.material[at]];
            if (!half.fixed) continue;
            const Raises raise = raise_in(brick, motion, at);
            const StepLimit limit = limit_of_element(half, {0, 0, 0}, raise, shift);
            if (limit.limited_by == LimitedBy::Bone && limit.fraction <= fraction)
                found.push_back(size * brick.coord +
                                Vec3i{n % size, n / size % size, n / (size * size)});
        }
    }
    return found;
}

Vec3<Fixed> fraction_of(Vec3<Fixed> shift, double fraction) {
    if (fraction >= 1) return shift;
    return {Fixed(std::trunc(fraction * shift.x)), Fixed(std::trunc(fraction * shift.y)),
            Fixed(std::trunc(fraction * shift.z))};
}

int move_brick(const Lattice& lattice, Brick& brick, BrickMotion motion, Vec3<Fixed> shift,
               Vec3<Fixed> done, const SweepKernels& kernels) {
    for (int a = 0; a < 3; ++a)
        motion[std::size_t(a)].left += std::abs(shift[a]) - std::abs(done[a]);
    lattice.before_move(brick);
    for (std::size_t a = 0; a < 3; ++a)
        if (brick.is_unplaced && !motion[a].raised && !brick.holds_zeros[a])
            std::fill_n(brick.u[a], lattice.elements_per_brick(), 0);
    const MoveResult result = kernels.move(motion, lattice.elements_per_brick(), brick.is_unplaced);
    brick.is_unplaced = false;
    for (int a = 0; a < 3; ++a) {
        if (!motion[std::size_t(a)].raised) continue;
        brick.u_min[a] = result.u_min[std::size_t(a)];
        brick.u_max[a] = result.u_max[std::size_t(a)];
    }
    if (result.moved > 0) brick.changed_at = lattice.clock();
    return result.moved;
}

void reserve_moves(Lattice& lattice, const SweepWork& work) {
    if (lattice.observed_step() == 0) return;
    for (const int index : work.touched)
        if (Brick& brick = lattice.brick(index); is_reached(brick)) lattice.reserve_move(brick);
}

std::int64_t apply_shift(Lattice& lattice, const SweepWork& work, const SweepKernels& kernels,
                         Vec3<Fixed> shift, Vec3<Fixed> done, const TaskArena& arena) {
    std::atomic<std::int64_t> moved = 0;
    const auto move = [&](std::int64_t begin, std::int64_t end) {
        std::int64_t own = 0;
        for (std::int64_t k = begin; k < end; ++k) {
            Brick& brick = lattice.brick(work.touched[std::size_t(k)]);
            if (is_reached(brick)) {
                BrickMotion motion = motion_of(brick, work, shift);
                if (brick.is_unplaced) move_in_place(brick, motion);
                own += move_brick(lattice, brick, motion, shift, done, kernels);
            }
            brick.reached = {};
        }
        moved += own;
    };
    arena.for_each(std::int64_t(work.touched.size()), kTouchedPerTask, std::ref(move));
    return moved;
}

}  // namespace pliant
