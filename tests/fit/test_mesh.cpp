// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Networks on meshes: the finite elements against strain matrices and elimination, planted values
// found again from displacements at nodes and at points, confidence intervals against refits under
// noise, creep against a tissue that runs.
// Covers: fit/creep.cpp, fit/elastic_tetrahedra.cpp, fit/intervals.cpp.

#include <gtest/gtest.h>
#include <pliant/models/fit_mesh.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "fit/elastic_tetrahedra.h"
#include "support/random.h"

namespace pliant::test {
namespace {

const TaskArena& two() {
    static const TaskArena arena(2);
    return arena;
}

template <class T>
T must(Result<T> result) {
    if (!result.ok()) throw std::runtime_error(result.error().message);
    return std::move(result).value();
}

/// Block of 3 x 3 x 4 cells of 10 mm with shaken inner nodes.
TetMesh block(std::uint64_t seed) {
    Random random(seed);
    TetMesh mesh = five_tet_block({3, 3, 4}, 10);
    for (Vec3d& node : mesh.nodes_mm) node = node + random.vector(1.2);
    return mesh;
}

/// The block in two regions, held at the bottom, loaded at the top: pulled aside, and pressed.
FitMesh set_up(std::uint64_t seed) {
    FitMesh f{.mesh = block(seed), .regions = {{"1", 12e3, 0.4}, {"2", 40e3, 0.45}}};
    f.volume_energy = true;
    for (const auto& cell : f.mesh.cells) {
        double z = 0;
        for (const std::int32_t n : cell) z += 0.25 * f.mesh.nodes_mm[std::size_t(n)].z;
        f.region_of.push_back(z > 20);
    }
    std::vector<std::int32_t> top, side;
    for (std::size_t n = 0; n < f.mesh.nodes_mm.size(); ++n) {
        const Vec3d p = f.mesh.nodes_mm[n];
        if (p.z < 3) f.held.push_back(std::int32_t(n));
        if (p.z > 37) top.push_back(std::int32_t(n));
        if (p.x > 27 && p.z > 12 && p.z < 33) side.push_back(std::int32_t(n));
    }
    f.loads = {{.name = "aside", .nodes = side, .force_n = {0.3, 0.1, 0}},
               {.name = "press", .nodes = top, .force_n = {0, 0.05, -0.6}}};
    return f;
}

double gaussian(Random& random) {
    const double radius = std::sqrt(-2 * std::log(random.real(1e-12, 1)));
    return radius * std::cos(2 * std::numbers::pi * random.real(0, 1));
}

/// Solves by elimination with row exchanges.
std::vector<double> eliminate(std::vector<std::vector<double>> a, std::vector<double> b) {
    const std::size_t size = b.size();
    for (std::size_t c = 0; c < size; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c + 1; r < size; ++r)
            if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
        std::swap(a[c], a[pivot]);
        std::swap(b[c], b[pivot]);
        for (std::size_t r = c + 1; r < size; ++r) {
            const double part = a[r][c] / a[c][c];
            for (std::size_t k = c; k < size; ++k) a[r][k] -= part * a[c][k];
            b[r] -= part * b[c];
        }
    }
    for (std::size_t c = size; c-- > 0;) {
        for (std::size_t k = c + 1; k < size; ++k) b[c] -= a[c][k] * b[k];
        b[c] /= a[c][c];
    }
    return b;
}

/// Stiffness Bᵀ D B V of a tetrahedron, with engineering shear strains; gradients by elimination.
std::array<std::array<double, 12>, 12> strain_stiffness(const std::array<Vec3d, 4>& x, double e,
                                                        double nu) {
    std::array<Vec3d, 4> g;
    for (std::size_t a = 0; a < 4; ++a) {
        std::vector<std::vector<double>> rows;
        std::vector<double> right;
        for (std::size_t n = 0; n < 4; ++n) {
            rows.push_back({1, x[n].x, x[n].y, x[n].z});
            right.push_back(n == a);
        }
        const auto c = eliminate(rows, right);
        g[a] = {c[1], c[2], c[3]};
    }
    double b[6][12] = {};
    for (std::size_t a = 0; a < 4; ++a) {
        const std::size_t at = 3 * a;
        b[0][at] = g[a].x;
        b[1][at + 1] = g[a].y;
        b[2][at + 2] = g[a].z;
        b[3][at + 1] = g[a].z;
        b[3][at + 2] = g[a].y;
        b[4][at] = g[a].z;
        b[4][at + 2] = g[a].x;
        b[5][at] = g[a].y;
        b[5][at + 1] = g[a].x;
    }
    const double scale = e / ((1 + nu) * (1 - 2 * nu));
    const double volume = dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / 6;
    std::array<std::array<double, 12>, 12> k{};
    for (std::size_t p = 0; p < 12; ++p)
        for (std::size_t q = 0; q < 12; ++q)
            for (std::size_t i = 0; i < 6; ++i)
                for (std::size_t j = 0; j < 6; ++j) {
                    double d = 0;
                    if (i < 3 && j < 3) d = scale * (i == j ? 1 - nu : nu);
                    if (i >= 3 && i == j) d = scale * (1 - 2 * nu) / 2;
                    k[p][q] += volume * b[i][p] * d * b[j][q];
                }
    return k;
}

TEST(Annealing, ByTurnsTheLessSharpTissueDoesNotStayBehind) {
    FitMesh f = set_up(1);
    f.volume_energy = false;
    const auto fitted = must(fit_mesh(f, two()));
    const double best = must(fit(fitted.problem, GaussNewton{}, two())).values[1];
    double farthest[2] = {0, 0};
    for (const bool by_turns : {false, true})
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            const auto found =
                must(fit(fitted.problem, Annealing{.seed = seed, .by_turns = by_turns}, two()));
            double& most = farthest[by_turns];
            most = std::max(most, std::abs(std::log(found.values[1] / best)));
        }
    EXPECT_GT(farthest[0], 1);
    EXPECT_LT(farthest[1], 0.5);
}

