// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The default: bricks swept to their own fixed point, rows as vector lanes, woken by their faces.

#include <algorithm>
#include <array>
#include <vector>

#include "chainmail/propagation.h"

namespace pliant {
namespace {

/// Bricks whose pending raise is within this fraction of the push of the largest go in one round.
/// Smaller: fewer repeated sweeps, but shorter rounds.
constexpr int kBucketsPerPush = 8;

/// Lags of the links inside one brick, by their lower element. Shear lags are the same both ways.
struct BrickLags {
    std::array<std::vector<Fixed>, 3> forward;
    std::array<std::vector<Fixed>, 3> backward;

    void resize(std::size_t n) {
        for (auto* lags : {&forward, &backward})
            for (auto& axis : *lags) axis.resize(n);
    }
};

void gather_lags(const Lattice& lattice, const Brick& brick, const ComponentPush& push,
                 BrickLags& lags) {
    const auto n = std::size_t(lattice.elements_per_brick());
    lags.resize(n);
    for (int b = 0; b < 3; ++b) {
        Fixed* forward = lags.forward[std::size_t(b)].data();
        Fixed* backward = lags.backward[std::size_t(b)].data();
        for (std::size_t i = 0; i < n; ++i) {
            const HalfLimits& half = lattice.materials()[brick.material[i]];
            forward[i] = half_lag_forward(half, push, b);
            backward[i] = half_lag_backward(half, push, b);
        }
        const auto stride = std::size_t(lattice.stride(b));
        for (std::size_t i = 0; i + stride < n; ++i) {
            forward[i] += forward[i + stride];
            backward[i] += backward[i + stride];
        }
        if (brick.edits)
            for (std::size_t i = 0; i + stride < n; ++i)
                if (brick.edits[i] & (kCutX << b)) forward[i] = backward[i] = kUnlinked;
        if (!lattice.may_exceed_limits()) continue;
        const Fixed* u = brick.u[std::size_t(push.axis)];
        for (std::size_t i = 0; i + stride < n; ++i) {
            const Fixed present = push.sign * (u[i] - u[i + stride]);
            forward[i] = std::max(forward[i], present);
            backward[i] = std::max(backward[i], -present);
        }
    }
}

/// to[i] = max(to[i], from[i] − lag[i]). @returns nonzero if anything changed
Fixed raise_lanes(Fixed* to, const Fixed* from, const Fixed* lag, int count) {
    Fixed changed = 0;
    for (int i = 0; i < count; ++i) {
        const Fixed old = to[i];
        const Fixed raised = std::max(old, from[i] - lag[i]);
        changed |= raised ^ old;
        to[i] = raised;
    }
    return changed;
}

Fixed sweep_x(Fixed* w, const BrickLags& lags, int size) {
    Fixed changed = 0;
    for (int row = 0; row < size * size; ++row, w += size) {
        const Fixed* forward = lags.forward[0].data() + row * size;
        const Fixed* backward = lags.backward[0].data() + row * size;
        for (int x = 0; x + 1 < size; ++x) changed |= raise_lanes(w + x + 1, w + x, forward + x, 1);
        for (int x = size - 2; x >= 0; --x)
            changed |= raise_lanes(w + x, w + x + 1, backward + x, 1);
    }
    return changed;
}

/// Along y (rows of a slice) or z (whole slices): lines of `lanes` elements, `lines` of them.
Fixed sweep_lines(Fixed* w, const Fixed* forward, const Fixed* backward, int lanes, int lines) {
    Fixed changed = 0;
    for (int line = 0; line + 1 < lines; ++line)
        changed |=
            raise_lanes(w + (line + 1) * lanes, w + line * lanes, forward + line * lanes, lanes);
    for (int line = lines - 2; line >= 0; --line)
        changed |=
            raise_lanes(w + line * lanes, w + (line + 1) * lanes, backward + line * lanes, lanes);
    return changed;
}

void sweep_to_fixed_point(Fixed* w, const BrickLags& lags, int size) {
    const int slice = size * size;
    for (Fixed changed = 1; changed;) {
        changed = sweep_x(w, lags, size);
        for (int z = 0; z < size; ++z)
            changed |= sweep_lines(w + z * slice, lags.forward[1].data() + z * slice,
                                   lags.backward[1].data() + z * slice, size, size);
        changed |= sweep_lines(w, lags.forward[2].data(), lags.backward[2].data(), slice, size);
    }
}

class SweepSolver {
  public:
    SweepSolver(Lattice& lattice, const ComponentPush& push) : m_lattice(lattice), m_push(push) {}

    void grab(ElementRef element) {
        Brick& brick = m_lattice.brick(element.brick);
        begin_raise(m_lattice, brick, m_push);
        brick.raised[axis()][std::size_t(element.index)] =
            m_push.sign * brick.u[axis()][std::size_t(element.index)] + m_push.amount;
        wake(element.brick, m_push.amount);
    }

    bool run(const TaskArena& arena, int max_bricks) {
        while (!m_active.empty()) {
            take_next_bucket();
            for (int colour = 0; colour < 2; ++colour) {
                const std::vector<int>& round = m_round[std::size_t(colour)];
                m_wakes.resize(round.size());
                arena.for_each(std::int64_t(round.size()), 4,
                               [&](std::int64_t begin, std::int64_t end) {
                                   for (auto n = std::size_t(begin); n < std::size_t(end); ++n)
                                       m_wakes[n] = relax(m_lattice.brick(round[n]));
                               });
                for (std::size_t n = 0; n < round.size(); ++n)
                    wake_neighbours(round[n], m_wakes[n]);
                if (m_lattice.resident_brick_count() > max_bricks) return false;
            }
        }
        return true;
    }

