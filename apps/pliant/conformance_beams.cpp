// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Patch tests, and the beams of MacNeal and Harder in one layer of elements across. Their units are
// taken as mm and N.

#include <cmath>
#include <cstdint>
#include <numbers>

#include "conformance.h"
#include "conformance_solids.h"

namespace pliant::app {
namespace {

Where at_begin(int axis) {
    return [axis](Vec3d x) { return x[axis] == 0; };
}
Where at_end(int axis) {
    return [axis](Vec3d x) { return x[axis] > 1 - 1e-9; };
}

/// A number between −1 and 1 for a count, by a mix of its bits.
double noise(std::uint32_t n) {
    n = (n ^ (n >> 16)) * 0x85ebca6bU;
    n = (n ^ (n >> 13)) * 0xc2b2ae35U;
    return double(n ^ (n >> 16)) / 0x1p31 - 1;
}

/// A beam with a load on its end.
struct Beam {
    const char* name;
    const char* source;
    ElasticMaterial material;
    Shape shape;
    double tolerance;
};
struct TipLoad {
    const char* quantity;
    Vec3d force_n;
    int axis;  ///< of the displacement
    double expected;
};

void add_beam(ConformanceCases& cases, const Beam& beam, const TipLoad& load,
              std::initializer_list<Vec3i> meshes, const TaskArena& arena) {
    ConformanceCase& one = cases.emplace_back(
        ConformanceCase{beam.name, load.quantity, beam.source, load.expected, beam.tolerance});
    for (const Vec3i cells : meshes)
        for (const HexElement element : kElements) {
            MappedSolid solid(cells, beam.shape);
            solid.hold(at_begin(0), kAll);
            solid.pull(at_end(0), load.force_n);
            const auto solution = solve(solid, beam.material, element, arena);
            one.results.push_back({element_name(element), mesh_name(cells),
                                   mean_displacement(solid, solution, at_end(0))[load.axis]});
        }
}

}  // namespace

ConformanceCases patch_cases(const TaskArena& arena) {
    // Inner nodes of a distorted cube take the linear displacement of its border.
    struct State {
        const char* name;
        Vec3d columns[3];
    };
    const State states[] = {{"stretch along x", {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
                            {"stretch along y", {{0, 0, 0}, {0, 1, 0}, {0, 0, 0}}},
                            {"stretch along z", {{0, 0, 0}, {0, 0, 0}, {0, 0, 1}}},
                            {"shear of yz", {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}},
                            {"shear of zx", {{0, 0, 1}, {0, 0, 0}, {1, 0, 0}}},
                            {"shear of xy", {{0, 1, 0}, {1, 0, 0}, {0, 0, 0}}}};
    constexpr Vec3i kCells{3, 3, 3};
    const ElasticMaterial material{1e6, 0.25};
    ConformanceCases cases;
    for (const State& state : states) {
        ConformanceCase one{"patch test: " + std::string(state.name),
                            "largest error of inner nodes, of the largest displacement",
                            "MacNeal1985", 0, 1e-9};
        for (const HexElement element : kElements) {
            MappedSolid solid(kCells, [](Vec3d x) { return x; });
            const auto displacement = [&](Vec3d x) {
                return 1e-3 *
                       (x.x * state.columns[0] + x.y * state.columns[1] + x.z * state.columns[2]);
            };
            for (std::size_t n = 0; n < solid.unit.size(); ++n) {
                Vec3d& x = solid.mesh.nodes_mm[n];
                const bool inner =
                    std::min({x.x, x.y, x.z}) > 0 && std::max({x.x, x.y, x.z}) < 1 - 1e-9;
                for (int a = 0; inner && a < 3; ++a)
                    x[a] += 0.08 * noise(std::uint32_t(3 * n) + std::uint32_t(a));
                if (!inner) solid.supports.push_back({std::int32_t(n), kAll, displacement(x)});
            }
            const auto solution = solve(solid, material, element, arena);
            double worst = 0;
            for (std::size_t n = 0; n < solid.unit.size(); ++n)
                worst = std::max(worst, norm(solution.displacement_mm[n] -
                                             displacement(solid.mesh.nodes_mm[n])));
            one.results.push_back({element_name(element), mesh_name(kCells), worst / 1e-3});
        }
        cases.push_back(std::move(one));
    }
    return cases;
}

ConformanceCases beam_cases(const TaskArena& arena) {
    ConformanceCases cases;
    const auto straight = [](double skew) {
        return Shape([skew](Vec3d x) {
            // The inner layers across are inclined; the ends stay.
            const double along = 6 * x.x, lean = x.x > 0 && x.x < 1 - 1e-9 ? skew * (x.y - 0.5) : 0;
            return Vec3d{along + lean, 0.2 * x.y, 0.1 * x.z};
        });
    };
    for (const double skew : {0.0, 0.2}) {
        const Beam beam{skew > 0 ? "slender beam of parallelograms" : "slender beam",
                        "MacNeal1985",
                        {1e7 * kMPa, 0.3},
                        straight(skew),
                        0.03};
        for (const TipLoad& load :
             {TipLoad{"extension of the tip [mm]", {1, 0, 0}, 0, 3e-5},
              TipLoad{"deflection of the tip in the plane [mm]", {0, 1, 0}, 1, 0.1081},
              TipLoad{"deflection of the tip out of the plane [mm]", {0, 0, 1}, 2, 0.4321}})
            add_beam(cases, beam, load, {{6, 1, 1}, {24, 2, 1}}, arena);
    }
    const Beam curved{"curved beam",
                      "MacNeal1985",
                      {1e7 * kMPa, 0.25},
                      [](Vec3d x) {
                          const double r = 4.32 - 0.2 * x.y, angle = std::numbers::pi / 2 * x.x;
                          return Vec3d{r * std::sin(angle), r * std::cos(angle), 0.1 * (1 - x.z)};
                      },
                      0.03};
    for (const TipLoad& load :
         {TipLoad{"deflection of the tip across, in the plane [mm]", {1, 0, 0}, 0, 0.08734},
          TipLoad{"deflection of the tip out of the plane [mm]", {0, 0, 1}, 2, 0.5022}})
        add_beam(cases, curved, load, {{6, 1, 1}, {24, 2, 1}}, arena);
    const Beam twisted{"twisted beam",
                       "MacNeal1985",
                       {29e6 * kMPa, 0.22},
                       [](Vec3d x) {
                           const double angle = std::numbers::pi / 2 * x.x;
                           const double y = 1.1 * (x.y - 0.5), z = 0.32 * (x.z - 0.5);
                           return Vec3d{12 * x.x, y * std::cos(angle) - z * std::sin(angle),
                                        y * std::sin(angle) + z * std::cos(angle)};
                       },
                       0.02};
    // The section has turned by 90° at the tip: its width is along z there.
    for (const TipLoad& load :
         {TipLoad{"deflection of the tip along its width [mm]", {0, 0, 1}, 2, 0.005424},
          TipLoad{"deflection of the tip along its thickness [mm]", {0, 1, 0}, 1, 0.001754}})
        add_beam(cases, twisted, load, {{12, 2, 1}, {24, 4, 2}}, arena);

    // Timoshenko's beam whose sections are free to change their width.
    ConformanceCase& one = cases.emplace_back(
        ConformanceCase{"Timoshenko's beam 10 x 10 x 100 mm",
                        "deflection of the tip under 1 N at 1 MPa [mm]", "Cowper1966", 0, 0.005});
    const double e = 1e6, nu = 0.3, length = 0.1, side = 0.01;
    const double inertia = std::pow(side, 4) / 12, g = e / (2 * (1 + nu));
    const double kappa = 10 * (1 + nu) / (12 + 11 * nu);
    one.expected =
        1e3 * (std::pow(length, 3) / (3 * e * inertia) + length / (kappa * g * side * side));
    for (const int across : {1, 2, 4})
        for (const HexElement element : kElements) {
            const Vec3i cells{10 * across, across, across};
            MappedSolid solid(cells, [](Vec3d x) { return Vec3d{100 * x.x, 10 * x.y, 10 * x.z}; });
            solid.hold(at_begin(0), {true, false, false});
            solid.hold([](Vec3d x) { return x == Vec3d{0, 0, 0}; }, kAll);
            solid.hold([](Vec3d x) { return x.x == 0 && x.y > 1 - 1e-9 && x.z == 0; },
                       {true, false, true});
            solid.pull(at_end(0), {0, 0, 1});
            solid.pull(at_begin(0), {0, 0, -1});
            const auto solution = solve(solid, {e, nu}, element, arena);
            one.results.push_back({element_name(element), mesh_name(cells),
                                   mean_displacement(solid, solution, at_end(0)).z -
                                       mean_displacement(solid, solution, at_begin(0)).z});
        }
    return cases;
}

}  // namespace pliant::app
