// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The least raise under rounded limits (rounded.h): brick by brick, like the sweeps of the box,
// with the largest pending raise first, and bricks of one chessboard colour in parallel.

#include <algorithm>
#include <array>
#include <vector>

#include "material/limit_units.h"
#include "propagate/propagation.h"

namespace pliant {
namespace {

// Rounded limits: in addition to its box, a limit for the lag of an element behind its neighbours
// taken together.
//
//   Σ_b ( max(0, w_b − w_j) / lag_b )² ≤ 1
//
// where w_b is the neighbour of j on axis b that leads by the larger share of its link's lag. It is
// the upwind discretisation of |∇w| ≤ 1 in a metric, as in fast marching [Sethian1996]: the
// iso-surfaces of a push are ellipsoids instead of the octahedra of the box.
//
// An element with a larger lag (after pushes to and fro, or a change of materials) must not get
// worse: its bound is the value of the sum before the push. So the state before the push is valid,
// the least valid state above it exists, and a motion in one direction ends in the same position in
// one step or in many.
//
// The sum is evaluated with roundings that are monotone in every position: an exact difference, a
// product with a constant, a square, a sum of three in one order. So the update is a monotone map
// on integers, and its least fixed point is unique, independent of the order of updates.

/// The neighbours of one element, by side: −x, +x, −y, +y, −z, +z.
struct RoundedLinks {
    std::array<Fixed, 6> lag;     ///< largest lag of the element behind each
    std::array<double, 6> share;  ///< 1/lag; 0 where the link does not count

    void set(int side, Fixed link_lag) {
        const auto s = std::size_t(side);
        lag[s] = link_lag;
        // Rigid links are satisfied by the box alone; cut ones don't bind.
        share[s] = link_lag > 0 && link_lag < kMaxHalfLimit ? 1.0 / link_lag : 0.0;
    }
};

/// Shares of lag on each axis, before squaring, for an element at v.
inline Vec3d lag_shares(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    Vec3d shares{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const double below = (double(w[low]) - v) * links.share[low];
        const double above = (double(w[high]) - v) * links.share[high];
        shares[b] = std::max(0.0, std::max(below, above));
    }
    return shares;
}

inline double lag_sum(const RoundedLinks& links, const std::array<Fixed, 6>& w, Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    return t.x * t.x + t.y * t.y + t.z * t.z;
}

/// Lower bound of the rise from v at which the sum falls to the bound: the root of
/// Σ (t_b − q_b·x)² = bound over the axes that still contribute there. Neighbours that become the
/// largest of their axis on the way are ignored, so it may fall short.
/// @pre the sum at v is above the bound
inline double rounded_rise(const RoundedLinks& links, const std::array<Fixed, 6>& w, double bound,
                           Fixed v) {
    const Vec3d t = lag_shares(links, w, v);
    Vec3d q{};
    for (int b = 0; b < 3; ++b) {
        const auto low = std::size_t(2 * b), high = low + 1;
        const bool is_low = (double(w[low]) - v) * links.share[low] == t[b];
        q[b] = t[b] > 0 ? links.share[is_low ? low : high] : 0;
    }
    for (;;) {
        double qq = 0, qt = 0, tt = 0;
        int nearest = -1;  // the axis that ceases to contribute first
        for (int b = 0; b < 3; ++b) {
            if (q[b] == 0) continue;
            qq += q[b] * q[b];
            qt += q[b] * t[b];
            tt += t[b] * t[b];
            if (nearest < 0 || t[b] * q[nearest] < t[nearest] * q[b]) nearest = b;
        }
        const double under_root = qt * qt - qq * (tt - bound);
        const double rise =
            under_root >= 0 ? (tt - bound) / (qt + std::sqrt(under_root)) : HUGE_VAL;
        if (nearest < 0 || rise * q[nearest] <= t[nearest]) return nearest < 0 ? 0 : rise;
        q[nearest] = 0;
    }
}

/// Least position at or above v that satisfies every link's lag and the bound of the sum.
/// @pre bound ≥ 1
inline Fixed least_rounded_position(const RoundedLinks& links, const std::array<Fixed, 6>& w,
                                    double bound, Fixed v) {
    for (std::size_t s = 0; s < 6; ++s) v = std::max(v, w[s] - links.lag[s]);
    if (!(lag_sum(links, w, v) > bound)) return v;
    const Fixed lowest = v;
    do {
        const double rise = rounded_rise(links, w, bound, v);
        v += std::max(Fixed(1), Fixed(std::min(rise, double(kMaxHalfLimit))));
    } while (lag_sum(links, w, v) > bound);
    // The guess is only a start: the result is the crossing of the sum itself.
    while (v > lowest && !(lag_sum(links, w, v - 1) > bound)) --v;
    return v;
}

/// A round takes all bricks whose pending raise is within this fraction of the push of the largest.
constexpr int kBucketsPerPush = 16;

/// A brick's elements with one layer of neighbours around them.
struct Halo {
    int row = 0;
    std::vector<Fixed> start;  ///< before the push
    std::vector<Fixed> now;    ///< raised so far
    std::vector<MaterialId> material;
    std::vector<RoundedLinks> links;  ///< of the brick's own elements
    std::vector<double> bound;
    std::vector<char> waiting;  ///< whether a neighbour rose since the last update

