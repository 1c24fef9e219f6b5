// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The two envelopes, component by component: bricks are swept until nothing changes, those of one
// chessboard colour in parallel. Only displaced elements are swept, in a copy of the brick with a
// layer of its neighbours around it, and with a precomputed bound for each link.

#include <algorithm>
#include <utility>

#include "relax/plastic.h"

namespace pliant {
namespace {

/// Limits of the elastic part, by material; never binding for a material that doesn't yield.
std::vector<HalfLimits> yield_limits(const MaterialTable& materials) {
    std::vector<HalfLimits> limits;
    for (int id = 0; id < materials.size(); ++id) {
        HalfLimits half = materials[MaterialId(id)];
        const auto yielded = [&](Fixed& limit) {
            limit = half.yield == 0 ? kMaxHalfLimit
                                    : Fixed(std::int64_t(limit) * half.yield / kWholeYield);
        };
        for (int b = 0; b < 3; ++b)
            yielded(half.compress[b]), yielded(half.stretch[b]), yielded(half.shear[b]);
        limits.push_back(half);
    }
    return limits;
}

/// An element away from its rest position: its index, and its index in the copy with a layer around
/// it.
struct Mover {
    int index, at;
};

/// Largest excess of sign·e of an element over its neighbour's, by the link's side.
using Rooms = std::array<Fixed, 6>;

struct FlowBrick {
    std::shared_ptr<const BrickLinks> links, yield;
    std::array<const Fixed*, 3> imprint{};   ///< null: none
    std::vector<Mover> movers;               ///< all others are at rest, and stay there
    std::vector<Rooms> rooms;                ///< [mover], for one component and sign
    std::vector<Fixed> envelope;             ///< envelope of sign·e
    std::array<std::vector<Fixed>, 3> kept;  ///< e'
    bool changed = true;
    bool wanted = true;
};

class Flow {
  public:
    Flow(const Lattice& lattice, const PlasticRest& rest, const TaskArena& arena)
        : m_lattice(lattice),
          m_arena(arena),
          m_maker(lattice),
          m_yield_maker(lattice, yield_limits(lattice.materials())) {
        m_bricks = lattice.resident_bricks();
        for (const int index : m_bricks)
            if (std::size_t(index) >= m_flows.size()) m_flows.resize(std::size_t(index) + 1);
        for_each_brick(m_bricks, [&](int index) { load(rest, index); });
    }

    void run(PlasticRest& rest) {
        for (int a = 0; a < 3; ++a) {
            const auto signs = find_signs(a);
            const bool negative = signs.first, positive = signs.second;
            if (!negative && !positive) continue;
            find_envelope(a, 1);
            std::vector<std::vector<Fixed>> low(m_flows.size());
            for (const int index : m_bricks)
                low[std::size_t(index)] = m_flows[std::size_t(index)].envelope;
            if (negative) find_envelope(a, -1);
            for_each_brick(m_bricks, [&](int index) {
                FlowBrick& flow = m_flows[std::size_t(index)];
                auto& kept = flow.kept[std::size_t(a)] = std::move(low[std::size_t(index)]);
                for (std::size_t n = 0; negative && n < kept.size(); ++n)
                    kept[n] = std::max(kept[n], std::min(-flow.envelope[n], 0));
            });
        }
        store(rest);
    }

  private:
    template <class Body>
    void for_each_brick(const std::vector<int>& bricks, const Body& body) {
        m_arena.for_each(std::int64_t(bricks.size()), 4, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t n = begin; n < end; ++n) body(bricks[std::size_t(n)]);
        });
    }

    void load(const PlasticRest& rest, int index) {
        const Brick& brick = m_lattice.brick(index);
        FlowBrick& flow = m_flows[std::size_t(index)];
        flow.links = m_maker.make(brick);
        flow.yield = m_yield_maker.make(brick);
        const PlasticBrick* imprint = rest.find(brick.coord);
        for (std::size_t a = 0; imprint && a < 3; ++a) flow.imprint[a] = imprint->imprint[a].data();
        for (int n = 0; n < m_lattice.elements_per_brick(); ++n) {
            bool moved = false;
            for (std::size_t a = 0; a < 3; ++a)
                moved |= brick.u[a][n] != 0 || (flow.imprint[a] && flow.imprint[a][n] != 0);
            if (moved) flow.movers.push_back({n, index_of(m_lattice.element_of({0, 0, 0}, n))});
        }
    }

