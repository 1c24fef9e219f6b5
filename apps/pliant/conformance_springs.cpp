// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mass-spring networks: counts of force transmittal, elastic constants, chains, creep and
// hysteresis, and equilibria against a solution of the assembled matrix.

#include <pliant/models/fem.h>
#include <pliant/models/springs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {
namespace springs {

SpringTissue tissue_of(SpringParts parts,
                       const SpringSettings& settings = {.solver = SpringSolver::Explicit}) {
    return computed(
        SpringTissue::create(computed(SpringNetwork::create(std::move(parts))), settings));
}

// Numbers of nodes that force transmittal reaches [Choi2004, Eq. 9 and 10, Table 3].
void add_counts(ConformanceCases& cases) {
    const auto count = [](SpringParts parts, std::int32_t from, int depth) {
        const auto network = computed(SpringNetwork::create(std::move(parts)));
        return double(computed(transmittal_order(network, std::array{from}, depth)).nodes.size());
    };
    for (const auto& [depth, nodes] : {std::pair(1, 7), {5, 91}, {10, 331}, {20, 1261}})
        cases.push_back(
            {"Choi's table 3, " + std::to_string(depth) + (depth == 1 ? " layer" : " layers"),
             "nodes that a force reaches in a sheet",
             "Choi2004",
             double(nodes),
             1e-9,
             {{"force transmittal", "50 x 50",
               count(computed(springs_of_sheet({.columns = 50, .rows = 50})), 25 + 50 * 25,
                     depth)}}});
    cases.push_back(
        {"Choi's equation 10, 10 layers",
         "nodes that a force on the surface of a solid reaches",
         "Choi2004",
         891,
         1e-9,
         {{"force transmittal", "25 x 25 x 13",
           count(computed(springs_of_lattice({.size = {25, 25, 13}, .links = LatticeLinks::Edges})),
                 12 + 25 * 12, 10)}}});
}

struct Constants {
    double young, poisson;
};
/// A block under equal and opposite forces on its ends, in the linear range.
Constants constants_of(SpringParts parts, int nodes, double spacing) {
    const double edge = spacing * (nodes - 1), stress = 1e-6;
    SpringTissue tissue = tissue_of(std::move(parts));
    const SpringNetwork& network = tissue.network();
    std::vector<std::int32_t> loaded;
    std::vector<Vec3d> forces;
    const auto share = [&](double x) { return std::min(x, edge - x) < 1e-9 ? 0.5 : 1.0; };
    for (std::int32_t n = 0; n < network.node_count(); ++n) {
        const Vec3d x = network.nodes()[std::size_t(n)].rest;
        if (std::min(x.z, edge - x.z) > 1e-9) continue;
        const double force = stress * spacing * spacing * share(x.x) * share(x.y);
        loaded.push_back(n);
        forces.push_back({0, 0, x.z < 1e-9 ? -force : force});
    }
    computed(tissue.load(loaded, forces));
    computed(tissue.find_equilibrium(1e-7));
    const std::int32_t half = nodes / 2, middle = half + nodes * (half + nodes * half);
    const auto strain = [&](std::int32_t step, int axis) {
        return (tissue.displacement(middle + step)[axis] -
                tissue.displacement(middle - step)[axis]) /
               (2 * spacing);
    };
    const double along = strain(nodes * nodes, 2);
    return {stress / along, -strain(1, 0) / along};
}

void add_constants(ConformanceCases& cases) {
    for (const double nu : {0.25, 0.45, 0.49}) {
        constexpr double kYoung = 2.5;
        const SpringMaterial material = closed_form(kYoung, nu, 1);
        const double k = material.stiffness;
        std::vector<ConformanceResult> young, poisson;
        for (const int nodes : {5, 9})
            for (const bool shared : {false, true}) {
                const Constants found =
                    constants_of(computed(springs_of_lattice({.size = {nodes, nodes, nodes},
                                                              .stiffness = {k, k, k},
                                                              .bulk = material.bulk,
                                                              .shared_by_cells = shared})),
                                 nodes, 1);
                const std::string model =
                    shared ? "springs, links shared by cells" : "springs, equal links";
                const std::string mesh = std::to_string(nodes) + "^3 nodes";
                young.push_back({model, mesh, found.young});
                poisson.push_back({model, mesh, found.poisson});
            }
        const std::string name =
            "block of springs in tension, Poisson's ratio " + std::to_string(nu).substr(0, 4);
        cases.push_back(
            {name, "Young's modulus, of 2.5", "k = mu a, bulk = lambda - mu", kYoung, 0.01, young});
        cases.push_back({name, "Poisson's ratio",
                         nu == 0.25 ? "Cauchy's relations" : "k = mu a, bulk = lambda - mu", nu,
                         0.01, poisson});
    }
    const double third = std::sqrt(0.75) / 3;
    const std::vector<Vec3d> nodes = {
        {0, 0, 0}, {1, 0, 0}, {0.5, 3 * third, 0}, {0.5, third, std::sqrt(2.0 / 3)}};
    const std::vector<std::array<std::int32_t, 4>> cell = {{0, 1, 2, 3}};
    const auto parts = computed(springs_of_elastic_tetrahedra(nodes, cell, {.stiffness = 1 / 2.5}));
    cases.push_back({"regular tetrahedron, Poisson's ratio 1/4",
                     "stiffness of an edge over E L",
                     "Lloyd2007",
                     2 * std::numbers::sqrt2 / 25,
                     1e-9,
                     {{"springs of tetrahedra", "1 tetrahedron", parts.links[0].stiffness}}});
}

// The elastin cube of [Choi2004, 4.3]: the stiffness for which springs are nearest to elements.
// Displacements are linear in the load and in 1/k, so one solution gives those of all k.
void add_elastin(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kStiffness = 2575, kEdge = 0.1 / 9, kForce = 1e-3;
    constexpr int kLoaded[] = {944, 945, 954, 955};
    auto parts = computed(springs_of_lattice({.size = {10, 10, 10},
                                              .spacing = {kEdge, kEdge, kEdge},
                                              .stiffness = {kStiffness, kStiffness, kStiffness}}));
    for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
    SpringTissue springs = tissue_of(std::move(parts));
    std::array<Vec3d, 4> forces;
    forces.fill({0, 0, -kForce});
    computed(springs.load(std::array{944, 945, 954, 955}, forces));
    computed(springs.find_equilibrium(1e-9));

    const HexLattice lattice{{10, 10, 10}, {1e3 * kEdge, 1e3 * kEdge, 1e3 * kEdge}};
    std::vector<Support> supports;
    for (std::int32_t n = 0; n < 100; ++n) supports.push_back({n});
    ElasticLoads loads;
    for (const std::int32_t n : kLoaded) loads.forces.push_back({n, {0, 0, -kForce}});
    const auto solver =
        computed(ElasticSolver::create(ElasticLattice{lattice, {{6e5, 0.45, 1040}}}, supports,
                                       {.method = ElasticMethod::ConjugateGradients}, arena));
    const auto elements = computed(solver.solve(loads));
    const auto mean_error = [&](double stiffness) {
        double sum = 0;
        for (std::int32_t n = 0; n < 1000; ++n)
            sum += norm(1e3 * kStiffness / stiffness * springs.displacement(n) -
                        elements.displacement_mm[std::size_t(n)]);
        return sum;
    };
    double low = 1500, high = 4000;
    for (int turn = 0; turn < 60; ++turn) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        (mean_error(a) < mean_error(b) ? high : low) = mean_error(a) < mean_error(b) ? b : a;
    }
    cases.push_back({"Choi's elastin cube, table 1",
                     "stiffness of the links that is nearest to elements [N/m]",
                     "Choi2004",
                     kStiffness,
                     0.04,
                     {{"springs, fitted to elements", "10^3 nodes", 0.5 * (low + high)},
                      {"springs, closed form for nu 1/4", "10^3 nodes",
                       closed_form(6e5, 0.25, kEdge).stiffness}}});
}