    void resize(int size) {
        row = size + 2;
        const auto all = std::size_t(row) * std::size_t(row) * std::size_t(row);
        start.assign(all, 0);
        now.assign(all, 0);
        material.assign(all, kVoidMaterial);
        waiting.resize(all);
        const auto own = std::size_t(size) * std::size_t(size) * std::size_t(size);
        links.resize(own);
        bound.resize(own);
    }
    std::size_t index(Vec3i local) const {
        return std::size_t(local.x + 1 + row * (local.y + 1 + row * (local.z + 1)));
    }
    int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? row : row * row; }
    std::array<Fixed, 6> around(const std::vector<Fixed>& w, std::size_t n) const {
        const Fixed* here = w.data() + n;
        const int y = row, z = row * row;
        return {here[-1], here[1], here[-y], here[y], here[-z], here[z]};
    }
};

class RoundedSolver {
  public:
    RoundedSolver(Lattice& lattice, const ComponentPush& push)
        : m_lattice(lattice), m_push(push), m_size(lattice.brick_size()) {}

    void grab(ElementRef element) {
        Brick& brick = m_lattice.brick(element.brick);
        begin_raise(m_lattice, brick, m_push);
        brick.raised[axis()][std::size_t(element.index)] =
            m_push.sign * brick.u[axis()][std::size_t(element.index)] + m_push.amount;
        wake(element.brick, m_push.amount);
        m_is_new[std::size_t(element.brick)] = true;
    }

    bool run(const TaskArena& arena, int max_bricks) {
        while (!m_active.empty()) {
            take_next_bucket();
            for (const std::vector<int>& round : m_round) {
                m_wakes.resize(round.size());
                arena.for_each(std::int64_t(round.size()), 2,
                               [&](std::int64_t begin, std::int64_t end) {
                                   for (auto n = std::size_t(begin); n < std::size_t(end); ++n)
                                       m_wakes[n] = relax(round[n]);
                               });
                for (std::size_t n = 0; n < round.size(); ++n)
                    wake_neighbours(round[n], m_wakes[n]);
                if (m_lattice.resident_brick_count() > max_bricks) return false;
            }
        }
        return true;
    }

  private:
    using Wakes = std::array<Fixed, 6>;  ///< largest raise at each face that rose; 0: none

    std::size_t axis() const { return std::size_t(m_push.axis); }

    void wake(int brick, Fixed raise) {
        const auto n = std::size_t(brick);
        if (n >= m_pending.size()) {
            m_pending.resize(n + 1, 0);
            m_is_new.resize(n + 1, false);
        }
        if (m_pending[n] == 0) m_active.push_back(brick);
        m_pending[n] = std::max(m_pending[n], raise);
    }