TEST(ElasticTetrahedra, MoveAsStrainMatricesSay) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(seed);
        const FitMesh f = set_up(seed);
        const std::size_t count = f.mesh.nodes_mm.size();
        std::vector<std::uint8_t> held(count, 0);
        for (const std::int32_t n : f.held) held[std::size_t(n)] = 1;
        std::vector<std::vector<double>> k(3 * count, std::vector<double>(3 * count, 0));
        for (std::size_t t = 0; t < f.mesh.cells.size(); ++t) {
            const FitRegion& region = f.regions[std::size_t(f.region_of[t])];
            std::array<Vec3d, 4> x;
            for (std::size_t n = 0; n < 4; ++n)
                x[n] = f.mesh.nodes_mm[std::size_t(f.mesh.cells[t][n])];
            const auto own = strain_stiffness(x, region.young_modulus_pa, region.poisson_ratio);
            for (std::size_t p = 0; p < 12; ++p)
                for (std::size_t q = 0; q < 12; ++q)
                    k[3 * std::size_t(f.mesh.cells[t][p / 3]) + p % 3]
                     [3 * std::size_t(f.mesh.cells[t][q / 3]) + q % 3] += own[p][q];
        }
        Random random(seed);
        std::vector<Vec3d> force(count);
        std::vector<double> right(3 * count, 0);
        for (std::size_t n = 0; n < count; ++n) {
            force[n] = random.vector(1e4);
            for (std::size_t a = 0; a < 3; ++a)
                if (!held[n]) right[3 * n + a] = force[n][int(a)];
            if (!held[n]) continue;
            for (std::size_t a = 0; a < 3; ++a) {
                for (double& entry : k[3 * n + a]) entry = 0;
                k[3 * n + a][3 * n + a] = 1;
            }
        }
        const auto expected = eliminate(std::move(k), std::move(right));
        const ElasticTetrahedra elastic(f.mesh, f.regions, f.region_of, held);
        ASSERT_TRUE(elastic.is_supported());
        const auto found = elastic.displacements_mm(force);
        double largest = 0;
        for (const Vec3d u : found) largest = std::max(largest, norm(u));
        EXPECT_GT(largest, 0.01);
        for (std::size_t n = 0; n < count; ++n)
            for (std::size_t a = 0; a < 3; ++a)
                ASSERT_NEAR(found[n][int(a)], expected[3 * n + a], 1e-9 * largest) << n;
        std::vector<std::uint8_t> loose(count, 0);
        loose[0] = 1;
        EXPECT_FALSE(ElasticTetrahedra(f.mesh, f.regions, f.region_of, loose).is_supported());
    }
}

