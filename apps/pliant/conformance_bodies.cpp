// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies of tetrahedra: homogeneous states of the two laws, bars, beams, Cook's membrane, a tube,
// contact with a ball and a plane, friction, and a spring. Units are mm, g, s: forces in µN, moduli
// in Pa.

#include <pliant/mesh.h>
#include <pliant/models/body_contact.h>
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

// A sphere is pressed into a layer that is bonded to its ground. The contact radius is 3.1 mm.
void add_indenter(ConformanceCases& cases, const TaskArena& arena) {
    const Tissue tissue{15000, 0.45, 2, 1e-3};
    const double radius = 12, depth = 0.8, thick = 16, nu = tissue.poisson, pi = std::numbers::pi;
    const double hertz =
        4.0 / 3 * tissue.young / (1 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
    const double chi = std::sqrt(radius * depth) / thick;
    const double low = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu),
                 high = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
    const double layer = hertz * (1 - 2 * low / pi * chi + 4 * low * low / (pi * pi) * chi * chi -
                                  8 / (pi * pi * pi) * (low * low * low + 4 * pi * pi / 15 * high) *
                                      chi * chi * chi);
    ConformanceCase one{"rigid sphere on a bonded layer", "force for 0.8 mm [uN]",
                        "Dimitriadis2002", layer, 0.1};
    for (const int cells : {8, 10}) {
        const double side = thick / cells, step = 1e-4;
        TetMesh mesh = five_tet_block({2 * cells, 2 * cells, cells}, side);
        for (Vec3d& x : mesh.nodes_mm) x = x - Vec3d{thick, thick, 0};
        PbdParts parts = solids_of(mesh, tissue);
        for (std::size_t n = 0; n < parts.positions.size(); ++n)
            if (parts.positions[n].z == 0) parts.inverse_masses[n] = 0;
        auto body = computed(
            PbdBody::create(std::move(parts), {.time_step = step, .sub_steps = 1, .damping = 20}));
        auto contact = computed(BodyContact::create(mesh, {}, {}));
        const Vec3d above{0, 0, thick + radius};
        const BodyTool to{above - Vec3d{0, 0, depth}, above - Vec3d{0, 0, depth}, radius};
        constexpr int kParts = 50;
        for (int n = 0; n < kParts; ++n) {
            const auto at = [&](int part) {
                const Vec3d x = above - Vec3d{0, 0, depth * part / kParts};
                return BodyTool{x, x, radius};
            };
            const BodyTool before = at(n), after = at(n + 1);
            computed(contact.step(20, body, {&before, 1}, {&after, 1}, arena));
        }
        computed(contact.step(2000, body, {&to, 1}, {&to, 1}, arena));
        computed(contact.step(500, body, {&to, 1}, {&to, 1}, arena));
        one.results.push_back(
            {"body and contact", cells_name({2 * cells, 2 * cells, cells}), contact.force(0).z});
    }
    cases.push_back(std::move(one));
}

/// Ways from a corner of a cell to the opposite one: each makes a tetrahedron, of which the last
/// three are left-handed.
constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

/// Half a cube, bent to half a ball above the plane z = 0, which its pole touches. Cells are
/// smaller there. @param cells  along the axis
TetMesh half_ball(int cells, double radius) {
    const auto dense = [](double x) { return std::copysign(std::pow(std::abs(x), 1.6), x); };
    const int across = 2 * cells + 1;
    const auto node = [&](Vec3i at) { return at.x + across * (at.y + across * at.z); };
    TetMesh mesh;
    for (int k = 0; k <= cells; ++k)
        for (int j = 0; j < across; ++j)
            for (int i = 0; i < across; ++i) {
                const Vec3d p{dense(double(i) / cells - 1), dense(double(j) / cells - 1),
                              1 - dense(1 - double(k) / cells)};
                const double most = std::max({std::abs(p.x), std::abs(p.y), p.z}), length = norm(p);
                const Vec3d q = (length > 0 ? radius * most / length : 0) * p;
                mesh.nodes_mm.push_back({q.x, q.y, radius - q.z});
            }
    // Six tetrahedra from the corner of a cell that is nearest to the middle of the flat face: so
    // each has a node inside of the ball.
    for (int k = 0; k < cells; ++k)
        for (int j = 0; j + 1 < across; ++j)
            for (int i = 0; i + 1 < across; ++i) {
                const Vec3i way{i < cells ? -1 : 1, j < cells ? -1 : 1, 1};
                const Vec3i start{way.x < 0 ? i + 1 : i, way.y < 0 ? j + 1 : j, k};
                for (int order = 0; order < 6; ++order) {
                    Vec3i at = start;
                    std::array<std::int32_t, 4> tet{node(at)};
                    for (int step = 0; step < 3; ++step) {
                        at[kOrders[order][step]] += way[kOrders[order][step]];
                        tet[std::size_t(step + 1)] = node(at);
                    }
                    // The ball's axis is turned over, which mirrors it once.
                    if ((order >= 3) == (way.x * way.y > 0)) std::swap(tet[1], tet[2]);
                    std::swap(tet[1], tet[2]);
                    mesh.cells.push_back(tet);
                }
            }
    return mesh;
}

