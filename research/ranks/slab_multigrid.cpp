// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ranks/slab_multigrid.h"

#include <utility>

namespace pliant {
namespace {

// As in fem/multigrid.cpp.
constexpr int kDegree = 2;
constexpr double kUpperPart = 8;

/// a += factor · b
void add_scaled(NodeVector& a, double factor, const NodeVector& b) {
    for (int axis = 0; axis < 3; ++axis)
        for (std::int64_t n = 0; n < a.node_count(); ++n)
            a.component(axis)[n] += factor * b.component(axis)[n];
}

}  // namespace

struct SlabMultigrid::Level {
    LatticePair pair;  ///< from the level above; not of the first level
    Slabs slabs;
    double greatest;  ///< bound of the spectrum
    const LatticeStiffness* stiffness;
    const HeldNodes* held;
    std::unique_ptr<LatticeStiffness> own_stiffness{};
    std::unique_ptr<HeldNodes> own_held{};
    std::unique_ptr<BlockJacobi> blocks{};
    NodeVector force{0}, displacement{0}, residual{0}, step{0}, product{0};

    void make_vectors() {
        force = NodeVector(node_count(pair.coarse));
        displacement = residual = step = product = force;
    }
};

/// Levels that every rank has as a whole.
struct SlabMultigrid::Rest {
    Slabs slabs;       ///< of the forces, before they are gathered
    LatticePair down;  ///< from the slab above to a slab
    LatticePair up;    ///< from the whole to the slab above
    std::unique_ptr<LatticeStiffness> stiffness;
    std::unique_ptr<HeldNodes> held;
    std::unique_ptr<Multigrid> multigrid;
    std::unique_ptr<Multigrid::Work> work;
    NodeVector slab_force;
};

SlabMultigrid::~SlabMultigrid() = default;

SlabMultigrid::SlabMultigrid(const Parts& parts, std::span<const ElasticMaterial> materials,
                             const TaskArena& arena)
    : m_arena(arena) {
    const HexLattice local = parts.slabs.local();
    m_levels.push_back(std::make_unique<Level>(Level{{local, local, {1, 1, 1}},
                                                     parts.slabs,
                                                     spectrum_bound(local.spacing_mm, materials),
                                                     &parts.stiffness,
                                                     &parts.held}));
    // Planes at a slab's end lack the cells beyond, so their blocks come from the whole stiffness.
    const auto complete = [&](Level& level, const LatticeStiffness& stiffness) {
        const auto first = std::int64_t(level.slabs.plane()) * level.slabs.low();
        level.blocks = std::make_unique<BlockJacobi>(stiffness, *level.held, arena, first);
        level.make_vectors();
    };
    complete(*m_levels.back(), parts.whole);
    const LatticeStiffness* whole = &parts.whole;  // of the last level
    const HeldNodes* whole_held = &parts.whole_held;
    std::unique_ptr<LatticeStiffness> kept;
    std::unique_ptr<HeldNodes> kept_held;
    for (;;) {
        const Level& above = *m_levels.back();
        const HexLattice& fine = above.slabs.whole();
        const Vec3i factor = coarsening_factor(fine);
        if (factor == Vec3i{1, 1, 1}) break;
        const LatticePair pair = coarsened(fine, factor);
        const auto cells = cell_count(fine);
        auto stiffness = std::make_unique<LatticeStiffness>(
            pair.coarse, coarse_means(pair, whole->lambdas(cells)),
            coarse_means(pair, whole->mus(cells)));
        auto held = std::make_unique<HeldNodes>(coarse_held(pair, *whole_held));
        const Slabs slabs = above.slabs.coarse(pair.coarse, factor);
        const LatticePair down{above.slabs.local(), slabs.local(), factor, above.slabs.low(),
                               slabs.low()};
        if (!slabs.are_thick()) {
            const LatticePair up{down.fine, pair.coarse, factor, down.fine_low, 0};
            auto multigrid = std::make_unique<Multigrid>(*stiffness, *held, materials, arena);
            auto work = std::make_unique<Multigrid::Work>(*multigrid);
            m_rest.reset(new Rest{slabs, down, up, std::move(stiffness), std::move(held),
                                  std::move(multigrid), std::move(work),
                                  NodeVector(node_count(down.coarse))});
            break;
        }
        auto level = std::make_unique<Level>(Level{
            down, slabs, spectrum_bound(pair.coarse.spacing_mm, materials), nullptr, nullptr});
        level->own_stiffness =
            std::make_unique<LatticeStiffness>(stiffness->slab(slabs.local(), slabs.low()));
        level->own_held = std::make_unique<HeldNodes>(slabs.local_held(*held));
        level->stiffness = level->own_stiffness.get();
        level->held = level->own_held.get();
        kept = std::move(stiffness);
        kept_held = std::move(held);
        whole = kept.get();
        whole_held = kept_held.get();
        complete(*level, *whole);
        m_levels.push_back(std::move(level));
    }
}

/// displacement += polynomial(D⁻¹K) D⁻¹ residual.
/// @param with_residual  updates the residual too
void SlabMultigrid::smooth(Level& l, bool with_residual) {
    const double least = l.greatest / kUpperPart;
    const double middle = (l.greatest + least) / 2, half = (l.greatest - least) / 2;
    const double sigma = middle / half;
    double rho = 1 / sigma;
    for (int n = 0; n < kDegree; ++n) {
        if (n == 0) {
            l.blocks->renew(l.residual, 1 / middle, 0, l.step, m_arena);
        } else {
            const double next = 1 / (2 * sigma - rho);
            l.blocks->renew(l.residual, 2 * next / half, next * rho, l.step, m_arena);
            rho = next;
        }
        add_scaled(l.displacement, 1, l.step);
        if (n + 1 == kDegree && !with_residual) break;
        l.stiffness->multiply(l.step, l.product, m_arena);
        l.held->clear(l.product);
        add_scaled(l.residual, -1, l.product);
        l.slabs.exchange(l.residual);
    }
}

/// Approximate solution for the level's force, from zero.
void SlabMultigrid::cycle(std::size_t level) {
    Level& l = *m_levels[level];
    l.displacement.clear();
    l.residual = l.force;
    l.slabs.exchange(l.residual);
    smooth(l, true);
    if (level + 1 < m_levels.size() || m_rest) {
        l.step.clear();
        if (level + 1 < m_levels.size()) {
            Level& below = *m_levels[level + 1];
            gather_forces(below.pair, l.residual, below.force, m_arena);
            below.held->clear(below.force);
            cycle(level + 1);
            add_interpolated(below.pair, below.displacement, l.step, m_arena);
        } else {
            solve_rest(l.residual, l.step);
        }
        l.held->clear(l.step);
        add_scaled(l.displacement, 1, l.step);
        l.stiffness->multiply(l.step, l.product, m_arena);
        l.held->clear(l.product);
        add_scaled(l.residual, -1, l.product);
        l.slabs.exchange(l.residual);
    }
    smooth(l, false);
}

void SlabMultigrid::solve_rest(const NodeVector& residual, NodeVector& step) {
    gather_forces(m_rest->down, residual, m_rest->slab_force, m_arena);
    NodeVector force = m_rest->slabs.gather(m_rest->slab_force), displacement = force;
    m_rest->held->clear(force);
    m_rest->multigrid->apply(force, displacement, *m_rest->work, m_arena);
    add_interpolated(m_rest->up, displacement, step, m_arena);
}

void SlabMultigrid::apply(const NodeVector& force, NodeVector& displacement) {
    m_levels[0]->force = force;
    cycle(0);
    displacement = m_levels[0]->displacement;
}

}  // namespace pliant