  private:
    /// Largest raise that a brick offers to each neighbour; 0: none.
    using Wakes = std::array<Fixed, 6>;

    std::size_t axis() const { return std::size_t(m_push.axis); }

    void wake(int brick, Fixed raise) {
        if (std::size_t(brick) >= m_pending.size()) m_pending.resize(std::size_t(brick) + 1, 0);
        Fixed& pending = m_pending[std::size_t(brick)];
        if (pending == 0) m_active.push_back(brick);
        pending = std::max(pending, raise);
    }

    void wake_neighbours(int index, const Wakes& wakes) {
        for (int side = 0; side < 6; ++side) {
            const Fixed raise = wakes[std::size_t(side)];
            if (raise == 0) continue;
            Vec3i coord = m_lattice.brick(index).coord;
            coord[side / 2] += side % 2 ? 1 : -1;
            const int neighbour = m_lattice.ensure_brick(coord);
            begin_raise(m_lattice, m_lattice.brick(neighbour), m_push);
            wake(neighbour, raise);
        }
    }

    /// Moves the most urgent bricks from the active list to this round's two colours.
    void take_next_bucket() {
        Fixed largest = 0;
        for (int brick : m_active) largest = std::max(largest, m_pending[std::size_t(brick)]);
        const Fixed threshold = largest - m_push.amount / kBucketsPerPush;
        for (auto& round : m_round) round.clear();
        std::erase_if(m_active, [&](int brick) {
            Fixed& pending = m_pending[std::size_t(brick)];
            if (pending < threshold) return false;
            pending = 0;
            const Vec3i c = m_lattice.brick(brick).coord;
            m_round[std::size_t((c.x + c.y + c.z) & 1)].push_back(brick);
            return true;
        });
    }

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    Wakes relax(Brick& brick) const {
        static thread_local BrickLags lags;
        Fixed* w = brick.raised[axis()];
        for (int side = 0; side < 6; ++side) take_from_neighbour(brick, side, w);
        gather_lags(m_lattice, brick, m_push, lags);
        sweep_to_fixed_point(w, lags, m_lattice.brick_size());
        Wakes wakes{};
        for (int side = 0; side < 6; ++side)
            wakes[std::size_t(side)] = offer_to_neighbour(brick, side, w);
        return wakes;
    }

    /// Half of the lag of a link from an element to its neighbour on a side.
    Fixed half_lag(MaterialId material, int side) const {
        const HalfLimits& half = m_lattice.materials()[material];
        return side % 2 ? half_lag_forward(half, m_push, side / 2)
                        : half_lag_backward(half, m_push, side / 2);
    }
    /// How far element `to`, the neighbour of element `from` on a side, may lag behind it.
    Fixed face_lag(const Brick& from_brick, std::size_t from, const Brick& to_brick, std::size_t to,
                   int side) const {
        const std::uint8_t* edits = side % 2 ? from_brick.edits : to_brick.edits;
        if (edits && (edits[side % 2 ? from : to] & (kCutX << side / 2))) return kUnlinked;
        const Fixed lag =
            half_lag(from_brick.material[from], side) + half_lag(to_brick.material[to], side);
        if (!m_lattice.may_exceed_limits()) return lag;
        const Fixed present = m_push.sign * (from_brick.u[axis()][from] - to_brick.u[axis()][to]);
        return std::max(lag, present);
    }

    void take_from_neighbour(const Brick& brick, int side, Fixed* w) const {
        const int index = brick.neighbours[std::size_t(side)];
        if (index < 0) return;
        const Brick& there = m_lattice.brick(index);
        if (!there.reached[axis()]) return;  // at its old place, which is feasible
        const auto& own_face = m_lattice.face(side / 2, side % 2);
        const auto& their_face = m_lattice.face(side / 2, !(side % 2));
        const Fixed* their_w = there.raised[axis()];
        for (std::size_t n = 0; n < own_face.size(); ++n) {
            const auto own = std::size_t(own_face[n]), their = std::size_t(their_face[n]);
            w[own] =
                std::max(w[own], their_w[their] - face_lag(there, their, brick, own, side ^ 1));
        }
    }

    Fixed offer_to_neighbour(const Brick& brick, int side, const Fixed* w) const {
        const int index = brick.neighbours[std::size_t(side)];
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        const auto& own_face = m_lattice.face(side / 2, side % 2);
        const auto& their_face = m_lattice.face(side / 2, !(side % 2));
        Fixed offer = 0;
        for (std::size_t n = 0; n < own_face.size(); ++n) {
            const int own = own_face[n];
            const auto their = std::size_t(their_face[n]);
            Fixed before = 0, now = 0;
            if (there) {
                before = m_push.sign * there->u[axis()][their];
                now = there->reached[axis()] ? there->raised[axis()][their] : before;
            }
            if (w[own] <= now) continue;
            const Fixed lag =
                there ? face_lag(brick, std::size_t(own), *there, their, side)
                      : link_lag(m_lattice, m_lattice.element_of(brick.coord, own), side, m_push);
            if (w[own] - lag > now) offer = std::max(offer, w[own] - lag - before);
        }
        return offer;
    }

    Lattice& m_lattice;
    ComponentPush m_push;
    std::vector<int> m_active;     ///< bricks with pending > 0
    std::vector<Fixed> m_pending;  ///< by brick index: largest raise offered to it
    std::array<std::vector<int>, 2> m_round;
    std::vector<Wakes> m_wakes;
};

}  // namespace

bool propagate_by_sweeps(Lattice& lattice, std::span<const ElementRef> grabbed,
                         const ComponentPush& push, const TaskArena& arena, int max_bricks) {
    SweepSolver solver(lattice, push);
    for (const ElementRef& element : grabbed) solver.grab(element);
    return solver.run(arena, max_bricks);
}

}  // namespace pliant
