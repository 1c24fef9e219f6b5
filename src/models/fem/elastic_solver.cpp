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

#include "base/errors.h"
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

/// to += from
void add(const NodeVector& from, NodeVector& to) {
    for (std::size_t n = 0; n < std::size_t(to.node_count()); ++n) to.set(n, to.at(n) + from.at(n));
}

}  // namespace

struct ElasticSolver::Impl {
    /// The solid, whatever its supports are.
    struct Body {
        std::variant<ElasticSolid, ElasticLattice> solid;
        ElasticSettings settings;
        const TaskArena* arena;
        std::unique_ptr<BlockMatrix> matrix{};        ///< of a mesh
        std::unique_ptr<LatticeStiffness> lattice{};  ///< of a lattice

        SolidShape shape() const {
            if (const auto* l = std::get_if<ElasticLattice>(&solid)) return SolidShape(l->lattice);
            return SolidShape(std::get_if<ElasticSolid>(&solid)->mesh);
        }
        const Stiffness& stiffness() const {
            return matrix ? static_cast<const Stiffness&>(*matrix) : *lattice;
        }
    };
    /// Inverse of the stiffness, or its approximation. Depends on the held components, not on
    /// their displacements.
    struct Inverse {
        std::shared_ptr<const HeldNodes> held;
        std::optional<CholeskyFactor> factor{};
        std::optional<BlockJacobi> blocks{};     ///< preconditioner on meshes
        std::unique_ptr<Multigrid> multigrid{};  ///< preconditioner on lattices
    };
    std::shared_ptr<const Body> body;
    std::shared_ptr<const HeldNodes> held;
    std::shared_ptr<const Inverse> inverse;

    /// @param old  with other supports; may be null
    static Result<ElasticSolver> make(std::shared_ptr<const Body> body, HeldNodes held,
                                      const Impl* old);
    static Result<std::shared_ptr<const Inverse>> invert(const Body& body,
                                                         std::shared_ptr<const HeldNodes> held,
                                                         const Inverse* old);
    Result<NodeVector> forces_of(const ElasticLoads& loads) const {
        return std::visit(
            [&](const auto& s) {
                return nodal_forces(body->shape(), s.materials, s.material_of, *held, loads);
            },
            body->solid);
    }
    Status check(const ElasticSolveOptions& options) const;
    Preconditioner preconditioner() const;
    NodeVector product(const NodeVector& displacement) const {
        NodeVector inner(displacement.node_count());
        body->stiffness().multiply(displacement, inner, *body->arena);
        return inner;
    }
    /// Free part of f − K u.
    NodeVector residual(const NodeVector& force, const NodeVector& inner) const {
        NodeVector r(force.node_count());
        for (std::size_t n = 0; n < std::size_t(force.node_count()); ++n)
            r.set(n, force.at(n) - inner.at(n));
        held->clear(r);
        return r;
    }
    Status solve_free(const NodeVector& force, double force_norm, int budget,
                      NodeVector& displacement, int& iterations) const;
    ElasticSolution finish(const NodeVector& force, double force_norm,
                           const NodeVector& displacement) const;
};

