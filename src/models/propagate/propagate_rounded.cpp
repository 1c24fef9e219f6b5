// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The least raise under rounded limits (rounded_kernel.h): brick by brick, like the sweeps of the
// box. An element depends only on neighbours that are ahead of it, so bricks are visited in the
// order of their positions, as in fast marching, not in that of their raises: in a step of a drag
// nearly all raises are equal.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "propagate/propagation.h"
#include "propagate/rounded_kernel.h"
#include "propagate/solve_fields.h"
#include "propagate/sweep_lags.h"
#include "propagate/sweep_rounds.h"

namespace pliant {
namespace {

constexpr int kMaxFace = kMaxBrickSize * kMaxBrickSize;

/// Memory of a visit.
struct VisitMemory {
    struct Face {
        alignas(64) std::array<Fixed, kMaxFace> now, start, lag, before;
    };
    VisitLags lags;
    std::array<Face, 6> faces;
    alignas(64) std::array<Fixed, kMaxFace> own;
    std::vector<Fixed> start;
};

class RoundedSolver {
  public:
    RoundedSolver(Lattice& lattice, Vec3<Fixed> shift, const RoundedKernels& kernels,
                  SweepWork& work)
        : m_lattice(lattice),
          m_kernels(kernels.sweep),
          m_relax(kernels.relax),
          m_work(work),
          m_rounds(lattice, work, {kBuckets, kFewBricks, 1}),
          m_fields(lattice, shift, work) {
        m_kernels.arrange_x = plain_sweep_kernels().arrange_x;  // natural order
    }

    void grab(std::span<const ElementRef> grabbed) {
        // All visits read all faces, also those of grabbed bricks that would refuse to share.
        m_work.may_share =
            m_work.may_share && std::all_of(grabbed.begin(), grabbed.end(), [&](ElementRef e) {
                return m_fields.can_share(m_lattice.brick(e.brick));
            });
        m_fields.grab(grabbed, [&](int brick, std::size_t c) {
            m_rounds.wake(brick, 1).own_news |= std::uint8_t(1 << c);
        });
        m_depth = 1;
        for (std::size_t c = 0; c < m_fields.count(); ++c) {
            if (m_fields.field(c).amount == 0) continue;
            Fixed highest = -kUnlinked;
            for (const ElementRef& element : grabbed) {
                const Fixed* w = m_lattice.brick(element.brick).raised[c];
                highest = std::max(highest, w[element.index]);
            }
            m_highest[c] = highest;
            m_depth = std::max({m_depth, m_fields.field(c).amount, highest});
        }
    }

    bool run(const TaskArena& arena, int max_bricks) {
        return m_rounds.run(
            m_depth, arena, max_bricks, [this](int index, Wakes& wakes) { visit(index, wakes); },
            [&](bool refused) {
                if (!refused) return;
                m_fields.share_no_longer(arena);
                for (std::size_t c = 0; c < 3; ++c) m_highest[c] = m_fields.field(c).amount;
            });
    }

  private:
    using Wakes = SweepWork::Wakes;
    using Face = RoundedBrick::Face;

    // Visits take ten times as long as the box's.
    static constexpr int kBuckets = 64;
    static constexpr std::size_t kFewBricks = 4;

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    void visit(int index, Wakes& wakes) const {
        static thread_local VisitMemory memory;
        Brick& brick = m_lattice.brick(index);
        if (brick.is_blank) m_lattice.fill_in(brick);
        if (m_work.shared && !m_fields.can_share(brick)) {
            wakes.refused = true;
            return;
        }
        if (!m_work.shared && brick.is_unplaced) m_lattice.place_at_rest(brick);
        memory.lags.begin(m_lattice, brick, m_kernels, m_work.shared);
        SweepWork::Node& node = m_work.nodes[std::size_t(index)];
        const auto news = std::exchange(node.news, {});
        const unsigned own_news = std::exchange(node.own_news, std::uint8_t(0));
        for (std::size_t c = 0; c < m_fields.count(); ++c) {
            const bool is_new = own_news >> c & 1;
            const auto has_news = [&](std::uint8_t n) { return n >> c & 1; };
            if (is_new || std::any_of(news.begin(), news.end(), has_news))
                raise_field(brick, c, is_new, news, memory, wakes);
        }
    }

