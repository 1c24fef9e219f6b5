// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NAFEMS LE11, the solid cylinder, taper and sphere with a temperature. Its strain is a load:
//
//   f = ∫ Bᵀ D ε₀,   σ = D (ε − ε₀),   ε₀ = α T 1,   so D ε₀ = E α T / (1 − 2ν) 1
//
// The inner modes of elements have no share of it, which vanishes for an even temperature.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "conformance.h"
#include "conformance_solids.h"

namespace pliant::app {
namespace {
namespace heat {

constexpr double kExpansion = 2.3e-4;  ///< [1/K]

/// Section of LE11 [m]: radius and height. @param across  0 inside, 1 outside. @param along  0…7
Vec3d section(double across, double along) {
    using std::numbers::pi;
    const double sphere_deg = 45.0 / 8 * along;  // 45° after the first four parts
    const auto on_line = [](Vec3d a, Vec3d b, double share) { return a + share * (b - a); };
    const Vec3d e{std::sqrt(0.5), std::sqrt(0.5), 0}, h{std::sqrt(0.5), 1.79, 0},
        d{1.4 * std::cos(pi / 6), 0.7, 0}, g{1, 1.39, 0}, i{1, 1.79, 0};
    Vec3d inner, outer;
    if (along <= 4) {
        const double a = sphere_deg * pi / 180, b = along / 4 * pi / 6;
        inner = {std::cos(a), std::sin(a), 0};
        outer = {1.4 * std::cos(b), 1.4 * std::sin(b), 0};
    } else if (along <= 5) {
        const double a = (22.5 + 22.5 * (along - 4)) * pi / 180;
        inner = {std::cos(a), std::sin(a), 0};
        outer = on_line(d, g, (along - 4) / 2);
    } else {
        inner = on_line(e, h, (along - 5) / 2);
        outer = along <= 6 ? on_line(d, g, (along - 4) / 2) : on_line(g, i, along - 6);
    }
    return on_line(inner, outer, across);
}

/// Adds the loads of a stress to all nodes. @param stress_pa  at a position [mm]
template <class Stress>
void add_even_stress(MappedSolid& solid, const Stress& stress_pa) {
    constexpr double kCorners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                       {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    std::vector<Vec3d> forces(solid.unit.size(), Vec3d{0, 0, 0});
    const double root = 1 / std::sqrt(3.0);
    for (const auto& cell : solid.mesh.cells)
        for (const auto& point : kCorners) {
            const Vec3d r{root * point[0], root * point[1], root * point[2]};
            std::array<Vec3d, 8> local;
            Mat3d jacobian{};  // its columns are ∂x/∂r
            Vec3d position{0, 0, 0};
            for (std::size_t c = 0; c < 8; ++c) {
                const auto& k = kCorners[c];
                const double a = 1 + k[0] * r.x, b = 1 + k[1] * r.y, t = 1 + k[2] * r.z;
                local[c] = {k[0] * b * t / 8, k[1] * a * t / 8, k[2] * a * b / 8};
                const Vec3d x = solid.mesh.nodes_mm[std::size_t(cell[c])];
                position = position + a * b * t / 8 * x;
                for (int axis = 0; axis < 3; ++axis)
                    jacobian.columns[axis] = jacobian.columns[axis] + local[c][axis] * x;
            }
            const Mat3d inverted = transposed(inverse(jacobian));
            const double volume = determinant(jacobian), stress = 1e-6 * stress_pa(position);
            for (std::size_t c = 0; c < 8; ++c) {
                Vec3d& force = forces[std::size_t(cell[c])];
                force = force + volume * stress * (inverted * local[c]);
            }
        }
    for (std::size_t n = 0; n < forces.size(); ++n) {
        for (const Support& support : solid.supports)
            if (support.node == std::int32_t(n))
                for (int axis = 0; axis < 3; ++axis)
                    if (support.held[std::size_t(axis)]) forces[n][axis] = 0;
        solid.loads.forces.push_back({std::int32_t(n), forces[n]});
    }
}

}  // namespace heat
}  // namespace

ConformanceCases thermal_cases(const TaskArena& arena) {
    using namespace heat;
    const ElasticMaterial steel{210e3 * kMPa, 0.3};
    const double per_kelvin = steel.young_modulus_pa * kExpansion / (1 - 2 * steel.poisson_ratio);
    ConformanceCase one{"NAFEMS LE11, cylinder, taper and sphere", "stress along z at A [MPa]",
                        "NAFEMS1990", -105, 0.03};
    for (const Vec3i cells : {Vec3i{2, 6, 7}, {4, 12, 14}, {8, 16, 28}})
        for (const HexElement element : kElements) {
            MappedSolid solid(cells, [](Vec3d x) {
                const Vec3d at = section(x.x, 7 * x.z);
                const double angle = std::numbers::pi / 2 * x.y;
                return 1e3 * Vec3d{at.x * std::cos(angle), at.x * std::sin(angle), at.y};
            });
            solid.hold([](Vec3d x) { return x.y == 0; }, {false, true, false});
            solid.hold([](Vec3d x) { return x.y > 1 - 1e-9; }, {true, false, false});
            solid.hold([](Vec3d x) { return x.z == 0 || x.z > 1 - 1e-9; }, {false, false, true});
            const auto heat_pa = [&](Vec3d x) {
                return per_kelvin * 1e-3 * (std::hypot(x.x, x.y) + x.z);
            };
            add_even_stress(solid, heat_pa);
            const auto solution =
                solve(solid, steel, element, arena, ElasticMethod::ConjugateGradients);
            // Node A is the first: in the plane y = 0.
            const auto stress = stress_at(solid, solution, steel, element, 0, arena);
            one.results.push_back({element_name(element), mesh_name(cells),
                                   (stress.zz - heat_pa(solid.mesh.nodes_mm[0])) / kMPa});
        }
    return {one};
}

}  // namespace pliant::app