    /// Index in the copy of a brick. @param local  −1…size along each axis
    int index_of(Vec3i local) const {
        const int row = m_lattice.brick_size() + 2;
        return local.x + 1 + row * (local.y + 1 + row * (local.z + 1));
    }

    Fixed elastic(int index, int a, std::size_t n) const {
        const Fixed* p = m_flows[std::size_t(index)].imprint[std::size_t(a)];
        return m_lattice.brick(index).u[std::size_t(a)][n] - (p ? p[n] : 0);
    }

    /// Whether component a of e is below zero anywhere, and above zero anywhere.
    std::pair<bool, bool> find_signs(int a) const {
        std::pair<bool, bool> found{false, false};
        for (const int index : m_bricks)
            for (std::size_t n = 0; n < std::size_t(m_lattice.elements_per_brick()); ++n) {
                const Fixed e = elastic(index, a, n);
                found.first |= e < 0;
                found.second |= e > 0;
            }
        return found;
    }

    /// Writes the largest state within yield that is not above sign·e to FlowBrick::envelope.
    void find_envelope(int a, int sign) {
        for_each_brick(m_bricks, [&](int index) {
            FlowBrick& flow = m_flows[std::size_t(index)];
            flow.envelope.resize(std::size_t(m_lattice.elements_per_brick()));
            for (std::size_t n = 0; n < flow.envelope.size(); ++n)
                flow.envelope[n] = sign * elastic(index, a, n);
            find_rooms(index, a, sign);
            flow.wanted = true;
        });
        std::vector<int> wanted;
        for (bool any = true; any;) {
            any = false;
            for (const bool odd : {false, true}) {
                wanted.clear();
                for (const int index : m_bricks) {
                    FlowBrick& flow = m_flows[std::size_t(index)];
                    if (is_odd(m_lattice.brick(index).coord) != odd || !flow.wanted) continue;
                    wanted.push_back(index);
                    flow.wanted = false;
                }
                for_each_brick(wanted, [&](int index) {
                    m_flows[std::size_t(index)].changed = lower_brick(index);
                });
                for (const int index : wanted) {
                    if (!m_flows[std::size_t(index)].changed) continue;
                    any = true;
                    for (const int beside : m_lattice.brick(index).neighbours)
                        if (beside >= 0) m_flows[std::size_t(beside)].wanted = true;
                }
            }
        }
    }

    /// Lowers a brick's envelope to its own fixed point. @returns whether anything changed
    bool lower_brick(int index) {
        FlowBrick& flow = m_flows[std::size_t(index)];
        std::vector<Fixed> w = copy_of(index);
        const int row = m_lattice.brick_size() + 2;
        const std::array<int, 6> to = {-1, 1, -row, row, -row * row, row * row};
        const auto lower = [&](std::size_t m) {
            Fixed* own = w.data() + flow.movers[m].at;
            std::int64_t lowest = *own;
            for (std::size_t side = 0; side < 6; ++side)
                lowest = std::min(lowest, std::int64_t(own[to[side]]) + flow.rooms[m][side]);
            return std::exchange(*own, Fixed(lowest)) != lowest;
        };
        bool changed_ever = false;
        for (bool changed = true; changed;) {
            changed = false;
            for (std::size_t m = 0; m < flow.movers.size(); ++m) changed |= lower(m);
            for (std::size_t m = flow.movers.size(); m-- > 0;) changed |= lower(m);
            changed_ever |= changed;
        }
        for (const Mover& mover : flow.movers)
            flow.envelope[std::size_t(mover.index)] = w[std::size_t(mover.at)];
        return changed_ever;
    }

    /// Envelope of a brick and of the elements beside it; zero where there is no brick.
    std::vector<Fixed> copy_of(int index) const {
        const int size = m_lattice.brick_size(), row = size + 2;
        std::vector<Fixed> copy(std::size_t(row * row * row), 0);
        const std::vector<Fixed>& own = m_flows[std::size_t(index)].envelope;
        for (int z = 0; z < size; ++z)
            for (int y = 0; y < size; ++y)
                std::copy_n(own.begin() + size * (y + size * z), size,
                            copy.begin() + index_of({0, y, z}));
        for (int side = 0; side < 6; ++side) {
            const int beside = m_lattice.brick(index).neighbours[std::size_t(side)];
            if (beside < 0) continue;
            const std::vector<Fixed>& other = m_flows[std::size_t(beside)].envelope;
            const int b = side / 2, across = side % 2 ? size : -size;
            for (const int n : m_lattice.face(b, side % 2 == 0)) {
                Vec3i local = m_lattice.element_of({0, 0, 0}, n);
                local[b] += across;
                copy[std::size_t(index_of(local))] = other[std::size_t(n)];
            }
        }
        return copy;
    }