SpringParts chain_of(int nodes, double stiffness, double mass) {
    SpringParts parts;
    for (int n = 0; n < nodes; ++n)
        parts.nodes.push_back({.rest = {double(n), 0, 0}, .mass = mass, .fixed = n == 0});
    for (int n = 0; n + 1 < nodes; ++n)
        parts.links.push_back({.a = n, .b = n + 1, .stiffness = stiffness});
    return parts;
}

void add_chains(ConformanceCases& cases, const TaskArena& arena) {
    // A chain that hangs under its own weight: a link bears all nodes below it.
    constexpr int kNodes = 21;
    constexpr double kStiffness = 50, kWeight = 0.1;
    std::vector<std::int32_t> nodes;
    for (int n = 1; n < kNodes; ++n) nodes.push_back(n);
    const std::vector<Vec3d> weights(nodes.size(), Vec3d{kWeight, 0, 0});
    ConformanceCase one{"chain of 20 links under its weight", "elongation", "w n (n + 1) / (2 k)",
                        kWeight * 20 * 21 / (2 * kStiffness), 1e-3};
    SpringTissue still = tissue_of(chain_of(kNodes, kStiffness, 1));
    computed(still.load(nodes, weights));
    computed(still.find_equilibrium());
    one.results.push_back({"springs, equilibrium", "21 nodes", still.displacement(20).x});
    auto damped = chain_of(kNodes, kStiffness, 1);
    for (SpringNode& node : damped.nodes) node.damping = 1;
    for (const SpringSolver solver :
         {SpringSolver::ForceTransmittal, SpringSolver::ImplicitEuler}) {
        SpringTissue moving =
            tissue_of(damped, {.solver = solver,
                               .depth = 20,
                               .time_step = solver == SpringSolver::ImplicitEuler ? 1.0 : 0});
        computed(moving.load(nodes, weights));
        const double seconds = 200;
        computed(moving.step(int(seconds / moving.time_step()), arena));
        one.results.push_back({solver == SpringSolver::ImplicitEuler
                                   ? "springs, backward Euler, 200 s"
                                   : "force transmittal, 200 s",
                               "21 nodes", moving.displacement(20).x});
    }
    cases.push_back(std::move(one));

    // Both ends fixed: half a period of the first mode turns its shape round.
    auto string = chain_of(kNodes, 4, 1);
    string.nodes.back().fixed = true;
    const double omega = 4 * std::sin(std::numbers::pi / 40);
    ConformanceCase mode{"first mode of a chain of 20 links", "circular frequency, k = 4, m = 1",
                         "2 sqrt(k/m) sin(pi / 2n)", omega, 1e-3};
    for (const double step : {0.1, 0.01}) {
        SpringTissue tissue =
            tissue_of(string, {.solver = SpringSolver::Explicit, .time_step = step});
        for (int n = 1; n + 1 < kNodes; ++n)
            computed(tissue.set_state(n, {n + 1e-3 * std::sin(std::numbers::pi * n / 20), 0, 0},
                                      {0, 0, 0}));
        // Half a period between two passages through zero, by interpolation.
        double before = tissue.displacement(10).x, time = 0, first = 0;
        for (int passed = 0; passed < 2; time += step) {
            computed(tissue.step(1, arena));
            const double now = tissue.displacement(10).x;
            if ((before > 0) != (now > 0)) {
                const double at = time + step * before / (before - now);
                if (++passed == 1)
                    first = at;
                else
                    mode.results.push_back({"springs, central differences",
                                            step > 0.05 ? "step 0.1" : "step 0.01",
                                            std::numbers::pi / (at - first)});
            }
            before = now;
        }
    }
    cases.push_back(std::move(mode));
}

