// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Solutions that follow each other, as of the frames of a moving tool: a start, a budget of
// iterations, and other supports. Against solvers that are made anew.
// Covers: fem/block_jacobi.cpp, fem/elastic_solver.cpp, fem/multigrid.cpp.

#include "fem/solids.h"

#include <limits>
#include <optional>

namespace pliant {
namespace {

using namespace test;

enum class Kind { Cholesky, Blocks, Lattice };
constexpr Kind kKinds[] = {Kind::Cholesky, Kind::Blocks, Kind::Lattice};

/// A block of two materials under its own weight, whose foot is held. A tool holds some nodes of
/// its top. Multigrid has two levels.
struct Pressed {
    ElasticLattice solid;
    std::vector<Support> supports;
    ElasticLoads loads{.gravity_m_per_s2 = {0, 0, -9.81}};
};

Pressed pressed_block(std::uint64_t seed, Vec3d push_mm, int reach = 2) {
    Random random(seed);
    Pressed pressed;
    HexLattice& l = pressed.solid.lattice;
    l = {{random.whole(8, 9), random.whole(7, 8), random.whole(8, 9)}, {1, 1.2, 0.9}};
    pressed.solid.materials = {{2e5, 0.3, 1000}, {9e5, 0.42, 1100}};
    for (std::int64_t c = 0; c < cell_count(l); ++c)
        pressed.solid.material_of.push_back(random.whole(0, 1));
    for (int j = 0; j < l.size.y; ++j)
        for (int i = 0; i < l.size.x; ++i) pressed.supports.push_back({node_index(l, {i, j, 0})});
    for (int j = 2; j < 2 + reach; ++j)
        for (int i = 1; i < 1 + reach; ++i)
            pressed.supports.push_back(
                {node_index(l, {i, j, l.size.z - 1}), {true, i % 2 == 0, true}, push_mm});
    return pressed;
}

ElasticSolver solver_of(const Pressed& p, Kind kind, const TaskArena& arena,
                        double tolerance = 1e-10, int max_iterations = 20000) {
    const ElasticSettings settings{.method = kind == Kind::Cholesky
                                                 ? ElasticMethod::Cholesky
                                                 : ElasticMethod::ConjugateGradients,
                                   .tolerance = tolerance,
                                   .max_iterations = max_iterations};
    if (kind == Kind::Lattice)
        return value_of(ElasticSolver::create(p.solid, p.supports, settings, arena));
    return value_of(ElasticSolver::create(
        ElasticSolid{hex_mesh(p.solid.lattice), p.solid.materials, p.solid.material_of}, p.supports,
        settings, arena));
}

void expect_same(const ElasticSolution& a, const ElasticSolution& b) {
    EXPECT_EQ(largest_difference(a.displacement_mm, b.displacement_mm), 0);
    EXPECT_EQ(largest_difference(a.reaction_n, b.reaction_n), 0);
    EXPECT_EQ(a.strain_energy_j, b.strain_energy_j);
    EXPECT_EQ(a.iterations, b.iterations);
}

/// ‖f − K u‖ / ‖f‖ over the free components, by the solver's product alone.
double residual_of(const ElasticSolver& solver, const Pressed& p,
                   const std::vector<Vec3d>& displacement_mm) {
    std::vector<std::array<bool, 3>> held(displacement_mm.size());
    std::vector<Vec3d> at_start(displacement_mm.size());
    for (const Support& s : p.supports)
        for (std::size_t a = 0; a < 3; ++a)
            if (s.held[a]) {
                held[std::size_t(s.node)][a] = true;
                at_start[std::size_t(s.node)][int(a)] = s.displacement_mm[int(a)];
            }
    // The load of free components: K u − f vanishes for the exact u, which Cholesky finds.
    const TaskArena arena(1);
    const auto exact = value_of(solver_of(p, Kind::Cholesky, arena).solve(p.loads));
    const auto balanced = solver.forces_n(exact.displacement_mm);
    const auto found = solver.forces_n(displacement_mm), first = solver.forces_n(at_start);
    double left = 0, load = 0;
    for (std::size_t n = 0; n < held.size(); ++n)
        for (std::size_t a = 0; a < 3; ++a)
            if (!held[n][a]) {
                left += std::pow(balanced[n][int(a)] - found[n][int(a)], 2);
                load += std::pow(balanced[n][int(a)] - first[n][int(a)], 2);
            }
    return std::sqrt(left / load);
}

/// eᵀ K e of the error e.
double error_energy(const ElasticSolver& solver, const std::vector<Vec3d>& found,
                    const std::vector<Vec3d>& exact) {
    std::vector<Vec3d> error(found.size());
    for (std::size_t n = 0; n < error.size(); ++n) error[n] = found[n] - exact[n];
    const auto forces = solver.forces_n(error);
    double sum = 0;
    for (std::size_t n = 0; n < error.size(); ++n) sum += dot(error[n], forces[n]);
    return sum;
}

TEST(Frames, AnyStartLeadsToTheSameSolution) {
    const TaskArena arena(2);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const Pressed p = pressed_block(seed, {0.1, -0.05, -0.4});
        const auto expected = value_of(solver_of(p, Kind::Cholesky, arena).solve(p.loads));
        Random random(seed);
        std::vector<Vec3d> start(expected.displacement_mm.size());
        for (Vec3d& u : start) u = random.vector(0.5);  // of held nodes too: ignored
        for (const Kind kind : kKinds) {
            const ElasticSolver solver = solver_of(p, kind, arena);
            const auto found = value_of(solver.solve(p.loads, {.initial_displacement_mm = start}));
            EXPECT_LT(largest_difference(found.displacement_mm, expected.displacement_mm),
                      1e-7 * largest(expected.displacement_mm));
            EXPECT_LT(found.relative_residual, 1e-9);
            for (const Support& s : p.supports)
                for (int a = 0; a < 3; ++a)
                    if (s.held[std::size_t(a)]) {
                        EXPECT_EQ(found.displacement_mm[std::size_t(s.node)][a],
                                  s.displacement_mm[a]);
                    }
        }
    }
}

TEST(Frames, NoStartAndNoBudgetChangeNoBit) {
    const TaskArena arena(2);
    const Pressed p = pressed_block(3, {0, 0, -0.3});
    for (const Kind kind : kKinds) {
        const ElasticSolver solver = solver_of(p, kind, arena);
        const auto plain = value_of(solver.solve(p.loads));
        expect_same(value_of(solver.solve(p.loads, {})), plain);
        expect_same(value_of(solver.solve(p.loads, {.iteration_budget = 5000})), plain);
    }
}

TEST(Frames, TheSolutionItselfIsAStartThatNeedsNoIteration) {
    const TaskArena arena(2);
    const Pressed p = pressed_block(5, {0.2, 0, -0.3});
    for (const Kind kind : {Kind::Blocks, Kind::Lattice}) {
        const auto first = value_of(solver_of(p, kind, arena, 1e-12).solve(p.loads));
        const ElasticSolver solver = solver_of(p, kind, arena, 1e-9);
        const auto again =
            value_of(solver.solve(p.loads, {.initial_displacement_mm = first.displacement_mm}));
        EXPECT_EQ(again.iterations, 0);
        EXPECT_EQ(largest_difference(again.displacement_mm, first.displacement_mm), 0);
        // A frame later the tool is a little further on.
        const Pressed next = pressed_block(5, {0.2, 0, -0.33});
        const ElasticSolver moved = value_of(solver.with_supports(next.supports));
        const auto warm =
            value_of(moved.solve(p.loads, {.initial_displacement_mm = first.displacement_mm}));
        const auto cold = value_of(moved.solve(p.loads));
        EXPECT_LT(warm.iterations, cold.iterations);
        EXPECT_LT(largest_difference(warm.displacement_mm, cold.displacement_mm),
                  1e-7 * largest(cold.displacement_mm));
    }
}

TEST(Frames, ABudgetReturnsWhatItsIterationsReach) {
    const TaskArena arena(2);
    for (const Kind kind : {Kind::Blocks, Kind::Lattice}) {
        const Pressed p = pressed_block(7, {0.1, 0, -0.4});
        const ElasticSolver solver = solver_of(p, kind, arena, 1e-10, 2);
        EXPECT_FALSE(solver.solve(p.loads).ok());  // max_iterations are 2
        const auto exact = value_of(solver_of(p, Kind::Cholesky, arena).solve(p.loads));
        double last = std::numeric_limits<double>::max();
        for (const int budget : {1, 2, 4, 6}) {
            const auto found = value_of(solver.solve(p.loads, {.iteration_budget = budget}));
            EXPECT_EQ(found.iterations, budget);
            const double own = residual_of(solver, p, found.displacement_mm);
            EXPECT_NEAR(found.relative_residual, own, 1e-6 * own + 1e-12);
            EXPECT_GT(found.relative_residual, 1e-10);
            // The energy of the error falls with each iteration [Hestenes1952].
            EXPECT_LT(error_energy(solver, found.displacement_mm, exact.displacement_mm), last);
            last = error_energy(solver, found.displacement_mm, exact.displacement_mm);
        }
        const auto enough = value_of(solver.solve(p.loads, {.iteration_budget = 3000}));
        EXPECT_LT(enough.iterations, 3000);
        EXPECT_LT(largest_difference(enough.displacement_mm, exact.displacement_mm),
                  1e-7 * largest(exact.displacement_mm));
    }
}

TEST(Frames, OtherSupportsHaveTheBitsOfANewSolver) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const TaskArena arena(seed % 2 ? 1 : 2);
        const Pressed first = pressed_block(seed, {0, 0.1, -0.2});
        const Pressed farther = pressed_block(seed, {0.1, 0, -0.5});
        Pressed larger = pressed_block(seed, {0.1, 0, -0.5}, 4);
        larger.supports[0].held = {true, false, true};
        for (const Kind kind : kKinds) {
            // Each solver is gone before its successor is used.
            std::optional<ElasticSolver> solver = solver_of(first, kind, arena);
            const Pressed* const frames[] = {&farther, &larger, &farther, &first};
            for (const Pressed* p : frames) {
                solver = value_of(solver->with_supports(p->supports));
                const ElasticSolver fresh = solver_of(*p, kind, arena);
                expect_same(value_of(solver->solve(p->loads)), value_of(fresh.solve(p->loads)));
                EXPECT_EQ(solver->matrix_bytes(), fresh.matrix_bytes());
            }
        }
    }
}