    void wake_neighbours(int index, const Wakes& wakes) {
        m_is_new[std::size_t(index)] = false;
        for (int side = 0; side < 6; ++side) {
            if (wakes[std::size_t(side)] == 0) continue;
            Vec3i coord = m_lattice.brick(index).coord;
            coord[side / 2] += side % 2 ? 1 : -1;
            const int neighbour = m_lattice.ensure_brick(coord);
            begin_raise(m_lattice, m_lattice.brick(neighbour), m_push);
            wake(neighbour, wakes[std::size_t(side)]);
        }
    }

    void take_next_bucket() {
        Fixed largest = 0;
        for (const int brick : m_active) largest = std::max(largest, m_pending[std::size_t(brick)]);
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

    template <class Visit>
    void for_each_own(const Visit& visit) const {
        for (int z = 0, n = 0; z < m_size; ++z)
            for (int y = 0; y < m_size; ++y)
                for (int x = 0; x < m_size; ++x, ++n) visit(Vec3i{x, y, z}, std::size_t(n));
    }

    void load_own(Halo& halo, const Brick& brick) const {
        for_each_own([&](Vec3i local, std::size_t n) {
            const std::size_t at = halo.index(local);
            halo.start[at] = m_push.sign * brick.u[axis()][n];
            halo.now[at] = brick.raised[axis()][n];
            halo.material[at] = brick.material[n];
        });
    }

    /// The layer beyond one face.
    void load_face(Halo& halo, const Brick& brick, int side) const {
        const int found = brick.neighbours[std::size_t(side)];
        const Brick* there = found < 0 ? nullptr : &m_lattice.brick(found);
        const auto& own_face = m_lattice.face(side / 2, side % 2);
        const auto& their_face = m_lattice.face(side / 2, !(side % 2));
        for (std::size_t n = 0; n < own_face.size(); ++n) {
            const Vec3i e = m_lattice.element_of({0, 0, 0}, own_face[n]);
            Vec3i beyond = e;
            beyond[side / 2] += side % 2 ? 1 : -1;
            const std::size_t at = halo.index(beyond);
            if (!there) {
                halo.material[at] = m_lattice.material_at(m_size * brick.coord + beyond);
                continue;
            }
            const auto their = std::size_t(their_face[n]);
            halo.start[at] = m_push.sign * there->u[axis()][their];
            halo.now[at] = there->reached[axis()] ? there->raised[axis()][their] : halo.start[at];
            halo.material[at] = there->material[their];
        }
    }

    /// Whether the link from one of the brick's elements to its neighbour on a side is cut.
    bool is_cut(const Brick& brick, Vec3i local, std::size_t n, int side) const {
        const int b = side / 2, flag = kCutX << b;
        if (side % 2) return brick.edits && (brick.edits[n] & flag);
        if (local[b] > 0) return brick.edits && (brick.edits[n - m_lattice.stride(b)] & flag);
        Vec3i below = m_size * brick.coord + local;
        below[b] -= 1;
        const BrickEdits* edits = m_lattice.edits_of(m_lattice.brick_of(below));
        return edits && ((*edits)[std::size_t(m_lattice.index_in_brick(below))] & flag);
    }

    void find_links(Halo& halo, const Brick& brick) const {
        const MaterialTable& table = m_lattice.materials();
        for_each_own([&](Vec3i local, std::size_t n) {
            const std::size_t at = halo.index(local);
            const HalfLimits& own = table[halo.material[at]];
            for (int side = 0; side < 6; ++side) {
                const int b = side / 2;
                const std::size_t there =
                    side % 2 ? at + std::size_t(halo.stride(b)) : at - std::size_t(halo.stride(b));
                const HalfLimits& other = table[halo.material[there]];
                Fixed lag =
                    side % 2
                        ? half_lag_backward(own, m_push, b) + half_lag_backward(other, m_push, b)
                        : half_lag_forward(own, m_push, b) + half_lag_forward(other, m_push, b);
                if (m_lattice.may_exceed_limits())
                    lag = std::max(lag, halo.start[there] - halo.start[at]);
                halo.links[n].set(side, is_cut(brick, local, n, side) ? kUnlinked : lag);
            }
            const auto before = halo.around(halo.start, at);
            halo.bound[n] = std::max(1.0, lag_sum(halo.links[n], before, halo.start[at]));
        });
    }

    /// Updates one element. @returns whether it rose; its neighbours then need an update
    bool update(Halo& halo, std::size_t at, std::size_t n) const {
        const auto w = halo.around(halo.now, at);
        Fixed& here = halo.now[at];
        if (*std::max_element(w.begin(), w.end()) <= here) return false;
        const Fixed raised = least_rounded_position(halo.links[n], w, halo.bound[n], here);
        if (raised == here) return false;
        here = raised;
        for (int b = 0; b < 3; ++b) {
            const auto stride = std::size_t(halo.stride(b));
            halo.waiting[at - stride] = halo.waiting[at + stride] = 1;
        }
        return true;
    }

    /// One pass over the waiting elements, in one of the eight orders of the axes' directions: one
    /// of them follows a motion from any origin. @returns whether anything rose
    bool sweep(Halo& halo, unsigned order) const {
        bool changed = false;
        const int last = m_size - 1;
        const auto position = [&](int k, int axis) { return order >> axis & 1 ? last - k : k; };
        for (int k = 0; k < m_size; ++k)
            for (int j = 0; j < m_size; ++j) {
                const int y = position(j, 1), z = position(k, 2);
                const std::size_t first = halo.index({0, y, z});
                const std::size_t own = std::size_t(m_size) * std::size_t(y + m_size * z);
                for (int i = 0; i < m_size; ++i) {
                    const auto x = std::size_t(position(i, 0));
                    if (!halo.waiting[first + x]) continue;
                    halo.waiting[first + x] = 0;
                    changed |= update(halo, first + x, own + x);
                }
            }
        return changed;
    }

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    Wakes relax(int index) {
        static thread_local Halo halo;
        Brick& brick = m_lattice.brick(index);
        halo.resize(m_size);
        load_own(halo, brick);
        for (int side = 0; side < 6; ++side) load_face(halo, brick, side);
        find_links(halo, brick);
        std::fill(halo.waiting.begin(), halo.waiting.end(), char(1));
        // Opposite orders alternate.
        constexpr std::array<unsigned, 8> kOrders = {0, 7, 1, 6, 2, 5, 3, 4};
        for (std::size_t n = 0; sweep(halo, kOrders[n % kOrders.size()]); ++n) {
        }
        Wakes wakes{};
        for (int side = 0; side < 6; ++side)
            wakes[std::size_t(side)] = offer(halo, brick, side, m_is_new[std::size_t(index)]);
        for_each_own([&](Vec3i local, std::size_t n) {
            brick.raised[axis()][n] = halo.now[halo.index(local)];
        });
        return wakes;
    }

    /// Largest raise of a face element that rose and now leads its neighbour. @param is_new  rise
    /// since the push began, instead of since the load
    Fixed offer(const Halo& halo, const Brick& brick, int side, bool is_new) const {
        Fixed largest = 0;
        for (const int n : m_lattice.face(side / 2, side % 2)) {
            const Vec3i local = m_lattice.element_of({0, 0, 0}, n);
            Vec3i beyond = local;
            beyond[side / 2] += side % 2 ? 1 : -1;
            const std::size_t at = halo.index(local);
            const Fixed before = is_new ? halo.start[at] : brick.raised[axis()][std::size_t(n)];
            if (halo.now[at] > before && halo.now[at] > halo.now[halo.index(beyond)])
                largest = std::max(largest, halo.now[at] - halo.start[at]);
        }
        return largest;
    }

    Lattice& m_lattice;
    ComponentPush m_push;
    int m_size;
    std::vector<int> m_active;     ///< bricks with pending > 0
    std::vector<Fixed> m_pending;  ///< by brick index
    std::vector<char> m_is_new;    ///< [brick]: grabbed, and not relaxed yet
    std::array<std::vector<int>, 2> m_round;
    std::vector<Wakes> m_wakes;
};

}  // namespace

bool propagate_rounded(Lattice& lattice, std::span<const ElementRef> grabbed,
                       const ComponentPush& push, const TaskArena& arena, int max_bricks) {
    RoundedSolver solver(lattice, push);
    for (const ElementRef& element : grabbed) solver.grab(element);
    return solver.run(arena, max_bricks);
}

}  // namespace pliant
