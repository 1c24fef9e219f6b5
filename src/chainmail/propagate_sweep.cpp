// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The default: bricks swept to their own fixed point, woken by their neighbours' faces. All
// components go together, so that a visit looks at materials and neighbours once.

#include <algorithm>
#include <utility>

#include "chainmail/propagation.h"
#include "chainmail/sweep_lags.h"
#include "chainmail/uniform_passes.h"

namespace pliant {
namespace {

/// Bricks whose pending raise is within this fraction of the push of the largest go in one round.
/// Smaller: fewer repeated sweeps, but shorter rounds.
constexpr int kBucketsPerPush = 16;
/// Rounds of fewer bricks are not worth a second thread.
constexpr std::size_t kFewBricks = 8;
constexpr std::int64_t kBricksPerTask = 4;

/// In Node::news beside the six sides: elements of the brick itself are grabbed.
constexpr std::uint8_t kGrabbedHere = 64, kAllSides = 63;

class SweepSolver {
  public:
    SweepSolver(Lattice& lattice, Vec3<Fixed> shift, const SweepKernels& kernels, SweepWork& work)
        : m_lattice(lattice), m_kernels(kernels), m_work(work), m_components(components_of(shift)) {
        work.touched.clear();
        work.active.clear();
    }

    void grab(std::span<const ElementRef> grabbed) {
        bool at_rest = m_work.may_share && !m_lattice.may_exceed_limits();
        Fixed largest = 0;
        for (const ElementRef& element : grabbed)
            at_rest &= is_at_rest(m_lattice.brick(element.brick));
        for (const ComponentPush& push : m_components) largest = std::max(largest, push.amount);
        m_work.shared = at_rest;
        m_work.shared_amount = largest;
        for (std::size_t c = 0; c < field_count(); ++c) {
            const ComponentPush push = field(c);
            if (push.amount == 0) continue;
            for (const ElementRef& element : grabbed) {
                Brick& brick = m_lattice.brick(element.brick);
                begin(brick, c);
                const auto n = std::size_t(element.index);
                const Fixed before = m_work.shared ? 0 : push.sign * brick.u[c][n];
                brick.raised[c][n] = before + push.amount;
                wake(element.brick, c, kGrabbedHere, push.amount);
            }
        }
    }

    bool run(const TaskArena& arena, int max_bricks) {
        bool fits = true;
        if (m_work.shared) pass_through_uniform(arena, max_bricks);
        while (fits && !m_work.active.empty()) {
            take_next_bucket();
            for (const std::vector<int>& round : m_work.round) {
                visit_all(round, arena);
                bool refused = false;
                for (std::size_t n = 0; n < round.size(); ++n) {
                    wake_neighbours(round[n], m_work.wakes[n]);
                    refused |= m_work.wakes[n].refused;
                }
                if (refused) share_no_longer(arena);
            }
            fits = m_lattice.resident_brick_count() <= max_bricks;
        }
        for (const int index : m_work.touched) m_work.nodes[std::size_t(index)] = {};
        return fits;
    }

  private:
    using Wakes = SweepWork::Wakes;
    using Node = SweepWork::Node;

    std::size_t field_count() const { return m_work.shared ? 1 : 3; }
    /// What is solved for: each component, or one raise for all.
    ComponentPush field(std::size_t c) const {
        return m_work.shared ? ComponentPush{0, 1, m_work.shared_amount} : m_components[c];
    }

    void begin(Brick& brick, std::size_t c) const {
        if (brick.reached[c]) return;
        brick.reached[c] = true;
        Fixed* w = brick.raised[c];
        const int count = m_lattice.elements_per_brick();
        if (m_work.shared || is_at_rest(brick)) {
            std::fill_n(w, count, 0);
            return;
        }
        const Fixed sign = m_components[c].sign;
        for (int n = 0; n < count; ++n) w[n] = sign * brick.u[c][n];
    }

    void wake(int index, std::size_t c, unsigned news, Fixed raise) {
        Node& node = m_work.touch(index, m_lattice.brick_index_bound());
        if (node.pending == 0) m_work.active.push_back(index);
        node.pending = std::max(node.pending, raise);
        node.news[c] = std::uint8_t(node.news[c] | news);
    }

    /// In one material at rest nothing has to be searched for. Elsewhere the search starts from
    /// what the passes raised.
    void pass_through_uniform(const TaskArena& arena, int max_bricks) {
        if (UniformPasses(m_lattice, m_kernels, m_work).run(arena, max_bricks)) {
            m_work.active.clear();
            return;
        }
        if (m_work.touched.size() == m_work.active.size()) return;
        for (std::size_t n = 0; n < m_work.touched.size(); ++n)
            wake(m_work.touched[n], 0, kGrabbedHere | kAllSides, m_work.shared_amount);
    }

    void wake_neighbours(int index, const Wakes& wakes) {
        if (wakes.refused) {
            // Back into the list; its news are still there.
            wake(index, 0, 0, m_work.shared_amount);
            return;
        }
        for (std::size_t c = 0; c < field_count(); ++c)
            for (int side = 0; side < 6; ++side) {
                const Fixed raise = wakes.raise[c][std::size_t(side)];
                if (raise == 0) continue;
                const Brick& brick = m_lattice.brick(index);
                int neighbour = brick.neighbours[std::size_t(side)];
                if (neighbour < 0) neighbour = m_lattice.ensure_blank_brick(behind(brick, side));
                wake(neighbour, c, 1u << (side ^ 1), raise);
            }
    }

    static Vec3i behind(const Brick& brick, int side) {
        Vec3i coord = brick.coord;
        coord[side / 2] += side % 2 ? 1 : -1;
        return coord;
    }

