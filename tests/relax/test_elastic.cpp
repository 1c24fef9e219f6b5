// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Elastic materials: relaxation tends to the potential of its weights, and that is near to finite
// elements.
// Covers: relax/energy.cpp, relax/relax.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/models/fem.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "chainmail/tissues.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr int kBone = 1000;

/// A block whose lowest layer is bone, and a sphere at its top.
struct Pressed {
    Vec3i size{17, 17, 13};
    std::array<ElasticPair, 2> materials{};
    int soft_until = 0;  ///< elements with smaller j have the first material
    std::vector<Vec3i> tool;
    Vec3d push_mm;

    bool is_held(Vec3i e) const { return e.z == 0; }
    int material_at(Vec3i e) const { return e.y < soft_until ? 0 : 1; }
};

Pressed random_pressed(Random& random) {
    Pressed p;
    const double nu = random.real(0, 0.45);
    p.materials = {{{10, nu}, {random.ratio(5, 20), nu}}};
    p.soft_until = random.whole(0, p.size.y);
    const Vec3d centre{random.real(6, 10), random.real(6, 10), double(p.size.z - 1)};
    const double radius = random.real(2, 3.5);
    for_each_element({.size = p.size}, [&](Vec3i e) {
        if (norm(Vec3d{double(e.x), double(e.y), double(e.z)} - centre) <= radius)
            p.tool.push_back(e);
    });
    const double angle = random.real(0, 6), tilt = random.real(0, 1.2);
    p.push_mm = random.real(0.4, 0.9) * Vec3d{std::sin(tilt) * std::cos(angle),
                                              std::sin(tilt) * std::sin(angle), -std::cos(tilt)};
    return p;
}

ChainMailSettings elastic_settings(const Pressed& p) {
    ChainMailSettings settings;
    settings.bounded = true;
    settings.air_enabled = false;
    settings.elastic = p.materials[1];
    settings.label_materials = {{.values = {0}, .elastic = p.materials[0]}};
    settings.labels = std::make_shared<const Volume>(
        volume_of(p.size, [&](Vec3i e) { return p.material_at(e); }));
    return settings;
}

Volume scan_of(const Pressed& p) {
    return volume_of(p.size, [&](Vec3i e) { return p.is_held(e) ? kBone : 0; });
}

std::vector<Vec3d> pushed(const Pressed& p, const ChainMailSettings& settings, int sweeps,
                          const TaskArena& arena) {
    const Volume scan = scan_of(p);
    ChainMail tissue = tissue_of(scan, arena, settings);
    const auto report = tissue.push_elements(p.tool, p.push_mm);
    EXPECT_TRUE(report.ok() && report->step_fraction == 1);
    EXPECT_TRUE(tissue.relax({.max_sweeps = sweeps, .held = p.tool}).ok());
    EXPECT_EQ(tissue.state().max_violation_mm, 0);
    std::vector<Vec3d> all;
    for_each_element(scan.grid, [&](Vec3i e) { all.push_back(tissue.displacement_mm(e)); });
    return all;
}

std::vector<Vec3d> by_elements(const Pressed& p, const TaskArena& arena) {
    ElasticLattice solid{{p.size}, {}, {}};
    for (const ElasticPair& m : p.materials)
        solid.materials.push_back({1000 * m.young_modulus_kpa, m.poisson_ratio});
    for_each_element({.size = p.size - Vec3i{1, 1, 1}},
                     [&](Vec3i e) { solid.material_of.push_back(p.material_at(e)); });
    std::vector<Support> supports;
    for_each_element({.size = p.size}, [&](Vec3i e) {
        if (p.is_held(e)) supports.push_back({.node = node_index(solid.lattice, e)});
    });
    for (const Vec3i& e : p.tool)
        supports.push_back({.node = node_index(solid.lattice, e), .displacement_mm = p.push_mm});
    const auto solver = ElasticSolver::create(
        solid, supports, {.method = ElasticMethod::ConjugateGradients, .tolerance = 1e-6}, arena);
    EXPECT_TRUE(solver.ok());
    return solver->solve({})->displacement_mm;
}

/// Mean distance over the nodes that the second moves by more than 1 % of the push [% of it].
double mean_error(const std::vector<Vec3d>& found, const std::vector<Vec3d>& reference,
                  Vec3d push_mm) {
    double sum = 0;
    int count = 0;
    for (std::size_t n = 0; n < found.size(); ++n) {
        if (norm(reference[n]) <= 0.01 * norm(push_mm)) continue;
        sum += norm(found[n] - reference[n]);
        ++count;
    }
    return 100 * sum / count / norm(push_mm);
}

/// The potential of the weights, by plain iteration in doubles: component by component.
std::vector<Vec3d> potential(const Pressed& p) {
    const auto index = [&](Vec3i e) {
        return std::size_t(e.x + p.size.x * (e.y + p.size.y * e.z));
    };
    std::vector<Vec3d> u(index(p.size - Vec3i{1, 1, 1}) + 1, {0, 0, 0});
    std::vector<bool> stays(u.size(), false);
    for (const Vec3i& e : p.tool) u[index(e)] = p.push_mm, stays[index(e)] = true;
    for (int sweep = 0; sweep < 500; ++sweep)
        for_each_element({.size = p.size}, [&](Vec3i e) {
            if (p.is_held(e) || stays[index(e)]) return;
            Vec3d sum{0, 0, 0}, weights{0, 0, 0};
            for (int side = 0; side < 6; ++side) {
                Vec3i f = e;
                f[side / 2] += side % 2 ? 1 : -1;
                if (!contains({{0, 0, 0}, p.size}, f)) continue;
                for (int a = 0; a < 3; ++a)
                    for (const Vec3i end : {e, f}) {
                        const ElasticPair& m = p.materials[std::size_t(p.material_at(end))];
                        const double nu = m.poisson_ratio, q = (4 - 4 * nu) / (3 - 4 * nu);
                        const double w = m.young_modulus_kpa * (a == side / 2 ? q * q : 1);
                        sum[a] += w * u[index(f)][a];
                        weights[a] += w;
                    }
            }
            for (int a = 0; a < 3; ++a)
                u[index(e)][a] += 1.8 * (sum[a] / weights[a] - u[index(e)][a]);
        });
    return u;
}

