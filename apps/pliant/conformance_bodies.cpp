// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies of tetrahedra: homogeneous states of the two laws, bars, beams and tubes, an indenter,
// friction, and a spring. Units are mm, g, s: forces in µN, moduli in Pa.

#include <pliant/mesh.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {
namespace bodies {

struct Tissue {
    double young = 1e4, poisson = 0.45, alpha = 2, density = 1e-3;
};

PbdParts solids_of(const TetMesh& mesh, const Tissue& tissue) {
    return computed(pbd_of_mesh(mesh, {.density = tissue.density,
                                       .edges = false,
                                       .volumes = false,
                                       .solids = true,
                                       .young_modulus = tissue.young,
                                       .poisson_ratio = tissue.poisson,
                                       .ogden_alpha = tissue.alpha}));
}

/// How a body is computed.
struct Way {
    const char* model;
    PbdPrecision precision;
    bool warm_starts;
    double sub_steps;  ///< over wave_sub_steps()
};
constexpr Way kDouble{"body, 64-bit", PbdPrecision::Double, true, 2},
    kFloat{"body", PbdPrecision::Float, true, 2},
    kCold{"body, cold starts", PbdPrecision::Float, false, 2};

PbdBody body_of(PbdParts parts, const Way& way, double step, Vec3d gravity, double damping) {
    const auto sub_steps = std::max(1, int(std::ceil(way.sub_steps * wave_sub_steps(parts, step))));
    return computed(PbdBody::create(std::move(parts), {.time_step = step,
                                                       .sub_steps = sub_steps,
                                                       .gravity = gravity,
                                                       .damping = damping,
                                                       .precision = way.precision,
                                                       .warm_starts = way.warm_starts}));
}

constexpr double kStep = 1.0 / 60;

/// A cube between two faces that are led to a homogeneous deformation; other nodes find theirs.
/// @returns stress along x, of the area at rest
double stress_of(int cells, const Tissue& tissue, Vec3d stretch, const Way& way,
                 const TaskArena& arena) {
    constexpr double kSide = 10;
    constexpr int kRamp = 30, kSteps = 90;
    PbdParts parts = solids_of(five_tet_block({cells, cells, cells}, kSide / cells), tissue);
    const std::vector<Vec3d> rest = parts.positions;
    std::vector<std::int32_t> held;
    for (std::size_t n = 0; n < rest.size(); ++n)
        if (rest[n].x == 0 || rest[n].x > kSide - 1e-9) {
            held.push_back(std::int32_t(n));
            parts.inverse_masses[n] = 0;
        }
    PbdBody body = body_of(std::move(parts), way, kStep, {0, 0, 0}, 20);
    for (int step = 1; step <= kSteps; ++step) {
        const Vec3d by = std::min(1.0, double(step) / kRamp) * (stretch - Vec3d{1, 1, 1});
        for (const std::int32_t n : held) {
            const Vec3d x = rest[std::size_t(n)];
            computed(body.set_state(n, x + Vec3d{by.x * x.x, by.y * x.y, by.z * x.z}, {0, 0, 0}));
        }
        computed(body.step(1, arena));
    }
    double sum = 0;
    const auto forces = body.constraint_forces();
    for (const std::int32_t n : held)
        if (rest[std::size_t(n)].x > 0) sum -= forces[std::size_t(n)].x;
    return sum / (kSide * kSide);
}

/// One principal nominal stress: derivative of
/// 2µ/α² Σ(s^α − 1) − 2µ/α (J − 1) + ½(λ + 2µ/α)(J − 1)². For α = 2 it is the neo-Hookean law.
struct Law {
    explicit Law(const Tissue& t)
        : mu(t.young / (2 * (1 + t.poisson))),
          lambda(2 * mu * t.poisson / (1 - 2 * t.poisson)),
          alpha(t.alpha) {}
    double stress(double stretch, double others, double j) const {
        return 2 * mu / alpha * (std::pow(stretch, alpha - 1) - others) +
               (lambda + 2 * mu / alpha) * (j - 1) * others;
    }
    /// Sideways stretch without stress. @param s  stretch along
    double sideways(double s) const {
        double low = 0.5, high = 2;
        for (int n = 0; n < 100; ++n) {
            const double middle = 0.5 * (low + high);
            (stress(middle, s * middle, s * middle * middle) > 0 ? high : low) = middle;
        }
        return low;
    }
    double mu, lambda, alpha;
};

void add_cubes(ConformanceCases& cases, const TaskArena& arena) {
    const Tissue soft{}, brain{4540, 0.49, -17.9, 1e-3};
    for (const auto& [tissue, name, s] : {std::tuple(soft, "neo-Hookean cube", 1.2),
                                          {soft, "neo-Hookean cube", 0.8},
                                          {brain, "cube of Ogden's law, exponent -17.9", 1.1},
                                          {brain, "cube of Ogden's law, exponent -17.9", 0.9}}) {
        const Law law(tissue);
        const double across = law.sideways(s);
        const std::string load = s > 1 ? " in tension, stretch " : " in compression, stretch ";
        ConformanceCase one{name + load + std::to_string(s).substr(0, 3), "nominal stress [Pa]",
                            "Ogden1972", law.stress(s, across * across, s * across * across), 0.02};
        for (const Way& way : {kDouble, kFloat, kCold})
            one.results.push_back(
                {way.model, "2 x 2 x 2", stress_of(2, tissue, {s, across, across}, way, arena)});
        cases.push_back(std::move(one));
    }
}

/// Hexahedra of six tetrahedra each, from the origin.
TetMesh block_of(Vec3i cells, Vec3d size) {
    return tet_mesh({cells + Vec3i{1, 1, 1},
                     {size.x / cells.x, size.y / cells.y, size.z / cells.z},
                     {0, 0, 0}});
}

std::string cells_name(Vec3i cells) {
    return std::to_string(cells.x) + " x " + std::to_string(cells.y) + " x " +
           std::to_string(cells.z);
}

/// Mean displacement of some nodes.
Vec3d mean_moved(const PbdBody& body, const std::function<bool(Vec3d)>& which) {
    Vec3d sum{0, 0, 0};
    int count = 0;
    for (std::int32_t n = 0; n < body.particle_count(); ++n) {
        const Vec3d x = body.parts().positions[std::size_t(n)];
        if (!which(x)) continue;
        sum = sum + body.position(n) - x;
        ++count;
    }
    return (1.0 / count) * sum;
}

void add_column(ConformanceCases& cases, const TaskArena& arena) {
    const Tissue tissue{1e5, 0.45, 2, 1e-3};
    const double length = 40, gravity = 9810;
    ConformanceCase one{"column on a smooth plane under its weight", "shortening [mm]",
                        "rho g L^2 / (2 E)",
                        tissue.density * gravity * length * length / (2 * tissue.young), 0.02};
    for (const int cells : {2, 4})
        for (const Way& way : {kDouble, kFloat, kCold}) {
            const Vec3i block{cells, cells, 4 * cells};
            PbdParts parts = solids_of(block_of(block, {10, 10, length}), tissue);
            parts.planes = {{.point = {0, 0, 0}, .normal = {0, 0, 1}}};
            PbdBody body = body_of(std::move(parts), way, kStep, {0, 0, -gravity}, 20);
            computed(body.step(60, arena));
            one.results.push_back({way.model, cells_name(block), -mean_moved(body, [&](Vec3d x) {
                                                                      return x.z > length - 1e-9;
                                                                  }).z});
        }
    cases.push_back(std::move(one));
}

// SOFA's beam: 20 x 20 x 200 mm, E 10 MPa, ν 0.3, 1100 kg/m³. Deflection of Timoshenko's beam with
// a shear coefficient of 5/6: q L⁴/8EI + q L²/2κGA.
void add_cantilever(ConformanceCases& cases, const TaskArena& arena) {
    const Tissue tissue{1e7, 0.3, 2, 1.1e-3};
    const double length = 200, side = 20, gravity = 9810, area = side * side,
                 inertia = area * area / 12, load = tissue.density * gravity * area,
                 shear = tissue.young / (2 * (1 + tissue.poisson));
    ConformanceCase one{"cantilever under its weight", "deflection of the tip [mm]", "Cowper1966",
                        load * std::pow(length, 4) / (8 * tissue.young * inertia) +
                            load * length * length / (2 * 5.0 / 6 * shear * area),
                        0.03};
    for (const int across : {2, 4, 6}) {
        const Vec3i block{8 * across, across, across};
        PbdParts parts = solids_of(block_of(block, {length, side, side}), tissue);
        for (std::size_t n = 0; n < parts.positions.size(); ++n)
            if (parts.positions[n].x == 0) parts.inverse_masses[n] = 0;
        PbdBody body = body_of(std::move(parts), kDouble, 0.005, {0, 0, -gravity}, 80);
        computed(body.step(40, arena));
        one.results.push_back({kDouble.model, cells_name(block),
                               -mean_moved(body, [&](Vec3d x) { return x.x > length - 1e-9; }).z});
    }
    cases.push_back(std::move(one));
}

// A block slides down a slope of 0.4 rad, whose friction angle is less; or stays.
void add_slope(ConformanceCases& cases, const TaskArena& arena) {
    const double angle = 0.4, gravity = 9810, time = 0.1;
    for (const double friction : {0.2, 0.6}) {
        PbdParts parts = solids_of(five_tet_block({3, 3, 3}, 2), {1e5, 0.45, 2, 1e-3});
        parts.planes = {{.point = {0, 0, 0}, .normal = {0, 0, 1}, .friction = friction}};
        PbdBody body = body_of(std::move(parts), kFloat, 1e-3,
                               {gravity * std::sin(angle), 0, -gravity * std::cos(angle)}, 0);
        computed(body.step(int(std::lround(time / 1e-3)), arena));
        Vec3d sum{0, 0, 0};
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            sum = sum + (1.0 / body.particle_count()) * body.velocity(n);
        const double slides = gravity * (std::sin(angle) - friction * std::cos(angle)) * time;
        const bool stays = slides < 0;
        char name[80];
        std::snprintf(name, sizeof name, "block on a slope of 0.4 rad, friction %g", friction);
        cases.push_back({name,
                         "speed after 0.1 s [mm/s]",
                         "g (sin a - mu cos a) t",
                         stays ? 0 : slides,
                         stays ? 1 : 0.02,
                         {{kFloat.model, "3 x 3 x 3", sum.x}}});
    }
}

void add_spring(ConformanceCases& cases, const TaskArena& arena) {
    ConformanceCase one{"mass on a spring of compliance 0.001", "period [s]", "Macklin2016",
                        2 * std::numbers::pi * std::sqrt(1e-3), 0.01};
    for (const std::int32_t iterations : {1, 100})
        for (const double step : {1e-2, 1e-3}) {
            PbdParts parts{.positions = {{0, 0, 0}, {1, 0, 0}}, .inverse_masses = {0, 1}};
            parts.distances = {{.nodes = {0, 1}, .compliance = 1e-3}};
            auto body =
                computed(PbdBody::create(std::move(parts), {.time_step = step,
                                                            .sub_steps = 1,
                                                            .iterations = iterations,
                                                            .precision = PbdPrecision::Double}));
            computed(body.set_state(1, {1.5, 0, 0}, {0, 0, 0}));
            // Half a period between two passages through the length at rest.
            double before = 0.5, time = 0, first = 0;
            for (int passed = 0; passed < 2;) {
                computed(body.step(1, arena));
                const double now = body.position(1).x - 1;
                if ((before > 0) != (now > 0)) {
                    const double at = time + step * before / (before - now);
                    if (++passed == 1)
                        first = at;
                    else
                        one.results.push_back(
                            {iterations == 1 ? "body, 1 iteration" : "body, 100 iterations",
                             step == 1e-2 ? "step 10 ms" : "step 1 ms", 2 * (at - first)});
                }
                time += step;
                before = now;
            }
        }
    cases.push_back(std::move(one));
}

}  // namespace bodies
}  // namespace

ConformanceCases body_cases(const TaskArena& arena) {
    using namespace bodies;
    ConformanceCases cases;
    add_cubes(cases, arena);
    add_column(cases, arena);
    add_cantilever(cases, arena);
    add_slope(cases, arena);
    add_spring(cases, arena);
    return cases;
}

}  // namespace pliant::app