    /// Moves the most urgent bricks from the active list to this round's two colours.
    void take_next_bucket() {
        const auto pending = [&](int index) -> Fixed& {
            return m_work.nodes[std::size_t(index)].pending;
        };
        Fixed largest = 0;
        for (const int index : m_work.active) largest = std::max(largest, pending(index));
        const Fixed threshold = largest - m_work.shared_amount / kBucketsPerPush;
        for (auto& round : m_work.round) round.clear();
        std::erase_if(m_work.active, [&](int index) {
            if (pending(index) < threshold) return false;
            pending(index) = 0;
            // Nothing new since it was visited in the round that it was woken in.
            if (m_work.nodes[std::size_t(index)].news == std::array<std::uint8_t, 3>{}) return true;
            const Vec3i c = m_lattice.brick(index).coord;
            m_work.round[std::size_t((c.x + c.y + c.z) & 1)].push_back(index);
            return true;
        });
    }

    void visit_all(const std::vector<int>& round, const TaskArena& arena) {
        m_work.wakes.resize(std::max(m_work.wakes.size(), round.size()));
        const auto visit_some = [this, &round](std::int64_t begin, std::int64_t end) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n)
                visit(round[n], m_work.wakes[n]);
        };
        if (round.size() < kFewBricks)
            visit_some(0, std::int64_t(round.size()));
        else
            arena.for_each(std::int64_t(round.size()), kBricksPerTask, visit_some);
    }

    /// Brings one brick to its fixed point. Reads the neighbours, writes only the brick.
    void visit(int index, Wakes& wakes) {
        static thread_local VisitLags lags;
        Brick& brick = m_lattice.brick(index);
        wakes = {};
        if (brick.is_blank) m_lattice.fill_in(brick);
        if (m_work.shared && !can_share(brick)) {
            wakes.refused = true;
            return;
        }
        if (!m_work.shared && brick.is_unplaced) m_lattice.place_at_rest(brick);
        lags.begin(m_lattice, brick, m_kernels, m_work.shared);
        Node& node = m_work.nodes[std::size_t(index)];
        for (std::size_t c = 0; c < field_count(); ++c)
            if (node.news[c] != 0)
                raise_field(brick, c, std::exchange(node.news[c], 0), lags, wakes);
    }

    /// All components share one raise only among bricks at rest, of symmetric materials.
    bool can_share(const Brick& brick) const {
        if ((brick.traits & kAsymmetric) || !is_at_rest(brick)) return false;
        return std::all_of(brick.neighbours.begin(), brick.neighbours.end(), [&](int neighbour) {
            return neighbour < 0 || is_at_rest(m_lattice.brick(neighbour));
        });
    }

    void raise_field(Brick& brick, std::size_t c, unsigned news, VisitLags& lags,
                     Wakes& wakes) const {
        const ComponentPush push = field(c);
        const int size = m_lattice.brick_size();
        begin(brick, c);
        Fixed* w = brick.raised[c];
        std::uint32_t dirty = news & kGrabbedHere ? ~std::uint32_t(0) >> (32 - size) : 0;
        for (int side = 0; side < 6; ++side) {
            if (!(news >> side & 1)) continue;
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
        for (int side = 0; side < 6; ++side)
            wakes.raise[c][std::size_t(side)] = offer(brick, c, side, push, lags);
    }

    void relax_uniform(const Brick& brick, Fixed* w, const UniformLags& lags,
                       std::uint32_t dirty) const {
        // Links at the border don't bind, unlike the others. But ways inside a box never need to
        // leave it, so it is enough that nothing comes in from beyond.
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
        if (index < 0 && m_lattice.is_beyond_border(behind(brick, side))) return 0;
        const Brick* there = index < 0 ? nullptr : &m_lattice.brick(index);
        // Of a brick whose materials are not known yet, its rest place is enough for a bound. In a
        // shared solve a brick of asymmetric materials ends the sharing when it is visited.
        if (!there || there->is_blank || (m_work.shared && (there->traits & kAsymmetric)))
            return m_kernels.offer(w, size, side, lags.behind_face_at_least(side, push),
                                   {nullptr, nullptr, 1});
        return m_kernels.offer(w, size, side, lags.behind_face(side, push),
                               {there->reached[c] ? there->raised[c] : nullptr,
                                is_at_rest(*there) ? nullptr : there->u[c], push.sign});
    }

    /// Goes on with each component by itself. What was raised so far is on the way to each
    /// component's fixed point, so nothing is lost.
    void share_no_longer(const TaskArena& arena) {
        m_work.shared = false;
        const auto split_some = [this](std::int64_t begin, std::int64_t end) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
                const int index = m_work.touched[n];
                split(m_lattice.brick(index));
                Node& node = m_work.nodes[std::size_t(index)];
                for (std::size_t c = 3; c-- > 0;)
                    node.news[c] = m_components[c].amount > 0 ? node.news[0] : 0;
            }
        };
        arena.for_each(std::int64_t(m_work.touched.size()), 16, split_some);
    }

    void split(Brick& brick) const {
        if (!brick.reached[0]) return;
        if (brick.is_unplaced) m_lattice.place_at_rest(brick);
        brick.reached = {};
        const Fixed* shared = brick.raised[0];
        for (std::size_t c = 3; c-- > 0;) {  // the first last: it lies where the shared one was
            if (m_components[c].amount == 0) continue;
            const Fixed less = m_work.shared_amount - m_components[c].amount;
            for (int n = 0; n < m_lattice.elements_per_brick(); ++n)
                brick.raised[c][n] = std::max(0, shared[n] - less);
            brick.reached[c] = true;
        }
    }

    Lattice& m_lattice;
    const SweepKernels& m_kernels;
    SweepWork& m_work;
    std::array<ComponentPush, 3> m_components;
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
