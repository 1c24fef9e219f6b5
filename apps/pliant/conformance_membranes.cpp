// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cook's membrane, and the elliptic membrane and the thick plate of NAFEMS.

#include <cmath>
#include <numbers>

#include "conformance.h"
#include "conformance_solids.h"

namespace pliant::app {
namespace {

/// Between two ellipses, in a quarter: from the inner one outwards, from x to y, and upwards.
Shape between_ellipses(double thickness) {
    return [thickness](Vec3d x) {
        const double angle = std::numbers::pi / 2 * x.y;
        const double width = 2 + 1.25 * x.x, height = 1 + 1.75 * x.x;
        return Vec3d{width * std::cos(angle), height * std::sin(angle), thickness * x.z};
    };
}

std::int32_t node_at(const MappedSolid& solid, Vec3d unit) {
    std::size_t nearest = 0;
    for (std::size_t n = 0; n < solid.unit.size(); ++n)
        if (norm(solid.unit[n] - unit) < norm(solid.unit[nearest] - unit)) nearest = n;
    return std::int32_t(nearest);
}

/// Stress along y at a node [MPa], for some meshes.
template <class Make>
void add_stress(ConformanceCase& one, std::initializer_list<Vec3i> meshes, Vec3d at,
                const Make& make, const TaskArena& arena) {
    const ElasticMaterial steel{210e3 * kMPa, 0.3};
    for (const Vec3i cells : meshes)
        for (const HexElement element : kElements) {
            const MappedSolid solid = make(cells);
            const auto solution =
                solve(solid, steel, element, arena, ElasticMethod::ConjugateGradients);
            const auto stress =
                stress_at(solid, solution, steel, element, node_at(solid, at), arena);
            one.results.push_back({element_name(element), mesh_name(cells), stress.yy / kMPa});
        }
}

}  // namespace

ConformanceCases membrane_cases(const TaskArena& arena) {
    ConformanceCases cases;
    ConformanceCase cook{"Cook's membrane", "deflection of the middle of the end [mm]", "Cook1974",
                         23.96, 0.02};
    for (const int n : {4, 16, 32})
        for (const HexElement element : kElements) {
            const Vec3i cells{n, n, 1};
            MappedSolid solid(cells, [](Vec3d x) {
                const double low = 44 * x.x, high = 44 + 16 * x.x;
                return Vec3d{48 * x.x, low + x.y * (high - low), x.z};
            });
            solid.hold([](Vec3d x) { return x.x == 0; }, {true, true, false});
            solid.hold([](Vec3d x) { return x.z == 0; }, {false, false, true});
            solid.pull([](Vec3d x) { return x.x > 1 - 1e-9; }, {0, 1, 0});
            const auto solution = solve(solid, {kMPa, 1.0 / 3}, element, arena);
            const auto middle = [](Vec3d x) {
                return x.x > 1 - 1e-9 && std::abs(x.y - 0.5) < 1e-9;
            };
            cook.results.push_back({element_name(element), mesh_name(cells),
                                    mean_displacement(solid, solution, middle).y});
        }
    cases.push_back(std::move(cook));

    const auto at_x = [](Vec3d x) { return x.y > 1 - 1e-9; };  // on the axis of y
    const auto at_y = [](Vec3d x) { return x.y == 0; };
    const auto outside = [](Vec3d x) { return x.x > 1 - 1e-9; };
    ConformanceCase membrane{"NAFEMS LE1, elliptic membrane", "stress along y at D [MPa]",
                             "NAFEMS1990", 92.7, 0.02};
    add_stress(
        membrane, {{6, 8, 1}, {16, 24, 1}}, {0, 0, 0},
        [&](Vec3i cells) {
            MappedSolid solid(cells, between_ellipses(0.1));
            solid.hold(at_y, {false, true, false});
            solid.hold(at_x, {true, false, false});
            solid.hold([](Vec3d x) { return x.z == 0; }, {false, false, true});
            solid.load(outside, {0, 0, 0}, -10 * kMPa);
            return solid;
        },
        arena);
    cases.push_back(std::move(membrane));

    ConformanceCase plate{"NAFEMS LE10, thick plate", "stress along y at D [MPa]", "NAFEMS1990",
                          -5.38, 0.03};
    add_stress(
        plate, {{6, 8, 2}, {12, 16, 4}, {20, 28, 8}}, {0, 0, 1},
        [&](Vec3i cells) {
            MappedSolid solid(cells, between_ellipses(0.6));
            solid.hold(at_y, {false, true, false});
            solid.hold(at_x, {true, false, false});
            solid.hold(outside, {true, true, false});
            solid.hold([&](Vec3d x) { return outside(x) && std::abs(x.z - 0.5) < 1e-9; },
                       {false, false, true});
            solid.load([](Vec3d x) { return x.z > 1 - 1e-9; }, {0, 0, 0}, kMPa);
            return solid;
        },
        arena);
    cases.push_back(std::move(plate));
    return cases;
}

}  // namespace pliant::app