/// @param damping  of the node
SpringParts one_link(double mass, const SpringLink& link, double damping = 0) {
    return {
        {{.rest = {0, 0, 0}, .fixed = true}, {.rest = {1, 0, 0}, .mass = mass, .damping = damping}},
        {link},
        {}};
}

void add_responses(ConformanceCases& cases, const TaskArena& arena) {
    const double k = 10, d = 5, step = 1e-4, force = 0.5;
    const auto crept = [&](double mass, const SpringLink& link, double damping) {
        SpringTissue tissue = tissue_of(one_link(mass, link, damping),
                                        {.solver = SpringSolver::Explicit, .time_step = step});
        computed(tissue.load(std::array{1}, std::array{Vec3d{force, 0, 0}}));
        computed(tissue.step(5000, arena));
        return tissue.displacement(1).x;
    };
    const double time = 5000 * step, tau = 0.5, branch = 10;
    cases.push_back({"creep of a Voigt link",
                     "stretch after 0.5 s",
                     "F/k (1 - exp(-k t / d))",
                     force / k * (1 - std::exp(-k * time / d)),
                     0.005,
                     {{"springs, central differences", "step 0.1 ms",
                       crept(1e-5, {.a = 0, .b = 1, .stiffness = k}, d)}}});
    cases.push_back(
        {"creep of a Kelvin link",
         "stretch after 0.5 s",
         "F/k (1 - k'/(k + k') exp(-t k / (tau (k + k'))))",
         force / k * (1 - branch / (k + branch) * std::exp(-time * k / (tau * (k + branch)))),
         0.005,
         {{"springs, central differences", "step 0.1 ms",
           crept(1e-6,
                 {.a = 0,
                  .b = 1,
                  .stiffness = k,
                  .damping = 0.005,
                  .branch_stiffness = branch,
                  .branch_time = tau},
                 0)}}});
    SpringTissue held = tissue_of(
        one_link(1,
                 {.a = 0, .b = 1, .stiffness = 0, .branch_stiffness = branch, .branch_time = tau}),
        {.solver = SpringSolver::Explicit, .time_step = step});
    computed(held.hold(std::array{1}));
    computed(held.step(1, arena));
    computed(held.shift_held({0.1, 0, 0}));
    computed(held.step(5000, arena));
    cases.push_back({"relaxation of a Maxwell link",
                     "force after 0.5 s for a stretch of 0.1",
                     "k' x exp(-t / tau)",
                     branch * 0.1 * std::exp(-time / tau),
                     0.005,
                     {{"springs, central differences", "step 0.1 ms",
                       -computed(held.reaction(std::array{1}, ReactionLaw::Held)).force.x}}});

    // Driven by the force that keeps x = a sin(w t).
    const double a = 0.05, omega = 2 * std::numbers::pi, damping = 2;
    SpringTissue driven = tissue_of(one_link(1e-5, {.a = 0, .b = 1, .stiffness = k}, damping),
                                    {.solver = SpringSolver::Explicit, .time_step = step});
    double energy = 0, last = 0;
    for (int n = 0; n < 20000; ++n) {
        const double t = n * step;
        const double f = k * a * std::sin(omega * t) + damping * a * omega * std::cos(omega * t);
        computed(driven.load(std::array{1}, std::array{Vec3d{f, 0, 0}}));
        computed(driven.step(1, arena));
        const double x = driven.displacement(1).x;
        if (n >= 10000) energy += f * (x - last);
        last = x;
    }
    cases.push_back({"hysteresis of a Voigt link",
                     "energy of a cycle",
                     "pi d w a^2",
                     std::numbers::pi * damping * omega * a * a,
                     0.01,
                     {{"springs, central differences", "step 0.1 ms", energy}}});
}

