// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From loads to equilibrium: K u = f with prescribed u at held nodes. Moduli in Pa and lengths in
// mm give forces in µN and energies in nJ.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/units.h"
#include "fem/block_jacobi.h"
#include "fem/block_matrix.h"
#include "fem/check_solid.h"
#include "fem/cholesky.h"
#include "fem/conjugate_gradients.h"
#include "fem/held_nodes.h"
#include "fem/hex_element.h"
#include "fem/lattice_stiffness.h"
#include "fem/loads.h"
#include "fem/multigrid.h"

namespace pliant {
namespace {

constexpr double kJoule = 1e-9;  // J per nJ

/// Beyond this, the factor takes many minutes and gigabytes (docs/method/fem.md).
constexpr std::int64_t kMaxCholeskyNodes = 20'000;

}  // namespace

struct ElasticSolver::Impl {
    std::variant<ElasticSolid, ElasticLattice> solid;
    ElasticSettings settings;
    const TaskArena* arena;
    HeldNodes held;
    std::unique_ptr<Stiffness> stiffness{};
    std::optional<CholeskyFactor> factor{};
    std::optional<BlockJacobi> blocks{};     ///< preconditioner on meshes
    std::unique_ptr<Multigrid> multigrid{};  ///< preconditioner on lattices

    SolidShape shape() const {
        if (const auto* lattice = std::get_if<ElasticLattice>(&solid))
            return SolidShape(lattice->lattice);
        return SolidShape(std::get_if<ElasticSolid>(&solid)->mesh);
    }
    Result<NodeVector> forces_of(const ElasticLoads& loads) const {
        return std::visit(
            [&](const auto& s) {
                return nodal_forces(shape(), s.materials, s.material_of, held, loads);
            },
            solid);
    }
    Preconditioner preconditioner() const;
    /// Free part of f − K u.
    NodeVector residual(const NodeVector& force, const NodeVector& inner) const {
        NodeVector r(force.node_count());
        for (std::size_t n = 0; n < std::size_t(force.node_count()); ++n)
            r.set(n, force.at(n) - inner.at(n));
        held.clear(r);
        return r;
    }
    Status solve_free(const NodeVector& force, double force_norm, NodeVector& displacement,
                      int& iterations) const;
    ElasticSolution finish(const NodeVector& force, double force_norm,
                           const NodeVector& displacement) const;
};

ElasticSolver::ElasticSolver(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ElasticSolver::~ElasticSolver() = default;
ElasticSolver::ElasticSolver(ElasticSolver&&) noexcept = default;
ElasticSolver& ElasticSolver::operator=(ElasticSolver&&) noexcept = default;

Result<ElasticSolver> ElasticSolver::create(ElasticSolid solid, std::vector<Support> supports,
                                            const ElasticSettings& settings,
                                            const TaskArena& arena) {
    if (const Status s = check_settings(settings); !s) return s.error();
    if (const Status s = check_solid(solid); !s) return s.error();
    const auto nodes = std::int64_t(solid.mesh.nodes_mm.size());
    const bool cholesky = settings.method == ElasticMethod::Cholesky;
    if (cholesky && nodes > kMaxCholeskyNodes)
        return Error{ErrorCode::LimitExceeded, "method: Cholesky with " + std::to_string(nodes) +
                                                   " nodes, expected " +
                                                   std::to_string(kMaxCholeskyNodes) +
                                                   " at most; conjugate gradients take more"};
    auto held = hold(SolidShape(solid.mesh), supports);
    if (!held) return held.error();
    auto impl =
        std::make_unique<Impl>(Impl{std::move(solid), settings, &arena, std::move(held).value()});
    auto matrix = std::make_unique<BlockMatrix>(*std::get_if<ElasticSolid>(&impl->solid),
                                                settings.element, arena);
    if (cholesky) {
        auto factor = CholeskyFactor::create(*matrix, impl->held);
        if (!factor) return factor.error();
        impl->factor.emplace(std::move(factor).value());
    } else {
        impl->blocks.emplace(*matrix, impl->held, arena);
    }
    impl->stiffness = std::move(matrix);
    return ElasticSolver(std::move(impl));
}

Result<ElasticSolver> ElasticSolver::create(ElasticLattice solid, std::vector<Support> supports,
                                            const ElasticSettings& settings,
                                            const TaskArena& arena) {
    if (const Status s = check_settings(settings); !s) return s.error();
    if (const Status s = check_solid(solid); !s) return s.error();
    if (settings.method != ElasticMethod::ConjugateGradients)
        return Error{ErrorCode::InvalidArgument,
                     "method: a lattice without a matrix has no factor, expected conjugate "
                     "gradients; or make its mesh"};
    if (settings.element != HexElement::Trilinear)
        return Error{ErrorCode::InvalidArgument,
                     "element: a lattice without a matrix has trilinear elements only; or make "
                     "its mesh"};
    auto held = hold(SolidShape(solid.lattice), supports);
    if (!held) return held.error();
    auto impl =
        std::make_unique<Impl>(Impl{std::move(solid), settings, &arena, std::move(held).value()});
    const auto& kept = *std::get_if<ElasticLattice>(&impl->solid);
    auto stiffness = std::make_unique<LatticeStiffness>(kept);
    impl->multigrid = std::make_unique<Multigrid>(*stiffness, impl->held, kept.materials, arena);
    impl->stiffness = std::move(stiffness);
    return ElasticSolver(std::move(impl));
}

Preconditioner ElasticSolver::Impl::preconditioner() const {
    if (blocks)
        return [this](const NodeVector& r, NodeVector& z) { blocks->renew(r, 1, 0, z, *arena); };
    // std::function requires copyable function objects.
    const auto work = std::make_shared<Multigrid::Work>(*multigrid);
    return
        [this, work](const NodeVector& r, NodeVector& z) { multigrid->apply(r, z, *work, *arena); };
}

Status ElasticSolver::Impl::solve_free(const NodeVector& force, double force_norm,
                                       NodeVector& displacement, int& iterations) const {
    if (factor) {
        displacement = factor->solve(force);
        return Ok{};
    }
    const Convergence found = conjugate_gradients(
        *stiffness, preconditioner(), held, force, settings.tolerance * force_norm,
        settings.max_iterations, WholeSums(*arena), *arena, displacement);
    iterations = found.iterations;
    if (found.reached) return Ok{};
    return Error{ErrorCode::LimitExceeded,
                 "max_iterations: after " + std::to_string(found.iterations) + " the residual is " +
                     std::to_string(found.residual / force_norm) +
                     " of the load, expected the tolerance; allow more, or loosen it"};
}

ElasticSolution ElasticSolver::Impl::finish(const NodeVector& force, double force_norm,
                                            const NodeVector& displacement) const {
    NodeVector inner(force.node_count());
    stiffness->multiply(displacement, inner, *arena);
    ElasticSolution solution;
    solution.strain_energy_j = kJoule * 0.5 * ordered_dot(displacement, inner, *arena);
    const NodeVector left = residual(force, inner);
    if (force_norm > 0)
        solution.relative_residual = std::sqrt(ordered_dot(left, left, *arena)) / force_norm;
    NodeVector reaction(force.node_count());
    for (const std::int32_t n : held.nodes)
        for (int a = 0; a < 3; ++a)
            if (held.holds(std::size_t(n), a))
                reaction.component(a)[n] = inner.component(a)[n] - force.component(a)[n];
    solution.displacement_mm = vectors_of(displacement, 1);
    solution.reaction_n = vectors_of(reaction, kNewtonsPerMicronewton);
    return solution;
}

Result<ElasticSolution> ElasticSolver::solve(const ElasticLoads& loads) const {
    const Impl& impl = *m_impl;
    auto forces = impl.forces_of(loads);
    if (!forces) return forces.error();
    const NodeVector force = std::move(forces).value();
    // Prescribed displacements move to the right-hand side.
    NodeVector displacement = impl.held.displacement_mm;
    NodeVector inner(force.node_count());
    impl.stiffness->multiply(displacement, inner, *impl.arena);
    const NodeVector free_force = impl.residual(force, inner);
    const double force_norm = std::sqrt(ordered_dot(free_force, free_force, *impl.arena));
    int iterations = 0;
    if (force_norm > 0) {
        NodeVector moved(force.node_count());
        if (const Status s = impl.solve_free(free_force, force_norm, moved, iterations); !s)
            return s.error();
        for (std::size_t n = 0; n < std::size_t(force.node_count()); ++n)
            displacement.set(n, displacement.at(n) + moved.at(n));
    }
    ElasticSolution solution = impl.finish(force, force_norm, displacement);
    solution.iterations = iterations;
    return solution;
}

std::vector<Vec3d> ElasticSolver::forces_n(std::span<const Vec3d> displacement_mm) const {
    const NodeVector u = node_vector(displacement_mm);
    NodeVector inner(u.node_count());
    m_impl->stiffness->multiply(u, inner, *m_impl->arena);
    return vectors_of(inner, kNewtonsPerMicronewton);
}

std::int64_t ElasticSolver::matrix_bytes() const {
    return m_impl->stiffness->bytes() + (m_impl->factor ? m_impl->factor->bytes() : 0) +
           (m_impl->blocks ? m_impl->blocks->bytes() : 0) +
           (m_impl->multigrid ? m_impl->multigrid->bytes() : 0);
}

// Strain and stress at the Gauss points, where they are most accurate.

Result<std::vector<ElasticState>> elastic_states(const ElasticSolid& solid,
                                                 std::span<const Vec3d> displacement_mm,
                                                 HexElement element, const TaskArena& arena) {
    if (const Status s = check_solid(solid); !s) return s.error();
    const HexMesh& mesh = solid.mesh;
    if (displacement_mm.size() != mesh.nodes_mm.size())
        return Error{ErrorCode::InvalidArgument,
                     "displacement_mm: has " + std::to_string(displacement_mm.size()) +
                         " vectors, expected " + std::to_string(mesh.nodes_mm.size()) +
                         ", one for each node"};
    std::vector<ElasticState> states(8 * mesh.cells.size());
    const auto add_cell = [&](std::size_t cell) {
        const auto material = solid.material_of.empty() ? 0 : std::size_t(solid.material_of[cell]);
        HexCorners corners;
        std::array<Vec3d, 8> displacement;
        for (std::size_t c = 0; c < 8; ++c) {
            const auto node = std::size_t(mesh.cells[cell][c]);
            corners[c] = mesh.nodes_mm[node];
            displacement[c] = displacement_mm[node];
        }
        const auto modes = with_law(solid.materials[material], [&](const auto& law) {
            return hex_modes(corners, law, element, displacement);
        });
        for (int g = 0; g < 8; ++g) {
            const HexPoint p = hex_point(corners, gauss_point(g));
            ElasticState& state = states[8 * cell + std::size_t(g)];
            state.position_mm = {0, 0, 0};
            for (std::size_t c = 0; c < 8; ++c)
                state.position_mm = state.position_mm + p.values[c] * corners[c];
            state.strain = strain_at(p, displacement, modes);
            state.stress_pa = with_law(solid.materials[material], [&](const auto& law) {
                return stress_of(law, state.strain);
            });
        }
    };
    arena.for_each(std::int64_t(mesh.cells.size()), 64, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t cell = begin; cell < end; ++cell) add_cell(std::size_t(cell));
    });
    return states;
}

}  // namespace pliant