TEST(FitMesh, SpringsMoveAlmostAsTheElementsAndTwoTissuesAreToldApart) {
    const auto fitted = must(fit_mesh(set_up(4), two()));
    const auto groups = fitted.problem.groups();
    ASSERT_EQ(groups.size(), 4u);
    EXPECT_EQ(groups[0].name, "links 1");
    EXPECT_EQ(groups[3].name, "volume 2");
    const auto start = must(fit(fitted.problem, GivenValues{fitted.closed_form}, two()));
    const auto found = must(fit(fitted.problem, GaussNewton{}, two()));
    EXPECT_LT(found.at.cost, start.at.cost);
    for (const FitCaseErrors& c : found.at.cases) {
        EXPECT_LT(c.average_percent, 0.1 * c.still_average_percent) << c.name;
        EXPECT_GT(c.still_average_percent, 0.1);
    }
    // Shear moduli of the elements: 12000/2.8 and 40000/2.9 Pa.
    EXPECT_NEAR(found.values[0] / (12e3 / 2.8), 1, 0.3);
    EXPECT_NEAR(found.values[2] / (40e3 / 2.9), 1, 0.3);
}

/// The problem with displacements at points as targets, of a network with known values.
struct Measured {
    FitMesh set_up;
    std::vector<double> truth;

    Measured(std::uint64_t seed, int points) : set_up(test::set_up(seed)) {
        Random random(seed);
        const auto fitted = must(fit_mesh(set_up, two()));
        for (const double start : fitted.closed_form) truth.push_back(start * random.ratio(0.5, 2));
        for (std::size_t c = 0; c < 2; ++c) {
            const auto moved = must(fitted.problem.displacements(truth, c));
            for (int p = 0; p < points; ++p) {
                const auto& cell =
                    set_up.mesh
                        .cells[std::size_t(random.whole(0, int(set_up.mesh.cells.size()) - 1))];
                std::array<double, 4> w;
                double sum = 0;
                for (double& weight : w) sum += weight = random.real(0.05, 1);
                FitMeasurement m;
                for (std::size_t n = 0; n < 4; ++n) {
                    const auto node = std::size_t(cell[n]);
                    m.position_mm = m.position_mm + (w[n] / sum) * set_up.mesh.nodes_mm[node];
                    m.displacement_mm = m.displacement_mm + (w[n] / sum) * moved[node];
                }
                set_up.loads[c].measured.push_back(m);
            }
        }
    }
    FitMesh with_noise(Random& random, double noise) const {
        FitMesh noisy = set_up;
        for (FitMeshLoad& load : noisy.loads)
            for (FitMeasurement& m : load.measured)
                m.displacement_mm =
                    m.displacement_mm +
                    noise * Vec3d{gaussian(random), gaussian(random), gaussian(random)};
        return noisy;
    }
};

TEST(FitMesh, PlantedValuesAreFoundFromDisplacementsAtPoints) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(seed);
        const Measured measured(seed, 40);
        for (const FitCost cost : {FitCost::Distances, FitCost::Squares}) {
            FitMesh f = measured.set_up;
            f.settings.cost = cost;
            const auto fitted = must(fit_mesh(f, two()));
            EXPECT_TRUE(fitted.problem.cases()[0].target.empty());
            const auto found = must(fit(fitted.problem, GaussNewton{}, two()));
            for (std::size_t g = 0; g < 4; ++g)
                EXPECT_NEAR(found.values[g] / measured.truth[g], 1, 1e-3) << g;
            for (const Vec3d r : must(fitted.problem.residuals(found.values, 1)))
                EXPECT_LT(norm(r), 1e-4);
        }
    }
}

TEST(FitMesh, IntervalsHoldTheTruthInNineteenOfTwentyRefitsUnderNoise) {
    constexpr int kRefits = 150;
    constexpr double kNoise_mm = 0.003;
    for (const FitCost cost : {FitCost::Squares, FitCost::Distances}) {
        SCOPED_TRACE(int(cost));
        int covered = 0, all = 0;
        double smallest = 1e9, largest = 0;
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const Measured measured(seed, 60);
            Random random(100 * seed);
            for (int n = 0; n < kRefits / 3; ++n) {
                FitMesh f = measured.with_noise(random, kNoise_mm);
                f.settings.cost = cost;
                f.range = 100;
                const auto fitted = must(fit_mesh(f, two()));
                const auto found = must(fit(fitted.problem, GaussNewton{}, two()));
                const auto intervals =
                    must(fit_intervals(fitted.problem, found.values, kNoise_mm, two()));
                for (std::size_t g = 0; g < 4; ++g) {
                    ASSERT_TRUE(intervals[g].identifiable);
                    ++all;
                    covered += intervals[g].low <= measured.truth[g] &&
                               measured.truth[g] <= intervals[g].high;
                    const double ratio = intervals[g].high / intervals[g].low;
                    smallest = std::min(smallest, ratio);
                    largest = std::max(largest, ratio);
                }
            }
        }
        // 600 values, correlated within a refit: 0.95 with a standard deviation of about 0.012.
        const double coverage = double(covered) / all;
        RecordProperty("coverage", std::to_string(coverage));
        std::printf("coverage %.3f, high/low %.3f to %.3f\n", coverage, smallest, largest);
        EXPECT_GT(coverage, 0.915);
        EXPECT_LT(coverage, 0.985);
        EXPECT_GT(smallest, 1.0001);
        EXPECT_LT(largest, 30);
    }
}