ElasticSolver::ElasticSolver(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ElasticSolver::~ElasticSolver() = default;
ElasticSolver::ElasticSolver(ElasticSolver&&) noexcept = default;
ElasticSolver& ElasticSolver::operator=(ElasticSolver&&) noexcept = default;

Result<std::shared_ptr<const ElasticSolver::Impl::Inverse>> ElasticSolver::Impl::invert(
    const Body& body, std::shared_ptr<const HeldNodes> held, const Inverse* old) {
    auto inverse = std::make_shared<Inverse>(Inverse{std::move(held)});
    const HeldNodes& kept = *inverse->held;
    if (const auto* solid = std::get_if<ElasticLattice>(&body.solid)) {
        inverse->multigrid =
            old ? std::make_unique<Multigrid>(*old->multigrid, kept)
                : std::make_unique<Multigrid>(*body.lattice, kept, solid->materials, *body.arena);
    } else if (body.settings.method == ElasticMethod::Cholesky) {
        auto factor = CholeskyFactor::create(*body.matrix, kept);
        if (!factor) return factor.error();
        inverse->factor.emplace(std::move(factor).value());
    } else if (old) {
        inverse->blocks.emplace(*old->blocks, *old->held, *body.matrix, kept);
    } else {
        inverse->blocks.emplace(*body.matrix, kept, *body.arena);
    }
    return std::shared_ptr<const Inverse>(std::move(inverse));
}

Result<ElasticSolver> ElasticSolver::Impl::make(std::shared_ptr<const Body> body, HeldNodes held,
                                                const Impl* old) {
    auto impl = std::make_unique<Impl>(
        Impl{std::move(body), std::make_shared<const HeldNodes>(std::move(held)), nullptr});
    if (old && old->held->axes == impl->held->axes) {
        impl->inverse = old->inverse;
    } else {
        auto inverse = invert(*impl->body, impl->held, old ? old->inverse.get() : nullptr);
        if (!inverse) return inverse.error();
        impl->inverse = std::move(inverse).value();
    }
    return ElasticSolver(std::move(impl));
}

Result<ElasticSolver> ElasticSolver::create(ElasticSolid solid, std::vector<Support> supports,
                                            const ElasticSettings& settings,
                                            const TaskArena& arena) {
    if (const Status s = check_settings(settings); !s) return s.error();
    if (const Status s = check_solid(solid); !s) return s.error();
    const auto nodes = std::int64_t(solid.mesh.nodes_mm.size());
    if (settings.method == ElasticMethod::Cholesky && nodes > kMaxCholeskyNodes)
        return Error{ErrorCode::LimitExceeded, "method: Cholesky with " + std::to_string(nodes) +
                                                   " nodes, expected " +
                                                   std::to_string(kMaxCholeskyNodes) +
                                                   " at most; conjugate gradients take more"};
    auto held = hold(SolidShape(solid.mesh), supports);
    if (!held) return held.error();
    auto body = std::make_shared<Impl::Body>(Impl::Body{std::move(solid), settings, &arena});
    body->matrix = std::make_unique<BlockMatrix>(*std::get_if<ElasticSolid>(&body->solid),
                                                 settings.element, arena);
    return Impl::make(std::move(body), std::move(held).value(), nullptr);
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
    auto body = std::make_shared<Impl::Body>(Impl::Body{std::move(solid), settings, &arena});
    body->lattice = std::make_unique<LatticeStiffness>(*std::get_if<ElasticLattice>(&body->solid));
    return Impl::make(std::move(body), std::move(held).value(), nullptr);
}

Result<ElasticSolver> ElasticSolver::with_supports(const std::vector<Support>& supports) const {
    auto held = hold(m_impl->body->shape(), supports);
    if (!held) return held.error();
    return Impl::make(m_impl->body, std::move(held).value(), m_impl.get());
}

Status ElasticSolver::Impl::check(const ElasticSolveOptions& options) const {
    const auto start = options.initial_displacement_mm;
    const std::int64_t nodes = body->shape().node_count();
    if (!start.empty() && std::int64_t(start.size()) != nodes)
        return invalid("initial_displacement_mm: has " + std::to_string(start.size()) +
                       " vectors, expected " + std::to_string(nodes) + ", one for each node");
    for (std::size_t n = 0; n < start.size(); ++n)
        if (!is_finite(start[n]))
            return invalid("initial_displacement_mm: of node " + std::to_string(n) +
                           " is not finite");
    if (options.iteration_budget < 0)
        return invalid("iteration_budget: expected 0 or more, found " +
                       std::to_string(options.iteration_budget));
    return Ok{};
}

Preconditioner ElasticSolver::Impl::preconditioner() const {
    const TaskArena* const arena = body->arena;
    if (const auto& blocks = inverse->blocks)
        return [&blocks, arena](const NodeVector& r, NodeVector& z) {
            blocks->renew(r, 1, 0, z, *arena);
        };
    // std::function requires copyable function objects.
    const Multigrid& multigrid = *inverse->multigrid;
    const auto work = std::make_shared<Multigrid::Work>(multigrid);
    return [&multigrid, work, arena](const NodeVector& r, NodeVector& z) {
        multigrid.apply(r, z, *work, *arena);
    };
}

Status ElasticSolver::Impl::solve_free(const NodeVector& force, double force_norm, int budget,
                                       NodeVector& displacement, int& iterations) const {
    if (inverse->factor) {
        displacement = inverse->factor->solve(force);
        return Ok{};
    }
    const TaskArena& arena = *body->arena;
    const Convergence found = conjugate_gradients(
        body->stiffness(), preconditioner(), *held, force, body->settings.tolerance * force_norm,
        budget > 0 ? budget : body->settings.max_iterations, WholeSums(arena), arena, displacement);
    iterations = found.iterations;
    if (found.reached || budget > 0) return Ok{};
    return Error{ErrorCode::LimitExceeded,
                 "max_iterations: after " + std::to_string(found.iterations) + " the residual is " +
                     std::to_string(found.residual / force_norm) +
                     " of the load, expected the tolerance; allow more, or loosen it"};
}

ElasticSolution ElasticSolver::Impl::finish(const NodeVector& force, double force_norm,
                                            const NodeVector& displacement) const {
    const TaskArena& arena = *body->arena;
    const NodeVector inner = product(displacement);
    ElasticSolution solution;
    solution.strain_energy_j = kJoule * 0.5 * ordered_dot(displacement, inner, arena);
    const NodeVector left = residual(force, inner);
    if (force_norm > 0)
        solution.relative_residual = std::sqrt(ordered_dot(left, left, arena)) / force_norm;
    NodeVector reaction(force.node_count());
    for (const std::int32_t n : held->nodes)
        for (int a = 0; a < 3; ++a)
            if (held->holds(std::size_t(n), a))
                reaction.component(a)[n] = inner.component(a)[n] - force.component(a)[n];
    solution.displacement_mm = vectors_of(displacement, 1);
    solution.reaction_n = vectors_of(reaction, kNewtonsPerMicronewton);
    return solution;
}

Result<ElasticSolution> ElasticSolver::solve(const ElasticLoads& loads,
                                             const ElasticSolveOptions& options) const {
    const Impl& impl = *m_impl;
    if (const Status s = impl.check(options); !s) return s.error();
    auto forces = impl.forces_of(loads);
    if (!forces) return forces.error();
    const NodeVector force = std::move(forces).value();
    // Prescribed displacements move to the right-hand side, and an initial one too.
    NodeVector displacement = impl.held->displacement_mm;
    NodeVector free_force = impl.residual(force, impl.product(displacement));
    const double force_norm = std::sqrt(ordered_dot(free_force, free_force, *impl.body->arena));
    int iterations = 0;
    if (force_norm > 0) {
        if (!options.initial_displacement_mm.empty() && !impl.inverse->factor) {
            NodeVector start = node_vector(options.initial_displacement_mm);
            impl.held->clear(start);
            add(start, displacement);
            free_force = impl.residual(force, impl.product(displacement));
        }
        NodeVector moved(force.node_count());
        if (const Status s = impl.solve_free(free_force, force_norm, options.iteration_budget,
                                             moved, iterations);
            !s)
            return s.error();
        add(moved, displacement);
    }
    ElasticSolution solution = impl.finish(force, force_norm, displacement);
    solution.iterations = iterations;
    return solution;
}

std::vector<Vec3d> ElasticSolver::forces_n(std::span<const Vec3d> displacement_mm) const {
    return vectors_of(m_impl->product(node_vector(displacement_mm)), kNewtonsPerMicronewton);
}

std::int64_t ElasticSolver::matrix_bytes() const {
    const Impl::Inverse& inverse = *m_impl->inverse;
    return m_impl->body->stiffness().bytes() + (inverse.factor ? inverse.factor->bytes() : 0) +
           (inverse.blocks ? inverse.blocks->bytes() : 0) +
           (inverse.multigrid ? inverse.multigrid->bytes() : 0);
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