    void find_rooms(int index, int a, int sign) {
        const Brick& brick = m_lattice.brick(index);
        FlowBrick& flow = m_flows[std::size_t(index)];
        const int size = m_lattice.brick_size();
        flow.rooms.resize(flow.movers.size());
        for (std::size_t m = 0; m < flow.movers.size(); ++m) {
            const int n = flow.movers[m].index;
            const Vec3i local = m_lattice.element_of({0, 0, 0}, n);
            const Fixed u = brick.u[std::size_t(a)][n];
            for (int side = 0; side < 6; ++side) {
                const int b = side / 2, stride = m_lattice.stride(b);
                const bool high = side % 2;
                const bool leaves = local[b] == (high ? size - 1 : 0);
                const int there = leaves ? brick.neighbours[std::size_t(side)] : index;
                const int other = n + (high ? stride : -stride) * (leaves ? 1 - size : 1);
                const Fixed v = there < 0 ? 0 : m_lattice.brick(there).u[std::size_t(a)][other];
                const Vec3i strides = link_strides(size, b);
                const auto link = std::size_t(dot(local, strides) + (high ? strides[b] : 0));
                flow.rooms[m][std::size_t(side)] = room_above(
                    flow, a, b, link, high, sign, high ? std::int64_t(v) - u : std::int64_t(u) - v);
            }
        }
    }

    /// Largest excess of sign·e of an element over its neighbour's on the high or low side.
    /// @param stretched  u of the upper end minus u of the lower one
    static Fixed room_above(const FlowBrick& flow, int a, int b, std::size_t link, bool high,
                            int sign, std::int64_t stretched) {
        const auto axis = std::size_t(b);
        const bool has_own = a == b && !flow.links->stretch[axis].empty();
        // Bound of the difference upper − lower; as in plastic.h, so that the imprint stays valid.
        const auto upward = [&] {
            const Fixed yield = (has_own ? flow.yield->stretch : flow.yield->shear)[axis][link];
            const Fixed own = (has_own ? flow.links->compress : flow.links->shear)[axis][link];
            return std::min<std::int64_t>(yield, std::max<std::int64_t>(0, own + stretched));
        };
        const auto downward = [&] {
            const Fixed yield = (has_own ? flow.yield->compress : flow.yield->shear)[axis][link];
            const Fixed own = (has_own ? flow.links->stretch : flow.links->shear)[axis][link];
            return std::min<std::int64_t>(yield, std::max<std::int64_t>(0, own - stretched));
        };
        return Fixed((sign > 0) != high ? upward() : downward());  // at most the yield limit
    }

    void store(PlasticRest& rest) {
        ImprintMap changes;
        for (const int index : m_bricks) {
            const Brick& brick = m_lattice.brick(index);
            FlowBrick& flow = m_flows[std::size_t(index)];
            Imprint imprint;
            bool changed = false;
            for (std::size_t a = 0; a < 3; ++a) {
                imprint[a].resize(std::size_t(m_lattice.elements_per_brick()));
                for (std::size_t n = 0; n < imprint[a].size(); ++n) {
                    const Fixed old = flow.imprint[a] ? flow.imprint[a][n] : 0;
                    imprint[a][n] = flow.kept[a].empty() ? old : brick.u[a][n] - flow.kept[a][n];
                    changed |= imprint[a][n] != old;
                }
            }
            if (changed) changes[brick.coord].imprint = std::move(imprint);
        }
        rest.prepare(m_lattice, changes);
        rest.exchange(m_lattice, changes);
        rest.finish(changes);
    }

    const Lattice& m_lattice;
    const TaskArena& m_arena;
    BrickLinksMaker m_maker, m_yield_maker;
    std::vector<int> m_bricks;
    std::vector<FlowBrick> m_flows;  ///< by brick index
};

}  // namespace

bool any_yields(const MaterialTable& materials) {
    for (int id = 0; id < materials.size(); ++id)
        if (materials[MaterialId(id)].yield != 0) return true;
    return false;
}

void flow(const Lattice& lattice, PlasticRest& rest, const TaskArena& arena) {
    if (any_yields(lattice.materials())) Flow(lattice, rest, arena).run(rest);
}

}  // namespace pliant