TEST(FitMesh, AValueWithoutInfluenceHasNoInterval) {
    FitMesh f = set_up(5);
    // The upper region is held as a whole: its links don't stretch.
    for (std::size_t t = 0; t < f.mesh.cells.size(); ++t)
        if (f.region_of[t] == 1)
            f.held.insert(f.held.end(), f.mesh.cells[t].begin(), f.mesh.cells[t].end());
    std::sort(f.held.begin(), f.held.end());
    f.held.erase(std::unique(f.held.begin(), f.held.end()), f.held.end());
    f.loads.pop_back();
    f.loads[0].nodes.clear();
    for (std::size_t n = 0; n < f.mesh.nodes_mm.size(); ++n)
        if (!std::binary_search(f.held.begin(), f.held.end(), std::int32_t(n)) &&
            f.mesh.nodes_mm[n].x > 27)
            f.loads[0].nodes.push_back(std::int32_t(n));
    const auto fitted = must(fit_mesh(f, two()));
    const auto found = must(fit(fitted.problem, GaussNewton{}, two()));
    const auto intervals = must(fit_intervals(fitted.problem, found.values, 0.01, two()));
    EXPECT_TRUE(intervals[0].identifiable);
    EXPECT_TRUE(intervals[1].identifiable);
    EXPECT_FALSE(intervals[2].identifiable);
    EXPECT_FALSE(intervals[3].identifiable);
    EXPECT_TRUE(std::isinf(intervals[2].high));
    const NetworkFile network = network_of(fitted, found, intervals);
    EXPECT_EQ(network.groups[2].note, "not identifiable");
    EXPECT_EQ(network.groups[0].note, "");
    EXPECT_LT(network.groups[0].low, network.groups[0].value);
    EXPECT_GT(network.groups[0].high, network.groups[0].value);
    for (const double noise : {0.0, -1.0, std::nan("")})
        EXPECT_FALSE(fit_intervals(fitted.problem, found.values, noise, two()).ok());
}

TEST(FitMesh, AValueAtItsBoundIsNotedInTheNetwork) {
    FitMesh f = set_up(6);
    f.range = 1.001;
    const Measured measured(6, 30);
    for (std::size_t l = 0; l < 2; ++l) f.loads[l].measured = measured.set_up.loads[l].measured;
    const auto fitted = must(fit_mesh(f, two()));
    const auto found = must(fit(fitted.problem, GaussNewton{}, two()));
    const NetworkFile network = network_of(fitted, found, {});
    int noted = 0;
    for (std::size_t g = 0; g < 4; ++g) {
        if (found.at_bound[g] == FitBound::None) continue;
        ++noted;
        EXPECT_EQ(network.groups[g].note,
                  found.at_bound[g] == FitBound::Low ? "at its lower bound" : "at its upper bound");
    }
    EXPECT_GT(noted, 1);
}