TEST(Elastic, RelaxationTendsToThePotentialOfTheWeights) {
    const TaskArena arena;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Pressed p = random_pressed(random);
        p.push_mm = (0.3 / norm(p.push_mm)) * p.push_mm;  // no limit is reached
        const auto found = pushed(p, elastic_settings(p), 1 << 20, arena);
        const auto expected = potential(p);
        double worst = 0;
        for (std::size_t n = 0; n < found.size(); ++n)
            worst = std::max(worst, norm(found[n] - expected[n]));
        // Weights are whole numbers up to 32767: relative errors of 2⁻¹⁴.
        EXPECT_LT(worst, 2e-4);
    }
}

TEST(Elastic, FortySweepsAreNearFiniteElementsAndTheDefaultIsNot) {
    const TaskArena arena;
    double elastic = 0, other = 0;
    constexpr int kSeeds = 8;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Pressed p = random_pressed(random);
        const auto reference = by_elements(p, arena);
        ChainMailSettings by_value = elastic_settings(p);
        by_value.elastic.reset();
        by_value.label_materials.clear();
        const double error =
            mean_error(pushed(p, elastic_settings(p), 40, arena), reference, p.push_mm);
        EXPECT_LT(error, 14);
        elastic += error / kSeeds;
        other += mean_error(pushed(p, by_value, 40, arena), reference, p.push_mm) / kSeeds;
    }
    constexpr double kBound = 12;
    EXPECT_LT(elastic, kBound);
    EXPECT_GT(other, kBound);
    EXPECT_LT(elastic, 0.7 * other);
}

TEST(Elastic, BricksThreadsAndSlicesDoNotChangeABit) {
    const TaskArena one(1), two(2);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Pressed p = random_pressed(random);
        const Volume scan = scan_of(p);
        const auto hash_of = [&](int brick_size, bool in_slices, const TaskArena& arena) {
            ChainMailSettings settings = elastic_settings(p);
            settings.brick_size = brick_size;
            ChainMail tissue = tissue_of(scan, arena, settings);
            EXPECT_TRUE(tissue.push_elements(p.tool, p.push_mm).ok());
            for (int n = 0; n < (in_slices ? 12 : 1); ++n)
                EXPECT_TRUE(tissue.relax({.max_sweeps = in_slices ? 1 : 12, .held = p.tool}).ok());
            return tissue.hash();
        };
        const std::uint64_t expected = hash_of(8, false, one);
        EXPECT_EQ(hash_of(8, false, two), expected);
        EXPECT_EQ(hash_of(8, true, one), expected);
        EXPECT_EQ(hash_of(5, false, two), expected);
        EXPECT_EQ(hash_of(3, true, two), expected);
        EXPECT_EQ(hash_of(17, true, one), expected);
    }
}

TEST(Elastic, TheEnergyNeverRises) {
    const TaskArena arena;
    Random random(7);
    const Pressed p = random_pressed(random);
    const Volume scan = scan_of(p);
    ChainMail tissue = tissue_of(scan, arena, elastic_settings(p));
    ASSERT_TRUE(tissue.push_elements(p.tool, p.push_mm).ok());
    double last = tissue.elastic_energy_mm2();
    for (int sweep = 0; sweep < 30; ++sweep) {
        ASSERT_TRUE(tissue.relax({.max_sweeps = 1, .held = p.tool}).ok());
        const double now = tissue.elastic_energy_mm2();
        EXPECT_LE(now, last) << "sweep " << sweep;
        last = now;
    }
}

TEST(Elastic, ARelaxationThatSpreadIsUndoneAndRestored) {
    const TaskArena arena;
    Random random(9);
    const Pressed p = random_pressed(random);
    const Volume scan = scan_of(p);
    ChainMail tissue = tissue_of(scan, arena, elastic_settings(p));
    ASSERT_TRUE(tissue.push_elements(p.tool, p.push_mm).ok());
    const std::uint64_t pushed = tissue.hash();
    ASSERT_TRUE(tissue.relax({.max_sweeps = 20, .held = p.tool}).ok());
    const std::uint64_t relaxed = tissue.hash();
    ASSERT_NE(relaxed, pushed);
    ASSERT_TRUE(tissue.undo().ok());
    EXPECT_EQ(tissue.hash(), pushed);
    ASSERT_TRUE(tissue.redo().ok());
    EXPECT_EQ(tissue.hash(), relaxed);
}

TEST(Elastic, ReleasedTissueReturnsToRest) {
    const TaskArena arena;
    const Volume scan = block({17, 17, 13}, 0);
    ChainMailSettings settings;
    settings.elastic = ElasticPair{10, 0.45};
    ChainMail tissue = tissue_of(scan, arena, settings);
    ASSERT_TRUE(tissue.push({.point_mm = {8, 8, 12}, .push_mm = {0, 0, -2}}).ok());
    const auto report = tissue.relax({});
    ASSERT_TRUE(report.ok() && report->settled);
    EXPECT_EQ(tissue.state().max_movement_mm, 0);
}

}  // namespace
}  // namespace pliant::test