/// Solves K u = f for a symmetric, positive definite matrix, by Cholesky's method.
std::vector<double> solved(std::vector<double> matrix, std::vector<double> right) {
    const std::size_t n = right.size();
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t k = 0; k < j; ++k)
            matrix[j * n + j] -= matrix[j * n + k] * matrix[j * n + k];
        matrix[j * n + j] = std::sqrt(matrix[j * n + j]);
        for (std::size_t i = j + 1; i < n; ++i) {
            for (std::size_t k = 0; k < j; ++k)
                matrix[i * n + j] -= matrix[i * n + k] * matrix[j * n + k];
            matrix[i * n + j] /= matrix[j * n + j];
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) right[i] -= matrix[i * n + k] * right[k];
        right[i] /= matrix[i * n + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) right[i] -= matrix[k * n + i] * right[k];
        right[i] /= matrix[i * n + i];
    }
    return right;
}

// The lattice's matrix is assembled here, of the links at rest.
void add_lattice(ConformanceCases& cases, const TaskArena& arena) {
    constexpr int kSide = 6, kLayer = kSide * kSide, kFree = kSide * kLayer - kLayer;
    constexpr std::int32_t kLoaded = 2 + kSide * 2 + kLayer * (kSide - 1);
    const Vec3d force{2e-4, 1e-4, -5e-4};
    auto parts = computed(springs_of_lattice({.size = {kSide, kSide, kSide}, .node_damping = 1}));
    for (int n = 0; n < kLayer; ++n) parts.nodes[std::size_t(n)].fixed = true;
    std::vector<double> matrix(std::size_t(9 * kFree * kFree), 0), right(3 * kFree, 0);
    for (const SpringLink& link : parts.links) {
        const Vec3d n = normalized(parts.nodes[std::size_t(link.a)].rest -
                                   parts.nodes[std::size_t(link.b)].rest);
        for (const auto& [p, q, sign] : {std::tuple(link.a, link.a, 1.0),
                                         {link.b, link.b, 1.0},
                                         {link.a, link.b, -1.0},
                                         {link.b, link.a, -1.0}})
            for (int r = 0; p >= kLayer && q >= kLayer && r < 3; ++r)
                for (int c = 0; c < 3; ++c)
                    matrix[std::size_t(3 * (p - kLayer) + r) * (3 * kFree) +
                           std::size_t(3 * (q - kLayer) + c)] +=
                        sign * link.stiffness * n[r] * n[c];
    }
    for (int c = 0; c < 3; ++c) right[std::size_t(3 * (kLoaded - kLayer) + c)] = force[c];
    const auto u = solved(std::move(matrix), std::move(right));
    const auto at = std::size_t(3 * (kLoaded - kLayer));
    ConformanceCase one{"lattice under a force on its top", "displacement of the loaded node",
                        "Cholesky's factors of the assembled matrix",
                        norm(Vec3d{u[at], u[at + 1], u[at + 2]}), 0.002};
    SpringTissue still = tissue_of(parts);
    computed(still.load(std::array{kLoaded}, std::array{force}));
    computed(still.find_equilibrium());
    one.results.push_back({"springs, equilibrium", "6^3 nodes", norm(still.displacement(kLoaded))});
    const struct {
        const char* model;
        SpringSettings settings;
    } runs[] = {
        {"force transmittal, 2 layers", {.depth = 2}},
        {"force transmittal, 5 layers", {.depth = 5}},
        {"force transmittal, all layers", {.depth = 12}},
        {"springs, backward Euler", {.solver = SpringSolver::ImplicitEuler, .time_step = 1}},
        {"springs, backward Euler, assembled",
         {.solver = SpringSolver::ImplicitEuler, .time_step = 1, .assembled = true}}};
    for (const auto& run : runs) {
        SpringTissue tissue = tissue_of(parts, run.settings);
        computed(tissue.load(std::array{kLoaded}, std::array{force}));
        computed(tissue.step(int(300 / tissue.time_step()), arena));
        one.results.push_back({run.model, "6^3 nodes", norm(tissue.displacement(kLoaded))});
    }
    cases.push_back(std::move(one));
}