// Two equal spheres are pressed together. By symmetry, a hemisphere nears a smooth plane. Its flat
// face is held whole, as by a plate.
double force_of_spheres(int cells, double way, const TaskArena& arena) {
    constexpr double kRadius = 10, kShort = 1e-3;
    constexpr int kRamp = 6, kSteps = 12;
    const TetMesh mesh = half_ball(cells, kRadius);
    PbdParts parts = solids_of(mesh, {1e6, 0.3, 2, 1e-3});
    parts.planes = {{.point = {0, 0, 0}, .normal = {0, 0, 1}}};
    const std::vector<Vec3d> rest = parts.positions;
    std::vector<std::int32_t> held;
    for (std::size_t n = 0; n < rest.size(); ++n)
        if (rest[n].z > kRadius - 1e-9) {
            held.push_back(std::int32_t(n));
            parts.inverse_masses[n] = 0;
        }
    // Cells at the pole are much smaller than the median one.
    Way fine = kFloat;
    fine.sub_steps = 8;
    PbdBody body = body_of(std::move(parts), fine, kShort, {0, 0, 0}, 3000);
    for (int step = 1; step <= kSteps; ++step) {
        const Vec3d by{0, 0, -way * std::min(1.0, double(step) / kRamp)};
        for (const std::int32_t n : held)
            computed(body.set_state(n, rest[std::size_t(n)] + by, {0, 0, 0}));
        computed(body.step(1, arena));
    }
    double sum = 0;
    const auto forces = body.constraint_forces();
    for (const std::int32_t n : held) sum += forces[std::size_t(n)].z;
    return 1e-6 * sum;
}

void add_spheres(ConformanceCases& cases, const TaskArena& arena) {
    const double hertz = 4.0 / 3 / (1 - 0.3 * 0.3) * std::sqrt(10.0) * std::pow(0.1, 1.5);
    for (const auto& [way, expected, source] :
         {std::tuple(0.1, hertz, "4/3 E/(1 - nu^2) sqrt(R) u^1.5"),
          {2.0, 18.06, "converged: research/results/conformance/spheres.py"}}) {
        char name[80];
        std::snprintf(name, sizeof name, "two spheres, each pressed by %g %% of its radius",
                      10 * way);
        ConformanceCase one{name, "force [N]", source, expected, 0.1};
        for (const int cells : {4, 6, 10})
            one.results.push_back({kFloat.model, cells_name({2 * cells, 2 * cells, cells}),
                                   force_of_spheres(cells, way, arena)});
        cases.push_back(std::move(one));
    }
}

// 8 mm thick with free faces; the end at x = 0 is held whole. The load is dead.
void add_cook(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kThick = 8, kTraction = 62500;
    ConformanceCase one{"Cook's membrane, neo-Hookean, 8 mm thick",
                        "way of the upper corner at half of the thickness [mm]",
                        "converged: research/results/conformance/cook.py", 14.17, 0.03};
    for (const int cells : {8, 16, 24}) {
        const Vec3i block{cells, cells, cells / 4};
        TetMesh mesh = block_of(block, {1, 1, kThick});
        for (Vec3d& x : mesh.nodes_mm)
            x = {48 * x.x, 44 * x.x * (1 - x.y) + (44 + 16 * x.x) * x.y, x.z};
        PbdParts parts = solids_of(mesh, {2 * 422500 * 1.3, 0.3, 2, 1e-3});
        std::vector<std::int32_t> nodes;
        std::vector<Vec3d> forces;
        std::int32_t corner = 0;
        const auto is_end = [](Vec3d x) { return x.x > 48 - 1e-9; };
        for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
            const Vec3d x = mesh.nodes_mm[n];
            if (x.x < 1e-9) parts.inverse_masses[n] = 0;
            if (norm(x - Vec3d{48, 60, kThick / 2}) < 1e-6) corner = std::int32_t(n);
            if (!is_end(x)) continue;
            nodes.push_back(std::int32_t(n));
            forces.push_back({0, 0, 0});
        }
        for (const auto& face : boundary_faces(mesh)) {
            const auto at = [&](int n) { return mesh.nodes_mm[std::size_t(face[std::size_t(n)])]; };
            if (!is_end(at(0)) || !is_end(at(1)) || !is_end(at(2))) continue;
            const double area = norm(cross(at(1) - at(0), at(2) - at(0))) / 2;
            for (const std::int32_t n : face)
                forces[std::size_t(std::ranges::lower_bound(nodes, n) - nodes.begin())].y +=
                    kTraction * area / 3;
        }
        Way fine = kFloat;
        fine.sub_steps = 3;  // with twice those of a wave the small cells don't stay finite
        PbdBody body = body_of(std::move(parts), fine, 2e-3, {0, 0, 0}, 400);
        constexpr int kRamp = 10;
        for (int step = 1; step <= kRamp; ++step) {
            std::vector<Vec3d> share = forces;
            for (Vec3d& f : share) f = double(step) / kRamp * f;
            computed(body.load(nodes, share));
            computed(body.step(1, arena));
        }
        computed(body.step(20, arena));
        one.results.push_back({kFloat.model, cells_name(block),
                               body.position(corner).y - mesh.nodes_mm[std::size_t(corner)].y});
    }
    cases.push_back(std::move(one));
}