    void raise_field(Brick& brick, std::size_t c, bool is_new,
                     const std::array<std::uint8_t, 6>& news, VisitMemory& memory,
                     Wakes& wakes) const {
        const ComponentPush push = m_fields.field(c);
        const int size = m_lattice.brick_size();
        m_fields.begin(brick, c);
        RoundedBrick rounded{};
        rounded.size = size;
        rounded.w = brick.raised[c];
        rounded.is_new = is_new;
        rounded.start = start_of(brick, c, push, memory);
        for (int side = 0; side < 6; ++side) {
            const auto s = std::size_t(side);
            m_kernels.copy_face(rounded.w, size, side, memory.faces[s].before.data());
            load_face(brick, c, side, push, memory, rounded.faces[s]);
            rounded.faces[s].rose = news[s] >> c & 1;
        }
        rounded.lags = memory.lags.inside(push);
        m_relax(rounded);
        for (int side = 0; side < 6; ++side)
            wakes.offer(side, offer(brick, c, side, is_new, memory, rounded), 1u << c);
    }

    /// Positions before the push; null if the brick and its neighbours were at rest.
    const Fixed* start_of(const Brick& brick, std::size_t c, const ComponentPush& push,
                          VisitMemory& memory) const {
        if (m_work.shared || (is_at_rest(brick) && m_fields.neighbours_rest(brick))) return nullptr;
        memory.start.resize(std::size_t(m_lattice.elements_per_brick()));
        for (std::size_t n = 0; n < memory.start.size(); ++n)
            memory.start[n] = push.sign * brick.u[c][n];
        return memory.start.data();
    }

    /// The elements behind a face.
    void load_face(const Brick& brick, std::size_t c, int side, const ComponentPush& push,
                   VisitMemory& memory, Face& face) const {
        const int count = m_lattice.brick_size() * m_lattice.brick_size();
        VisitMemory::Face& to = memory.faces[std::size_t(side)];
        const int index = brick.neighbours[std::size_t(side)];
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        const bool rests = !there || is_at_rest(*there);
        const bool is_reached = there && there->reached[c];
        // Elements at rest are behind all that were not pushed back before.
        if (rests && !is_reached && lowest_of(brick, c, push) >= 0) return;
        if (there && !there->is_blank) {
            const Fixed* lags = memory.lags.behind_neighbour(side, push);
            std::copy(lags, lags + count, to.lag.data());
        } else {
            look_up_lags(brick, c, side, push, to.lag.data());
        }
        if (rests)
            std::fill_n(to.start.data(), count, 0);
        else
            copy_start(*there, c, side, push, to.start.data());
        if (is_reached)
            m_kernels.copy_face(there->raised[c], m_lattice.brick_size(), side ^ 1, to.now.data());
        else
            std::copy_n(to.start.data(), count, to.now.data());
        face.now = to.now.data();
        face.start = to.start.data();
        face.lag = to.lag.data();
    }

    /// Lower bound of the positions before the push.
    Fixed lowest_of(const Brick& brick, std::size_t c, const ComponentPush& push) const {
        if (m_work.shared) return 0;
        return push.sign > 0 ? brick.u_min[int(c)] : -brick.u_max[int(c)];
    }

    void copy_start(const Brick& brick, std::size_t c, int side, const ComponentPush& push,
                    Fixed* out) const {
        const int size = m_lattice.brick_size();
        m_kernels.copy_face(brick.u[c], size, side ^ 1, out);
        if (push.sign < 0)
            for (int n = 0; n < size * size; ++n) out[n] = -out[n];
    }

