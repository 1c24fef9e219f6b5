// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Thick walls under pressure, a column under its weight, a point load on a half space, and the
// order of convergence.

#include <array>
#include <cmath>
#include <numbers>

#include "conformance.h"
#include "conformance_solids.h"

namespace pliant::app {
namespace {

bool is_inside(Vec3d x) {
    return x.x == 0;
}

/// Radial displacement of the inner wall of a quarter of a tube [mm].
double tube_wall(Vec3i cells, const Shape& radius_of, const ElasticMaterial& material,
                 double pressure_pa, bool plane_strain, HexElement element,
                 const TaskArena& arena) {
    MappedSolid solid(cells, [&](Vec3d x) {
        const double r = radius_of(x).x, angle = std::numbers::pi / 2 * x.y;
        return Vec3d{r * std::cos(angle), r * std::sin(angle), x.z};
    });
    solid.hold([](Vec3d x) { return x.y == 0; }, {false, true, false});
    solid.hold([](Vec3d x) { return x.y > 1 - 1e-9; }, {true, false, false});
    solid.hold([&](Vec3d x) { return plane_strain || x.z == 0; }, {false, false, true});
    solid.load(is_inside, {0, 0, 0}, pressure_pa);
    const auto solution = solve(solid, material, element, arena);
    return mean_displacement(solid, solution, [](Vec3d x) { return x.x == 0 && x.y == 0; }).x;
}

/// Displacement [mm] of a half space z ≥ 0 under 1 N along z at the origin; mu in Pa.
Vec3d boussinesq(Vec3d x, double mu, double nu) {
    const double r = norm(x), factor = 1e6 / (4 * std::numbers::pi * mu);
    const double radial = factor * (x.z / (r * r * r) - (1 - 2 * nu) / (r * (r + x.z)));
    return {radial * x.x, radial * x.y, factor * (x.z * x.z / (r * r * r) + 2 * (1 - nu) / r)};
}

void add_tubes(ConformanceCases& cases, const TaskArena& arena) {
    // Radii of MacNeal and Harder.
    const auto graded = [](Vec3d x) {
        constexpr double kRadii[] = {3, 3.5, 4.2, 5.2, 6.75, 9};
        const double at = 5 * x.x;
        const int low = std::min(int(at + 1e-9), 4);
        return Vec3d{kRadii[low] + (at - low) * (kRadii[low + 1] - kRadii[low]), 0, 0};
    };
    const std::pair<double, double> expected[] = {
        {0.49, 5.0399e-3}, {0.499, 5.0602e-3}, {0.4999, 5.0623e-3}};
    for (const auto& [nu, wall] : expected) {
        ConformanceCase& one = cases.emplace_back(ConformanceCase{
            "thick cylinder, Poisson's ratio " + std::to_string(nu).substr(0, 6),
            "radial displacement of the inner wall [mm]", "MacNeal1985", wall, 0.03});
        for (const HexElement element : kElements)
            one.results.push_back(
                {element_name(element), "5 x 9 x 1",
                 tube_wall({5, 9, 1}, graded, {1000 * kMPa, nu}, kMPa, true, element, arena)});
    }
    const double a = 2, b = 3, e = 6e5, nu = 0.45, p = 13332;
    for (const bool plane_strain : {true, false}) {
        // u = p a/E ((1 − ν') a² + (1 + ν') b²)/(b² − a²), with E' and ν' for plane strain.
        const double e1 = plane_strain ? e / (1 - nu * nu) : e;
        const double nu1 = plane_strain ? nu / (1 - nu) : nu;
        const double wall = p * a / e1 * ((1 - nu1) * a * a + (1 + nu1) * b * b) / (b * b - a * a);
        ConformanceCase& one = cases.emplace_back(ConformanceCase{
            plane_strain ? "artery at 100 mmHg, plane strain" : "artery at 100 mmHg, free ends",
            "radial displacement of the inner wall [mm]", "Lame1852", wall, 0.02});
        for (const int n : {3, 6, 12})
            for (const HexElement element : kElements)
                one.results.push_back({element_name(element), mesh_name({n, 3 * n, 1}),
                                       tube_wall(
                                           {n, 3 * n, 1},
                                           [&](Vec3d x) {
                                               return Vec3d{a + (b - a) * x.x, 0, 0};
                                           },
                                           {e, nu}, p, plane_strain, element, arena)});
    }
}

/// A part of a hollow sphere, whose sides have the exact displacement.
void add_sphere(ConformanceCases& cases, const TaskArena& arena) {
    const double a = 10, b = 20, e = 1e4, p = 1000;
    for (const double nu : {0.3, 0.45}) {
        const auto radial = [&](double r) {
            return p * a * a * a / (e * (b * b * b - a * a * a)) *
                   ((1 - 2 * nu) * r + (1 + nu) * b * b * b / (2 * r * r));
        };
        ConformanceCase& one = cases.emplace_back(ConformanceCase{
            "hollow sphere under pressure, Poisson's ratio " + std::to_string(nu).substr(0, 4),
            "radial displacement of the inner wall [mm]", "Lame1852", radial(a), 0.02});
        for (const int n : {4, 8})
            for (const HexElement element : kElements) {
                MappedSolid solid({n, n, n}, [&](Vec3d x) {
                    const Vec3d along{1, std::tan(0.8 * (x.y - 0.5)), std::tan(0.8 * (x.z - 0.5))};
                    return ((a + (b - a) * x.x) / norm(along)) * along;
                });
                for (std::size_t k = 0; k < solid.unit.size(); ++k) {
                    const Vec3d x = solid.unit[k], at = solid.mesh.nodes_mm[k];
                    if (std::min(x.y, x.z) > 0 && std::max(x.y, x.z) < 1 - 1e-9) continue;
                    const double r = norm(at);
                    solid.supports.push_back({std::int32_t(k), kAll, (radial(r) / r) * at});
                }
                solid.load(is_inside, {0, 0, 0}, p);
                const auto solution = solve(solid, {e, nu}, element, arena);
                const auto middle = [](Vec3d x) {
                    return x.x == 0 && std::abs(x.y - 0.5) < 1e-9 && std::abs(x.z - 0.5) < 1e-9;
                };
                one.results.push_back({element_name(element), mesh_name({n, n, n}),
                                       mean_displacement(solid, solution, middle).x});
            }
    }
}

void add_half_space(ConformanceCases& cases, const TaskArena& arena) {
    const double e = 6e5, nu = 0.45, mu = e / (2 * (1 + nu));
    constexpr int kHalf = 16;
    const HexLattice lattice{
        {2 * kHalf + 1, 2 * kHalf + 1, kHalf + 1}, {1, 1, 1}, {-double(kHalf), -double(kHalf), 0}};
    std::vector<Support> supports;
    for (std::int32_t n = 0; n < node_count(lattice); ++n) {
        const Vec3d x = node_position_mm(lattice, n);
        if (std::abs(x.x) == kHalf || std::abs(x.y) == kHalf || x.z == kHalf)
            supports.push_back({n, kAll, boussinesq(x, mu, nu)});
    }
    auto solver = ElasticSolver::create(ElasticLattice{lattice, {{e, nu}}}, supports,
                                        {.method = ElasticMethod::ConjugateGradients}, arena);
    if (!solver.ok()) throw ConformanceFailure{solver.error().message};
    const auto at = [&](int x, int z) { return node_index(lattice, {x + kHalf, kHalf, z}); };
    const auto solution = solver->solve({.forces = {{at(0, 0), {0, 0, 1}}}});
    if (!solution.ok()) throw ConformanceFailure{solution.error().message};
    for (const auto& [x, z] : {std::pair(8, 0), {0, 8}, {6, 6}}) {
        const Vec3d exact = boussinesq({double(x), 0, double(z)}, mu, nu);
        cases.push_back({"half space under a point load",
                         "displacement along it [mm] at " + std::to_string(x) + " mm aside, " +
                             std::to_string(z) + " mm deep",
                         "Boussinesq1885",
                         exact.z,
                         0.02,
                         {{element_name(HexElement::Trilinear), "32 x 32 x 16",
                           solution->displacement_mm[std::size_t(at(x, z))].z}}});
    }
}

/// The order of the error at nodes, for Boussinesq's field in a cube that doesn't have the load.
void add_order(ConformanceCases& cases, const TaskArena& arena) {
    const double e = 1e5, nu = 0.3, mu = e / (2 * (1 + nu));
    const auto exact = [&](Vec3d x) { return boussinesq(x, mu, nu); };
    for (const HexElement element : kElements) {
        double error[3] = {};
        for (int level = 0; level < 3; ++level) {
            const int n = 3 << level;
            MappedSolid solid({n, n, n}, [](Vec3d x) { return x + Vec3d{0.3, 0.2, 1}; });
            double sum = 0, all = 0;
            for (std::size_t k = 0; k < solid.unit.size(); ++k) {
                const Vec3d x = solid.unit[k];
                if (std::min({x.x, x.y, x.z}) > 0 && std::max({x.x, x.y, x.z}) < 1 - 1e-9) continue;
                solid.supports.push_back({std::int32_t(k), kAll, exact(solid.mesh.nodes_mm[k])});
            }
            const auto solution = solve(solid, {e, nu}, element, arena);
            for (std::size_t k = 0; k < solid.unit.size(); ++k) {
                const Vec3d u = exact(solid.mesh.nodes_mm[k]);
                sum += dot(solution.displacement_mm[k] - u, solution.displacement_mm[k] - u);
                all += dot(u, u);
            }
            error[level] = std::sqrt(sum / all);
        }
        cases.push_back(
            {"order of convergence, " + element_name(element),
             "binary logarithm of the ratio of errors for half the edge",
             "Hughes1980",
             2,
             0.15,
             {{element_name(element), "6 to 12 along an edge", std::log2(error[1] / error[2])}}});
    }
}

}  // namespace

ConformanceCases solid_cases(const TaskArena& arena) {
    ConformanceCases cases;
    add_tubes(cases, arena);
    add_sphere(cases, arena);
    const double density = 1100, g = 9.81, length = 20, e = 1e4;
    ConformanceCase& column = cases.emplace_back(
        ConformanceCase{"column under its own weight", "shortening [mm]", "rho g L^2 / (2 E)",
                        1e-3 * density * g * length * length / (2 * e), 1e-6});
    for (const HexElement element : kElements) {
        MappedSolid solid({2, 2, 8}, [](Vec3d x) { return Vec3d{2 * x.x, 2 * x.y, 20 * x.z}; });
        solid.hold([](Vec3d x) { return x.z == 0; }, kAll);
        solid.loads.gravity_m_per_s2 = {0, 0, -g};
        const auto solution = solve(solid, {e, 0, density}, element, arena);
        column.results.push_back(
            {element_name(element), mesh_name({2, 2, 8}),
             -mean_displacement(solid, solution, [](Vec3d x) { return x.z > 1 - 1e-9; }).z});
    }
    add_half_space(cases, arena);
    add_order(cases, arena);
    for (ConformanceCase& one : thermal_cases(arena)) cases.push_back(std::move(one));
    return cases;
}

}  // namespace pliant::app