// The surface of a half space goes down as 1/r. Held sides take away nearly the same near the
// middle, so differences are compared.
void add_half_space(ConformanceCases& cases) {
    ConformanceCase one{"half space of springs under a point load",
                        "dip at 3 less that at 6 spacings, over F / E", "Boussinesq1885",
                        (1 - 1.0 / 16) / std::numbers::pi * (1.0 / 3 - 1.0 / 6), 0.05};
    for (const int side : {25, 41}) {
        const int deep = side / 2 + 1;
        auto parts = computed(springs_of_lattice({.size = {side, side, deep}}));
        for (SpringNode& node : parts.nodes)
            node.fixed = node.rest.z == 0 || node.rest.x == 0 || node.rest.x == side - 1 ||
                         node.rest.y == 0 || node.rest.y == side - 1;
        SpringTissue tissue = tissue_of(std::move(parts));
        const std::int32_t node = side / 2 + side * (side / 2) + side * side * (deep - 1);
        computed(tissue.load(std::array{node}, std::array{Vec3d{0, 0, -1e-4}}));
        computed(tissue.find_equilibrium(1e-6));
        one.results.push_back(
            {"springs", std::to_string(side) + "^2 x " + std::to_string(deep) + " nodes",
             (tissue.displacement(node + 6).z - tissue.displacement(node + 3).z) * 2.5 / 1e-4});
    }
    cases.push_back(std::move(one));
}

}  // namespace springs
}  // namespace

ConformanceCases spring_cases(const TaskArena& arena) {
    using namespace springs;
    ConformanceCases cases;
    add_counts(cases);
    add_constants(cases);
    add_elastin(cases, arena);
    add_chains(cases, arena);
    add_responses(cases, arena);
    add_lattice(cases, arena);
    add_half_space(cases);
    return cases;
}

}  // namespace pliant::app