    /// Lags behind elements of a brick that is missing or not filled in, and so at rest.
    void look_up_lags(const Brick& brick, std::size_t c, int side, const ComponentPush& push,
                      Fixed* out) const {
        const int size = m_lattice.brick_size(), axis = side / 2;
        const bool up = side % 2;
        const MaterialTable& table = m_lattice.materials();
        // The flag of a cut is stored with the link's lower element.
        const BrickEdits* edits = m_lattice.edits_of(up ? brick.coord : coord_behind(brick, side));
        Vec3i local{0, 0, 0};
        for (int q = 0; q < size; ++q)
            for (int p = 0; p < size; ++p, ++out) {
                local[axis == 0 ? 1 : 0] = p;
                local[axis == 2 ? 1 : 2] = q;
                local[axis] = up ? size - 1 : 0;
                const auto own = std::size_t(local.x + size * (local.y + size * local.z));
                Vec3i behind = size * brick.coord + local;
                behind[axis] += up ? 1 : -1;
                const HalfLimits& half = table[brick.material[own]];
                const HalfLimits& their = table[m_lattice.material_at(behind)];
                *out =
                    up ? half_lag_backward(half, push, axis) + half_lag_backward(their, push, axis)
                       : half_lag_forward(half, push, axis) + half_lag_forward(their, push, axis);
                if (m_lattice.may_exceed_limits())
                    *out = std::max(*out, -push.sign * brick.u[c][own]);
                local[axis] = size - 1;  // of the link's lower element, in its brick
                const auto lower = std::size_t(local.x + size * (local.y + size * local.z));
                if (edits && (*edits)[lower] & (kCutX << axis)) *out = kUnlinked;
            }
    }

    /// How urgent a visit is to a brick that an element at w may raise, 1…depth.
    Fixed urgency(std::size_t c, Fixed w) const {
        const std::int64_t below_highest = std::int64_t(m_highest[c]) - w;
        return Fixed(std::clamp<std::int64_t>(m_depth - below_highest, 1, m_depth));
    }

    /// Urgency of the neighbour's visit; 0: no element of the face rose that may raise it.
    Fixed offer(const Brick& brick, std::size_t c, int side, bool is_new, VisitMemory& memory,
                const RoundedBrick& rounded) const {
        const int size = m_lattice.brick_size(), count = size * size;
        const auto s = std::size_t(side);
        const int index = brick.neighbours[s];
        if (index < 0 && m_lattice.is_beyond_border(coord_behind(brick, side))) return 0;
        const VisitMemory::Face& face = memory.faces[s];
        m_kernels.copy_face(rounded.w, size, side, memory.own.data());
        Fixed highest = kNeverLeads;
        const Fixed* own = memory.own.data();
        for (int n = 0; n < count; ++n) {
            const Fixed behind = rounded.faces[s].now ? rounded.faces[s].now[n] : 0;
            if (own[n] > behind && (is_new || own[n] > face.before[std::size_t(n)]))
                highest = std::max(highest, own[n]);
        }
        if (highest == kNeverLeads) return 0;
        return urgency(c, highest);
    }

    Lattice& m_lattice;
    SweepKernels m_kernels;
    RelaxRounded m_relax;
    SweepWork& m_work;
    SweepRounds m_rounds;
    SolveFields m_fields;
    Fixed m_depth = 1;                        ///< largest raise or position
    std::array<Fixed, 3> m_highest{0, 0, 0};  ///< of the grabbed elements, by field
};

}  // namespace

bool propagate_rounded(Lattice& lattice, std::span<const ElementRef> grabbed, Vec3<Fixed> shift,
                       const RoundedKernels& kernels, const TaskArena& arena, int max_bricks,
                       SweepWork& work) {
    RoundedSolver solver(lattice, shift, kernels, work);
    solver.grab(grabbed);
    return solver.run(arena, max_bricks);
}

}  // namespace pliant