TEST(FitMesh, TheNetworkHasTheValuesItsMassAndItsFixedNodes) {
    const FitMesh f = set_up(7);
    const auto fitted = must(fit_mesh(f, two()));
    const auto found = must(fit(fitted.problem, GivenValues{{1000, 2000, 3000, 4000}}, two()));
    const NetworkFile network = network_of(fitted, found, {});
    double mass_g = 0;
    for (const SpringNode& node : network.parts.nodes) mass_g += node.mass;
    EXPECT_NEAR(mass_g, 1e-3 * tet_quality(f.mesh).volume_mm3, 1e-9);
    for (const std::int32_t n : f.held) EXPECT_TRUE(network.parts.nodes[std::size_t(n)].fixed);
    // A link's stiffness: (√2/5)·µ·length for each tetrahedron of its region around the edge.
    Random random(1);
    for (int n = 0; n < 30; ++n) {
        const auto l = std::size_t(random.whole(0, int(network.parts.links.size()) - 1));
        const SpringLink& link = network.parts.links[l];
        const std::int32_t group = network.link_groups[l];
        ASSERT_TRUE(group == 0 || group == 2);
        int around = 0;
        for (std::size_t t = 0; t < f.mesh.cells.size(); ++t) {
            const auto& cell = f.mesh.cells[t];
            around += f.region_of[t] == group / 2 &&
                      std::count(cell.begin(), cell.end(), link.a) == 1 &&
                      std::count(cell.begin(), cell.end(), link.b) == 1;
        }
        const double length = norm(network.parts.nodes[std::size_t(link.a)].rest -
                                   network.parts.nodes[std::size_t(link.b)].rest);
        EXPECT_NEAR(link.stiffness,
                    std::sqrt(2.0) / 5 * (group == 0 ? 1000 : 3000) * length * around,
                    1e-9 * link.stiffness);
    }
    EXPECT_TRUE(SpringNetwork::create(network.parts).ok());
}

TEST(FitMesh, RefusesBadInputInALine) {
    const auto message = [](const auto& change) {
        FitMesh f = set_up(1);
        change(f);
        const auto fitted = fit_mesh(f, two());
        return fitted.ok() ? std::string("accepted") : fitted.error().message;
    };
    EXPECT_EQ(message([](FitMesh& f) { f.held.clear(); }),
              "held: expected nodes that don't move, found none");
    EXPECT_EQ(message([](FitMesh& f) { f.regions[1].poisson_ratio = 0.2; }),
              "region 2: expected a Poisson's ratio above 0.25 for a volume energy, found 0.2");
    EXPECT_EQ(message([](FitMesh& f) { f.regions[0].young_modulus_pa = -1; }),
              "region 1: expected a Young's modulus above 0, found -1");
    EXPECT_EQ(message([](FitMesh& f) { f.regions.push_back({"3"}); }),
              "region 3: expected one or more tetrahedra, found none");
    EXPECT_EQ(message([](FitMesh& f) { f.region_of.pop_back(); }),
              "region_of: expected 180 numbers, found 179");
    EXPECT_EQ(message([](FitMesh& f) { f.loads.clear(); }),
              "loads: expected one or more, found none");
    EXPECT_EQ(message([](FitMesh& f) { f.loads[0].nodes = {80}; }),
              "load aside: expected nodes below 80, found 80");
    EXPECT_EQ(message([](FitMesh& f) { f.range = 1; }),
              "range: expected a factor above 1, found 1");
    EXPECT_NE(message([](FitMesh& f) { f.held = {0}; }).find("rigid motion"), std::string::npos);
    EXPECT_NE(message([](FitMesh& f) {
                  f.loads[0].measured = {{{500, 0, 0}, {0, 0, 0}}};
              }).find("mm of the mesh, its mean edge, found one at 500, 0, 0"),
              std::string::npos);
    EXPECT_NE(message([](FitMesh& f) {
                  std::swap(f.mesh.cells[3][0], f.mesh.cells[3][1]);
              }).find("mesh: cell 3"),
              std::string::npos);
}

// Creep.

/// Samples of a network with this damping that runs by its own, explicit solver.
std::vector<CreepSample> run_creep(const FitMeshProblem& fitted, std::span<const double> values,
                                   double damping, double duration_s) {
    SpringParts parts = fitted.problem.parts_at(values);
    for (SpringNode& node : parts.nodes) node.damping = damping * node.mass;
    auto tissue = must(SpringTissue::create(must(SpringNetwork::create(std::move(parts))),
                                            {.solver = SpringSolver::Explicit}));
    const FitCase& c = fitted.problem.cases()[0];
    // Small displacements: forces are divided, displacements multiplied.
    constexpr double kSmall = 1e-3;
    std::vector<Vec3d> forces;
    for (const Vec3d f : c.forces) forces.push_back(kSmall * f);
    EXPECT_TRUE(tissue.load(c.nodes, forces).ok());
    std::vector<CreepSample> samples;
    std::int64_t done = 0;
    for (int n = 1; n <= 20; ++n) {
        const double time_s = duration_s * n / 20;
        const auto steps = std::int64_t(std::lround(time_s / tissue.time_step()));
        EXPECT_TRUE(tissue.step(std::int32_t(steps - done), two()).ok());
        done = steps;
        for (const std::int32_t node : {c.nodes[0], c.nodes[1]})
            samples.push_back({double(steps) * tissue.time_step(), node,
                               (1 / kSmall) * tissue.displacement(node)});
    }
    return samples;
}

