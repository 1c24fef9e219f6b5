// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The default solver: bricks are swept to their own fixed point, and woken by their neighbours'
// faces. All components are solved together, so that a visit reads materials and neighbours once.

#include <algorithm>
#include <functional>
#include <utility>

#include "propagate/propagation.h"
#include "propagate/solve_fields.h"
#include "propagate/sweep_lags.h"
#include "propagate/sweep_rounds.h"
#include "propagate/uniform_passes.h"

namespace pliant {
namespace {

class SweepSolver {
  public:
    SweepSolver(Lattice& lattice, Vec3<Fixed> shift, const SweepKernels& kernels, SweepWork& work)
        : m_lattice(lattice),
          m_kernels(kernels),
          m_work(work),
          m_rounds(lattice, work),
          m_fields(lattice, shift, work) {}

    void grab(std::span<const ElementRef> grabbed) {
        m_fields.grab(grabbed, [&](int brick, std::size_t c) {
            m_rounds.wake(brick, m_fields.field(c).amount).own_news |= std::uint8_t(1 << c);
        });
    }

    bool run(const TaskArena& arena, int max_bricks) {
        if (m_work.shared) pass_through_uniform(arena, max_bricks);
        return m_rounds.run(
            m_work.shared_amount, arena, max_bricks,
            [this](int index, Wakes& wakes) { visit(index, wakes); },
            [&](bool refused) {
                if (refused) m_fields.share_no_longer(arena);
            });
    }

  private:
    using Wakes = SweepWork::Wakes;
    using Node = SweepWork::Node;

    /// One material at rest needs no search. Elsewhere the search starts from the raise of the
    /// passes.
    void pass_through_uniform(const TaskArena& arena, int max_bricks) {
        if (UniformPasses(m_lattice, m_kernels, m_work).run(arena, max_bricks)) {
            m_work.active.clear();
            return;
        }
        if (m_work.touched.size() == m_work.active.size()) return;
        for (std::size_t n = 0; n < m_work.touched.size(); ++n)
            m_rounds.wake(m_work.touched[n], m_work.shared_amount).add_all_news(1);
    }

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    void visit(int index, Wakes& wakes) {
        static thread_local VisitLags lags;
        Brick& brick = m_lattice.brick(index);
        if (brick.is_blank) m_lattice.fill_in(brick);
        if (m_work.shared && !m_fields.can_share(brick)) {
            wakes.refused = true;
            return;
        }
        if (!m_work.shared && brick.is_unplaced) m_lattice.place_at_rest(brick);
        lags.begin(m_lattice, brick, m_kernels, m_work.shared);
        Node& node = m_work.nodes[std::size_t(index)];
        const auto news = std::exchange(node.news, {});
        const unsigned own_news = std::exchange(node.own_news, std::uint8_t(0));
        for (std::size_t c = 0; c < m_fields.count(); ++c)
            raise_field(brick, c, own_news >> c & 1, news, lags, wakes);
    }

    void raise_field(Brick& brick, std::size_t c, bool is_new,
                     const std::array<std::uint8_t, 6>& news, VisitLags& lags, Wakes& wakes) const {
        const ComponentPush push = m_fields.field(c);
        const int size = m_lattice.brick_size();
        const bool any = std::any_of(news.begin(), news.end(), [&](auto n) { return n >> c & 1; });
        if (!any && !is_new) return;
        m_fields.begin(brick, c);
        Fixed* w = brick.raised[c];
        std::uint32_t dirty = is_new ? ~std::uint32_t(0) >> (32 - size) : 0;
        for (int side = 0; side < 6; ++side) {
            if (!(news[std::size_t(side)] >> c & 1)) continue;
            const int index = brick.neighbours[std::size_t(side)];
            if (index < 0 || !m_lattice.brick(index).reached[c]) continue;
            const Brick& there = m_lattice.brick(index);
            dirty |=
                m_kernels.take(w, size, side, there.raised[c], lags.behind_neighbour(side, push));
        }
        if (dirty == 0) return;
        if (lags.is_uniform())
            relax_uniform(brick, w, lags.uniform(push), dirty);
        else
            m_kernels.relax(w, size, lags.inside(push), dirty);
        if (m_work.may_skip_cancelled && brick.traits & kFixedTrait)
            wakes.cancelled = std::max(wakes.cancelled, cancelled_by(brick, c, push));
        const Fixed skipped = cancelled_of(push);
        for (int side = 0; side < 6; ++side) {
            const Fixed offered = offer(brick, c, side, push, lags);
            if (offered > skipped) wakes.offer(side, offered, 1u << c);
        }
    }

    /// Part of the push that the fixed elements of a brick cancel: the raise that they would have.
    double cancelled_by(const Brick& brick, std::size_t c, const ComponentPush& push) const {
        Fixed highest = 0;
        const std::uint8_t* traits = m_lattice.materials().traits();
        for (std::size_t n = 0; n < std::size_t(m_lattice.elements_per_brick()); ++n) {
            if (!(traits[brick.material[n]] & kFixedTrait)) continue;
            const Fixed before = m_work.shared ? 0 : push.sign * brick.u[c][n];
            highest = std::max(highest, brick.raised[c][n] - before);
        }
        return highest / double(push.amount);
    }

    /// Raises up to this one are surely cancelled, and so are the raises that would follow.
    Fixed cancelled_of(const ComponentPush& push) const {
        constexpr double kRoundingMargin = 4;
        return Fixed(std::max(0.0, m_work.cancelled * push.amount - kRoundingMargin));
    }

    void relax_uniform(const Brick& brick, Fixed* w, const UniformLags& lags,
                       std::uint32_t dirty) const {
        // Links at the border don't bind, unlike the others. But a shortest path inside a box never
        // has to leave it, so it suffices that nothing enters from beyond.
        const bool partly = brick.traits & kPartlyBeyond;
        if (partly && !is_at_rest(brick)) m_lattice.set_beyond(brick, w, -kUnlinked);
        m_kernels.relax_uniform(w, m_lattice.brick_size(), lags, dirty);
        if (partly) m_lattice.set_beyond(brick, w, 0);
    }

    Fixed offer(const Brick& brick, std::size_t c, int side, const ComponentPush& push,
                VisitLags& lags) const {
        const int index = brick.neighbours[std::size_t(side)];
        const Fixed* w = brick.raised[c];
        const int size = m_lattice.brick_size();
        if (index < 0 && m_lattice.is_beyond_border(coord_behind(brick, side))) return 0;
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        // For a brick with unknown materials, its rest position suffices for a bound. In a shared
        // solve a brick of asymmetric materials ends the sharing when it is visited.
        if (!there || there->is_blank || (m_work.shared && (there->traits & kAsymmetric)))
            return m_kernels.offer(w, size, side, lags.behind_face_at_least(side, push),
                                   {nullptr, nullptr, 1});
        return m_kernels.offer(w, size, side, lags.behind_face(side, push),
                               {there->reached[c] ? there->raised[c] : nullptr,
                                is_at_rest(*there) ? nullptr : there->u[c], push.sign});
    }

    Lattice& m_lattice;
    const SweepKernels& m_kernels;
    SweepWork& m_work;
    SweepRounds m_rounds;
    SolveFields m_fields;
};

}  // namespace

bool propagate_by_sweeps(Lattice& lattice, std::span<const ElementRef> grabbed, Vec3<Fixed> shift,
                         const SweepKernels& kernels, const TaskArena& arena, int max_bricks,
                         SweepWork& work) {
    SweepSolver solver(lattice, shift, kernels, work);
    solver.grab(grabbed);
    return solver.run(arena, max_bricks);
}

}  // namespace pliant
