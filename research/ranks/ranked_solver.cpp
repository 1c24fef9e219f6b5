// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/ranks.h>

#include <cmath>
#include <optional>
#include <utility>

#include "fem/check_solid.h"
#include "fem/loads.h"
#include "ranks/slab_multigrid.h"
#include "ranks/slab_sums.h"

namespace pliant {
namespace {

constexpr double kNewton = 1e-6;  // N per µN
constexpr double kJoule = 1e-9;   // J per nJ

}  // namespace

struct RankedSolver::Impl {
    ElasticLattice solid;
    ElasticSettings settings;
    const TaskArena* arena;
    Slabs slabs;
    std::optional<ElasticSolver> alone{};  ///< if slabs would be thin; nothing below is set
    HeldNodes whole_held{{}, NodeVector(0)}, held{{}, NodeVector(0)};
    std::unique_ptr<LatticeStiffness> stiffness{};
    std::unique_ptr<SlabMultigrid> multigrid{};

    /// Free part of f − K u.
    NodeVector residual(const NodeVector& force, const NodeVector& inner) const {
        NodeVector r(force.node_count());
        for (std::size_t n = 0; n < std::size_t(force.node_count()); ++n)
            r.set(n, force.at(n) - inner.at(n));
        held.clear(r);
        return r;
    }
    Result<ElasticSolution> solve(const ElasticLoads& loads) const;
    ElasticSolution finish(const NodeVector& force, double force_norm,
                           const NodeVector& displacement) const;
};

RankedSolver::RankedSolver(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
RankedSolver::~RankedSolver() = default;
RankedSolver::RankedSolver(RankedSolver&&) noexcept = default;
RankedSolver& RankedSolver::operator=(RankedSolver&&) noexcept = default;

Result<RankedSolver> RankedSolver::create(ElasticLattice solid,
                                          const std::vector<Support>& supports,
                                          const ElasticSettings& settings, const TaskArena& arena,
                                          Ranks& ranks) {
    if (const Status s = check_settings(settings); !s) return s.error();
    if (const Status s = check_solid(solid); !s) return s.error();
    Slabs slabs(solid.lattice, &ranks);
    auto impl = std::make_unique<Impl>(Impl{std::move(solid), settings, &arena, std::move(slabs)});
    if (impl->slabs.is_whole()) {
        auto alone = ElasticSolver::create(impl->solid, supports, settings, arena);
        if (!alone) return alone.error();
        impl->alone.emplace(std::move(alone).value());
        return RankedSolver(std::move(impl));
    }
    if (settings.method != ElasticMethod::ConjugateGradients ||
        settings.element != HexElement::Trilinear)
        return Error{ErrorCode::InvalidArgument,
                     "method, element: expected conjugate gradients on trilinear elements"};
    auto held = hold(SolidShape(impl->solid.lattice), supports);
    if (!held) return held.error();
    impl->whole_held = std::move(held).value();
    impl->held = impl->slabs.local_held(impl->whole_held);
    const LatticeStiffness whole(impl->solid);
    impl->stiffness =
        std::make_unique<LatticeStiffness>(whole.slab(impl->slabs.local(), impl->slabs.low()));
    impl->multigrid = std::make_unique<SlabMultigrid>(
        SlabMultigrid::Parts{whole, impl->whole_held, impl->slabs, *impl->stiffness, impl->held},
        impl->solid.materials, arena);
    return RankedSolver(std::move(impl));
}

ElasticSolution RankedSolver::Impl::finish(const NodeVector& force, double force_norm,
                                           const NodeVector& displacement) const {
    const SlabSums sums(slabs, *arena);
    NodeVector inner(force.node_count());
    stiffness->multiply(displacement, inner, *arena);
    ElasticSolution solution;
    solution.strain_energy_j = kJoule * 0.5 * sums.dot(displacement, inner);
    const NodeVector left = residual(force, inner);
    if (force_norm > 0) solution.relative_residual = std::sqrt(sums.dot(left, left)) / force_norm;
    NodeVector reaction(force.node_count());
    for (const std::int32_t n : held.nodes)
        for (int a = 0; a < 3; ++a)
            if (held.holds(std::size_t(n), a))
                reaction.component(a)[n] = inner.component(a)[n] - force.component(a)[n];
    solution.displacement_mm = vectors_of(slabs.gather(displacement), 1);
    solution.reaction_n = vectors_of(slabs.gather(reaction), kNewton);
    return solution;
}

Result<ElasticSolution> RankedSolver::Impl::solve(const ElasticLoads& loads) const {
    const auto forces = nodal_forces(SolidShape(solid.lattice), solid.materials, solid.material_of,
                                     whole_held, loads);
    if (!forces) return forces.error();
    const NodeVector force = slabs.local_nodes(*forces);
    // Prescribed displacements move to the right-hand side.
    NodeVector displacement = held.displacement_mm;
    NodeVector inner(force.node_count());
    stiffness->multiply(displacement, inner, *arena);
    const NodeVector free_force = residual(force, inner);
    const SlabSums sums(slabs, *arena);
    const double force_norm = std::sqrt(sums.dot(free_force, free_force));
    Convergence found;
    if (force_norm > 0) {
        NodeVector moved(force.node_count());
        found = conjugate_gradients(
            *stiffness, [&](const NodeVector& r, NodeVector& z) { multigrid->apply(r, z); }, held,
            free_force, settings.tolerance * force_norm, settings.max_iterations, sums, *arena,
            moved);
        if (!found.reached)
            return Error{ErrorCode::LimitExceeded, "max_iterations: not enough for the tolerance"};
        for (std::size_t n = 0; n < std::size_t(force.node_count()); ++n)
            displacement.set(n, displacement.at(n) + moved.at(n));
    }
    ElasticSolution solution = finish(force, force_norm, displacement);
    solution.iterations = found.iterations;
    return solution;
}

Result<ElasticSolution> RankedSolver::solve(const ElasticLoads& loads) const {
    return m_impl->alone ? m_impl->alone->solve(loads) : m_impl->solve(loads);
}

std::vector<Vec3d> RankedSolver::forces_n(std::span<const Vec3d> displacement_mm) const {
    const Impl& i = *m_impl;
    if (i.alone) return i.alone->forces_n(displacement_mm);
    const NodeVector u = i.slabs.local_nodes(node_vector(displacement_mm));
    NodeVector inner(u.node_count());
    i.stiffness->multiply(u, inner, *i.arena);
    return vectors_of(i.slabs.gather(inner), kNewton);
}

}  // namespace pliant