/// A ring about the z axis of hexahedra with six tetrahedra each.
TetMesh ring(Vec3i cells, double inner, double outer, double height) {
    TetMesh mesh;
    const auto node = [&](Vec3i at) {
        return at.x + (cells.x + 1) * (at.y % cells.y + cells.y * at.z);
    };
    for (int k = 0; k <= cells.z; ++k)
        for (int j = 0; j < cells.y; ++j)
            for (int i = 0; i <= cells.x; ++i) {
                const double r = inner + (outer - inner) * i / cells.x,
                             angle = 2 * std::numbers::pi * j / cells.y;
                mesh.nodes_mm.push_back(
                    {r * std::cos(angle), r * std::sin(angle), height * k / cells.z});
            }
    for (int k = 0; k < cells.z; ++k)
        for (int j = 0; j < cells.y; ++j)
            for (int i = 0; i < cells.x; ++i)
                for (int order = 0; order < 6; ++order) {
                    Vec3i at{i, j, k};
                    std::array<std::int32_t, 4> tet{node(at)};
                    for (int step = 0; step < 3; ++step) {
                        ++at[kOrders[order][step]];
                        tet[std::size_t(step + 1)] = node(at);
                    }
                    if (order >= 3) std::swap(tet[1], tet[2]);
                    mesh.cells.push_back(tet);
                }
    return mesh;
}

// A thick tube with free ends under an inner pressure, so small that the law is linear.
void add_tube(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kInner = 2, kOuter = 3, kPressure = 665;
    for (const double nu : {0.3, 0.45, 0.49}) {
        const Tissue tissue{6e5, nu, 2, 1e-3};
        const double a2 = kInner * kInner, b2 = kOuter * kOuter;
        ConformanceCase one{
            "thick tube under inner pressure, Poisson's ratio " + std::to_string(nu).substr(0, 4),
            "radial displacement of the inner wall [um]", "Lame1852",
            1e3 * kPressure * kInner / tissue.young * ((a2 + b2) / (b2 - a2) + nu), 0.03};
        for (const int across : {2, 4}) {
            const Vec3i block{across, 12 * across, 2};
            const TetMesh mesh = ring(block, kInner, kOuter, 2.0 / across);
            std::vector<std::int32_t> nodes;
            for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
                if (std::hypot(mesh.nodes_mm[n].x, mesh.nodes_mm[n].y) < kInner + 1e-9)
                    nodes.push_back(std::int32_t(n));
            std::vector<Vec3d> forces(nodes.size(), Vec3d{0, 0, 0});
            const auto place = [&](std::int32_t n) {
                return std::size_t(std::ranges::lower_bound(nodes, n) - nodes.begin());
            };
            for (const auto& face : boundary_faces(mesh)) {
                const auto at = [&](int n) {
                    return mesh.nodes_mm[std::size_t(face[std::size_t(n)])];
                };
                const auto is_inner = [&](std::int32_t n) {
                    return std::ranges::binary_search(nodes, n);
                };
                if (!std::ranges::all_of(face, is_inner)) continue;
                const Vec3d area = 0.5 * cross(at(1) - at(0), at(2) - at(0));
                for (const std::int32_t n : face)
                    forces[place(n)] = forces[place(n)] - kPressure / 3 * area;
            }
            PbdBody body = body_of(solids_of(mesh, tissue), kFloat, 1e-3, {0, 0, 0}, 1500);
            computed(body.load(nodes, forces));
            computed(body.step(8, arena));
            double moved = 0;
            for (const std::int32_t n : nodes) {
                const Vec3d x = body.position(n);
                moved += 1e3 * (std::hypot(x.x, x.y) - kInner) / double(nodes.size());
            }
            one.results.push_back({kFloat.model, cells_name(block), moved});
        }
        cases.push_back(std::move(one));
    }
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
    add_indenter(cases, arena);
    add_spheres(cases, arena);
    add_cook(cases, arena);
    add_tube(cases, arena);
    return cases;
}

}  // namespace pliant::app