TEST(Frames, RefusedSupportsLeaveTheSolverAsItWas) {
    const TaskArena arena(1);
    const Pressed p = pressed_block(2, {0, 0, -0.2});
    for (const Kind kind : kKinds) {
        const ElasticSolver solver = solver_of(p, kind, arena);
        const auto before = value_of(solver.solve(p.loads));
        const auto loose = solver.with_supports({{0}});
        ASSERT_FALSE(loose.ok());
        EXPECT_EQ(loose.error().message,
                  "supports: leave the solid free to move or turn (3 of 6 rigid motions are held), "
                  "expected all 6");
        EXPECT_EQ(solver.with_supports({{-1}}).error().message.rfind("supports[0]: node -1", 0),
                  0u);
        expect_same(value_of(solver.solve(p.loads)), before);
    }
}

TEST(Frames, BadOptionsAreNamed) {
    const TaskArena arena(1);
    const Pressed p = pressed_block(1, {0, 0, -0.2});
    const std::string nodes = std::to_string(node_count(p.solid.lattice));
    std::vector<Vec3d> start(std::size_t(node_count(p.solid.lattice)));
    for (const Kind kind : kKinds) {
        const ElasticSolver solver = solver_of(p, kind, arena);
        const auto message_of = [&](const ElasticSolveOptions& options) {
            const auto solution = solver.solve(p.loads, options);
            if (solution.ok()) return std::string();
            EXPECT_EQ(solution.error().code, ErrorCode::InvalidArgument);
            return solution.error().message;
        };
        EXPECT_EQ(message_of({.initial_displacement_mm = start}), "");
        EXPECT_EQ(
            message_of({.initial_displacement_mm = std::span(start).first(7)}),
            "initial_displacement_mm: has 7 vectors, expected " + nodes + ", one for each node");
        for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
            start[5].y = bad;
            EXPECT_EQ(message_of({.initial_displacement_mm = start}),
                      "initial_displacement_mm: of node 5 is not finite");
            start[5].y = 0;
        }
        EXPECT_EQ(message_of({.iteration_budget = -1}),
                  "iteration_budget: expected 0 or more, found -1");
    }
}

}  // namespace
}  // namespace pliant
