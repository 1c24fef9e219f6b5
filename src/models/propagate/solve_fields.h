// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The unknowns of a brick-wise solve: the three components, or one raise that serves all of them
// (see propagation.h), for limits of both kinds.

#pragma once

#include <algorithm>
#include <functional>

#include "lattice/lattice.h"
#include "propagate/propagation.h"

namespace pliant {

class SolveFields {
  public:
    SolveFields(Lattice& lattice, Vec3<Fixed> shift, SweepWork& work)
        : m_lattice(lattice), m_work(work), m_components(components_of(shift)) {}

    /// Raises the grabbed elements, and decides whether the solve is shared.
    /// @param wake  (brick index, field)
    template <class Wake>
    void grab(std::span<const ElementRef> grabbed, const Wake& wake) {
        bool at_rest = m_work.may_share && !m_lattice.may_exceed_limits();
        Fixed largest = 0;
        for (const ElementRef& element : grabbed)
            at_rest &= is_at_rest(m_lattice.brick(element.brick));
        for (const ComponentPush& push : m_components) largest = std::max(largest, push.amount);
        m_work.shared = at_rest;
        m_work.shared_amount = largest;
        for (std::size_t c = 0; c < count(); ++c) {
            const ComponentPush push = field(c);
            if (push.amount == 0) continue;
            for (const ElementRef& element : grabbed) {
                Brick& brick = m_lattice.brick(element.brick);
                begin(brick, c);
                const auto n = std::size_t(element.index);
                const Fixed before = m_work.shared ? 0 : push.sign * brick.u[c][n];
                brick.raised[c][n] = before + push.amount;
                wake(element.brick, c);
            }
        }
    }

    std::size_t count() const { return m_work.shared ? 1 : 3; }
    /// Unknown of the solve: each component, or one raise for all.
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

    /// All components share one raise only in bricks at rest, of symmetric materials.
    bool can_share(const Brick& brick) const {
        return !(brick.traits & kAsymmetric) && is_at_rest(brick) && neighbours_rest(brick);
    }
    bool neighbours_rest(const Brick& brick) const {
        return std::all_of(brick.neighbours.begin(), brick.neighbours.end(), [&](int neighbour) {
            return neighbour < 0 || is_at_rest(m_lattice.brick(neighbour));
        });
    }

    /// Continues with each component separately. The raise so far is a lower bound of each
    /// component's fixed point, so nothing is lost.
    void share_no_longer(const TaskArena& arena) {
        m_work.shared = false;
        std::uint8_t moving = 0;
        for (std::size_t c = 0; c < 3; ++c)
            moving = std::uint8_t(moving | unsigned(m_components[c].amount > 0) << c);
        const auto split_some = [this, moving](std::int64_t begin, std::int64_t end) {
            for (auto n = std::size_t(begin); n < std::size_t(end); ++n) {
                const int index = m_work.touched[n];
                split(m_lattice.brick(index));
                // News of the shared raise is news of each component.
                SweepWork::Node& node = m_work.nodes[std::size_t(index)];
                for (std::uint8_t& fields : node.news) fields = fields ? moving : 0;
                node.own_news = node.own_news ? moving : 0;
            }
        };
        arena.for_each(std::int64_t(m_work.touched.size()), 16, std::ref(split_some));
    }

  private:
    void split(Brick& brick) const {
        if (!brick.reached[0]) return;
        if (brick.is_unplaced) m_lattice.place_at_rest(brick);
        brick.reached = {};
        const Fixed* shared = brick.raised[0];
        for (std::size_t c = 3; c-- > 0;) {  // the first is last: it overwrites the shared one
            if (m_components[c].amount == 0) continue;
            const Fixed less = m_work.shared_amount - m_components[c].amount;
            for (int n = 0; n < m_lattice.elements_per_brick(); ++n)
                brick.raised[c][n] = std::max(0, shared[n] - less);
            brick.reached[c] = true;
        }
    }

    Lattice& m_lattice;
    SweepWork& m_work;
    std::array<ComponentPush, 3> m_components;
};

}  // namespace pliant