TEST(Creep, TheDampingOfARunningTissueIsFound) {
    for (const double damping : {300.0, 3000.0}) {
        SCOPED_TRACE(damping);
        const auto fitted = must(fit_mesh(set_up(8), two()));
        const auto samples = run_creep(fitted, fitted.closed_form, damping, 0.6);
        const auto found = must(
            fit_creep(fitted, fitted.closed_form, {.samples = samples, .noise_mm = 0.01}, two()));
        EXPECT_NEAR(found.damping_per_s / damping, 1, 0.02);
        EXPECT_EQ(found.at_bound, FitBound::None);
        double largest = 0;
        for (const CreepSample& s : samples) largest = std::max(largest, norm(s.displacement_mm));
        EXPECT_LT(found.rms_mm, 0.02 * largest);
        EXPECT_TRUE(found.interval.identifiable);
        EXPECT_LT(found.interval.low, found.damping_per_s);
        EXPECT_GT(found.interval.high, found.damping_per_s);
        const auto result = must(fit(fitted.problem, GivenValues{fitted.closed_form}, two()));
        const NetworkFile network = network_of(fitted, result, {}, &found);
        EXPECT_EQ(network.groups.back().name, "damping");
        for (const SpringNode& node : network.parts.nodes)
            EXPECT_DOUBLE_EQ(node.damping, found.damping_per_s * node.mass);
    }
}

TEST(Creep, IntervalsHoldTheTruthInNineteenOfTwentyRefitsUnderNoise) {
    constexpr double kDamping = 800, kNoise_mm = 0.1;
    constexpr int kRefits = 100;
    const auto fitted = must(fit_mesh(set_up(9), two()));
    const FitCreep settings{
        .low_per_s = 80, .high_per_s = 8000, .steps = 40, .noise_mm = kNoise_mm};
    auto samples = run_creep(fitted, fitted.closed_form, kDamping, 0.4);
    // The truth of these few steps of time.
    FitCreep clean = settings;
    clean.samples = samples;
    const double truth = must(fit_creep(fitted, fitted.closed_form, clean, two())).damping_per_s;
    Random random(3);
    int covered = 0;
    for (int n = 0; n < kRefits; ++n) {
        FitCreep noisy = clean;
        for (CreepSample& s : noisy.samples)
            s.displacement_mm =
                s.displacement_mm +
                kNoise_mm * Vec3d{gaussian(random), gaussian(random), gaussian(random)};
        const auto found = must(fit_creep(fitted, fitted.closed_form, noisy, two()));
        covered += found.interval.low <= truth && truth <= found.interval.high;
    }
    std::printf("covered %d of %d\n", covered, kRefits);
    EXPECT_GE(covered, 88);
    EXPECT_LE(covered, 99);
}

TEST(Creep, RefusesBadInputAndTellsABound) {
    const auto fitted = must(fit_mesh(set_up(8), two()));
    const std::vector<double>& values = fitted.closed_form;
    const auto message = [&](const FitCreep& creep) {
        const auto found = fit_creep(fitted, values, creep, two());
        return found.ok() ? std::string("accepted") : found.error().message;
    };
    EXPECT_EQ(message({}), "creep.samples: expected one or more, found none");
    EXPECT_EQ(message({.samples = {{0.1, 80, {}}}}),
              "creep.samples: expected nodes below 80, found 80");
    EXPECT_EQ(message({.samples = {{0, 1, {}}}}),
              "creep.samples: expected a time of 1e-9 s or more, found 0");
    EXPECT_EQ(message({.load = 2, .samples = {{1, 1, {}}}}),
              "creep.load: expected a load below 2, found 2");
    EXPECT_NE(message({.samples = {{1e-320, 1, {}}}}).find("a time of 1e-9 s or more"),
              std::string::npos);
    const auto samples = run_creep(fitted, values, 3000, 0.4);
    const auto bound = must(
        fit_creep(fitted, values,
                  {.samples = samples, .low_per_s = 1, .high_per_s = 100, .steps = 50}, two()));
    EXPECT_EQ(bound.at_bound, FitBound::High);
}

}  // namespace
}  // namespace pliant::test
