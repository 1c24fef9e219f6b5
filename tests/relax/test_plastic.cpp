// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: chainmail/carve.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "chainmail/chainmail_impl.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"

namespace pliant::test {
namespace {

constexpr double kUnit = 1.0 / (1 << 20);  // [mm]

MaterialLaw yielding(double limit, double yield, double max_movement_mm = 500) {
    return [=](int) {
        ElementLimits limits{{limit, limit, limit},
                             {limit, limit, limit},
                             {limit, limit, limit},
                             max_movement_mm,
                             false};
        limits.yield = yield;
        return limits;
    };
}

bool settle(ChainMail& tissue, const std::vector<Vec3i>& held = {}) {
    const auto report = tissue.relax({.max_sweeps = 20000, .held = held});
    return report.ok() && report->settled;
}

TEST(Plastic, APushBelowTheYieldLimitLeavesNothing) {
    const TaskArena arena(1);
    const Volume volume = block({20, 20, 20}, 0);
    // 0.1 mm on links of 1 mm: a tenth of the limit and of the yield limit's 0.12 mm.
    ChainMail tissue = tissue_of(volume, yielding(0.4, 0.3), arena);
    ASSERT_TRUE(tissue.push_elements({{{9, 9, 9}, {10, 9, 9}}}, {0.1, 0.05, 0}).ok());
    EXPECT_EQ(tissue.imprint_mm({9, 9, 9}), (Vec3d{0, 0, 0}));
    EXPECT_TRUE(settle(tissue));
    EXPECT_EQ(tissue.moved_box(), Box3i{});
    EXPECT_EQ(tissue.state().resident_bricks, 0);
}

TEST(Plastic, APushBeyondItLeavesTheImprintThatTheYieldLimitSays) {
    const TaskArena arena(2);
    const Volume volume = block({24, 24, 24}, 0);
    ChainMail tissue = tissue_of(volume, yielding(0.2, 0.25), arena);
    const Vec3i centre{12, 12, 12};
    ASSERT_TRUE(tissue.push_elements({{centre}}, {1, 0, 0}).ok());
    // The push decays by 0.2 mm per link, so it moves elements at most 4 links away. The elastic
    // rest decays by 0.05 mm per link from there on.
    const auto away = [&](Vec3i e) {
        return std::abs(e.x - centre.x) + std::abs(e.y - centre.y) + std::abs(e.z - centre.z);
    };
    const auto expected = [&](Vec3i e) { return std::max(0.0, (5 - away(e)) * (0.2 - 0.05)); };
    const auto worst = [&](auto&& found) {
        double apart = 0;
        for (int z = 4; z < 21; ++z)
            for (int y = 4; y < 21; ++y)
                for (int x = 4; x < 21; ++x)
                    apart = std::max(
                        apart, norm(found(Vec3i{x, y, z}) - Vec3d{expected({x, y, z}), 0, 0}));
        return apart;
    };
    const auto imprint = [&](Vec3i e) { return tissue.imprint_mm(e); };
    const auto displacement = [&](Vec3i e) { return tissue.displacement_mm(e); };
    EXPECT_LT(worst(imprint), 12 * kUnit);
    EXPECT_GT(worst(displacement), 0.24);
    EXPECT_NEAR(tissue.imprint_mm(centre).x, 0.75, 12 * kUnit);
    // Released, it returns to the imprint, and stays there.
    EXPECT_TRUE(settle(tissue));
    EXPECT_LT(worst(displacement), 12 * kUnit);
    EXPECT_EQ(tissue.elastic_energy_mm2(), 0);
    const std::uint64_t hash = tissue.hash();
    EXPECT_TRUE(settle(tissue));
    EXPECT_EQ(tissue.hash(), hash);
    EXPECT_EQ(tissue.state().max_violation_mm, 0);
}

TEST(Plastic, CarvedElementsLoseTheirImprintAndTheirNeighboursDoNot) {
    const TaskArena arena(1);
    const Volume volume = block({24, 24, 24}, 0);
    ChainMail tissue = tissue_of(volume, yielding(0.2, 0.25), arena);
    ASSERT_TRUE(tissue.push_elements({{{12, 12, 12}}}, {1, 0, 0}).ok());
    std::vector<Vec3d> before;
    for_each_element(volume.grid, [&](Vec3i e) { before.push_back(tissue.imprint_mm(e)); });
    ASSERT_TRUE(
        tissue.carve({.from_mm = {13, 12, 12}, .to_mm = {13, 12, 12}, .radius_mm = 0.5}).ok());
    EXPECT_EQ(tissue.state().carved_elements, 1);
    int kept = 0;
    for_each_element(volume.grid, [&](Vec3i e) {
        const bool is_void = lattice_of(tissue).is_void(e);
        const Vec3d expected = is_void ? Vec3d{0, 0, 0} : before[voxel_index(volume.grid, e)];
        EXPECT_EQ(tissue.imprint_mm(e), expected);
        kept += expected != Vec3d{0, 0, 0};
    });
    EXPECT_GT(kept, 50);
}

TEST(Plastic, PushesToTheSamePlaceDoNotDeepenTheImprint) {
    const TaskArena arena(1);
    const Volume volume = block({24, 24, 24}, 0);
    ChainMail tissue = tissue_of(volume, yielding(0.2, 0.25), arena);
    const std::vector<Vec3i> tip{{12, 12, 12}};
    double imprint = 0;
    for (int n = 0; n < 6; ++n) {
        const double place = tissue.displacement_mm(tip[0]).x;
        ASSERT_TRUE(tissue.push_elements(tip, {1 - place, 0, 0}).ok());
        EXPECT_TRUE(settle(tissue));
        if (n == 0) imprint = tissue.imprint_mm(tip[0]).x;
        EXPECT_NEAR(tissue.imprint_mm(tip[0]).x, imprint, 2 * kUnit);
    }
}

TEST(Plastic, EqualPushesFromTheImprintEndAtTheMovementLimit) {
    const TaskArena arena(1);
    const Volume volume = block({24, 24, 24}, 0);
    ChainMail tissue = tissue_of(volume, yielding(0.2, 0.25, 1.5), arena);
    const std::vector<Vec3i> tip{{12, 12, 12}};
    for (int n = 0; n < 6; ++n) {
        ASSERT_TRUE(tissue.push_elements(tip, {1, 0, 0}).ok());
        EXPECT_TRUE(settle(tissue));
        EXPECT_LE(tissue.state().max_movement_mm, 1.5);
        EXPECT_LE(tissue.imprint_mm(tip[0]).x, 1.5);
    }
    EXPECT_GT(tissue.imprint_mm(tip[0]).x, 1);
}

TEST(Plastic, AYieldOfOneLeavesNothingAndAPushBackTakesAnImprintAway) {
    const TaskArena arena(1);
    const Volume volume = block({20, 20, 20}, 0);
    const std::vector<Vec3i> tip{{10, 10, 10}};
    ChainMail stiff = tissue_of(volume, yielding(0.2, 1), arena);
    ASSERT_TRUE(stiff.push_elements(tip, {1, 0, 0}).ok());
    EXPECT_EQ(stiff.imprint_mm(tip[0]), (Vec3d{0, 0, 0}));

    ChainMail soft = tissue_of(volume, yielding(0.2, 0.25), arena);
    ASSERT_TRUE(soft.push_elements(tip, {1, 0, 0}).ok());
    EXPECT_TRUE(settle(soft));
    const double imprint = soft.imprint_mm(tip[0]).x;
    EXPECT_GT(imprint, 0.7);
    ASSERT_TRUE(soft.push_elements(tip, {-1.5, 0, 0}).ok());
    EXPECT_TRUE(settle(soft));
    EXPECT_LT(soft.imprint_mm(tip[0]).x, 0);
}

struct ByCoord {
    bool operator()(Vec3i p, Vec3i q) const {
        return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
    }
};

/// One component of the flow by its definition, over all links again and again [Bellman1958].
/// @param moved  by element; the others stay at zero
std::map<Vec3i, std::int64_t, ByCoord> flowed(const std::map<Vec3i, std::int64_t, ByCoord>& e,
                                              const auto& room) {
    auto low = e, high = e;
    for (bool changed = true; changed;) {
        changed = false;
        for (auto& [p, value] : low)
            for (int side = 0; side < 6; ++side) {
                Vec3i q = p;
                q[side / 2] += side % 2 ? 1 : -1;
                const bool there = e.contains(q);
                const auto [down, up] = room(p, q);  // bounds of e(p) − e(q)
                const std::int64_t most = (there ? low[q] : 0) + up;
                const std::int64_t least = (there ? high[q] : 0) - down;
                if (value > most) value = most, changed = true;
                if (high[p] < least) high[p] = least, changed = true;
            }
    }
    auto kept = e;
    for (auto& [p, value] : kept) value = std::max(low[p], std::min<std::int64_t>(high[p], 0));
    return kept;
}

std::uint64_t imprint_hash(const ChainMail& tissue, Vec3i low, Vec3i high) {
    std::uint64_t hash = 0;
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x)
                for (int a = 0; a < 3; ++a)
                    hash = hash * 1099511628211u +
                           std::uint64_t(std::lround(tissue.imprint_mm({x, y, z})[a] / kUnit));
    return hash;
}

TEST(Plastic, TheFlowIsWhatItsDefinitionSaysForAnyThreadsAndBricks) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = random_instance(random, 6, 10, false);
        const double yields[3] = {0, random.real(0.1, 0.9), random.real(0.1, 0.9)};
        const MaterialLaw law = [&](int value) {
            ElementLimits limits = instance.law(value);
            limits.yield = yields[value >= 0 ? value % 3 : 1];
            return limits;
        };
        const Grid& grid = instance.volume.grid;
        const auto grabbed = random_grab(random, grid);
        const auto others = random_grab(random, grid);
        const auto run = [&](int threads, int brick_size) {
            const TaskArena arena(threads);
            ChainMail tissue = tissue_of(instance.volume, law, arena, brick_size);
            EXPECT_TRUE(tissue.push_elements(grabbed, {0.9, -0.3, 0}).ok());
            EXPECT_TRUE(tissue.push_elements(others, {-0.5, 0, 0.4}).ok());
            return imprint_hash(tissue, {-10, -10, -10}, grid.size + Vec3i{10, 10, 10});
        };
        const std::uint64_t expected = run(1, 8);
        EXPECT_EQ(run(2, 8), expected);
        EXPECT_EQ(run(3, 5), expected);
        EXPECT_EQ(run(1, 16), expected);

        // One push by its definition.
        const TaskArena arena(1);
        ChainMail tissue = tissue_of(instance.volume, law, arena);
        ASSERT_TRUE(tissue.push_elements(grabbed, {0.9, -0.3, 0}).ok());
        const Lattice& lattice = lattice_of(tissue);
        for (int a = 0; a < 3; ++a) {
            std::map<Vec3i, std::int64_t, ByCoord> e;
            for (const int index : lattice.resident_bricks())
                for (int n = 0; n < lattice.elements_per_brick(); ++n) {
                    const Vec3i p = lattice.element_of(lattice.brick(index).coord, n);
                    if (lattice.displacement_at(p) != Vec3<Fixed>{0, 0, 0})
                        e[p] = lattice.displacement_at(p)[a];
                }
            const auto room = [&](Vec3i p, Vec3i q) {
                const int b = p.x != q.x ? 0 : p.y != q.y ? 1 : 2;
                const bool upper = p[b] > q[b];
                std::int64_t up = 0, down = 0, up_yield = 0, down_yield = 0;
                for (const Vec3i end : {p, q}) {
                    const ElementLimits l = law(lattice.value_at(end));
                    const auto half = [&](const Vec3d& f) {
                        return std::int64_t(std::floor(grid.spacing_mm[b] * f[b] / 2 * (1 << 20)));
                    };
                    const std::int64_t most = half(a == b ? l.stretch : l.shear);
                    const std::int64_t least = half(a == b ? l.compress : l.shear);
                    const auto share = std::int64_t(std::lround(l.yield * (1 << 16)));
                    constexpr std::int64_t kNever = 1 << 29;
                    up += most, down += least;
                    up_yield += share ? most * share / (1 << 16) : kNever;
                    down_yield += share ? least * share / (1 << 16) : kNever;
                }
                const std::int64_t stretched =
                    (upper ? 1 : -1) *
                    (std::int64_t(lattice.displacement_at(p)[a]) - lattice.displacement_at(q)[a]);
                const auto most = std::min(up_yield, stretched + down);
                const auto least = std::min(down_yield, up - stretched);
                return upper ? std::pair{least, most} : std::pair{most, least};
            };
            for (const auto& [p, kept] : flowed(e, room))
                ASSERT_EQ(std::lround(tissue.imprint_mm(p)[a] / kUnit), e[p] - kept);
        }
    }
}

TEST(Plastic, RelaxingTowardsAnImprintNeverRaisesTheEnergy) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = random_instance(random, 8, 12, false);
        const MaterialLaw law = [&, yield = random.real(0.1, 0.8)](int value) {
            ElementLimits limits = instance.law(value);
            limits.yield = yield;
            return limits;
        };
        const TaskArena arena(1);
        ChainMail tissue = tissue_of(instance.volume, law, arena);
        ASSERT_TRUE(
            tissue.push_elements(random_grab(random, instance.volume.grid), {.8, .3, 0}).ok());
        ASSERT_TRUE(
            tissue.push_elements(random_grab(random, instance.volume.grid), {-.3, .3, .6}).ok());
        double last = tissue.elastic_energy_mm2();
        EXPECT_GT(last, 0);
        for (int sweep = 0; sweep < 30; ++sweep) {
            ASSERT_TRUE(tissue.relax({.max_sweeps = 1}).ok());
            const double now = tissue.elastic_energy_mm2();
            ASSERT_LE(now, last);
            last = now;
        }
        EXPECT_TRUE(settle(tissue));
        double farthest = 0;
        for (int z = -8; z < 20; ++z)
            for (int y = -8; y < 20; ++y)
                for (int x = -8; x < 20; ++x)
                    farthest = std::max(farthest, norm(tissue.displacement_mm({x, y, z}) -
                                                       tissue.imprint_mm({x, y, z})));
        EXPECT_LT(farthest, 1e-3);
    }
}

TEST(Plastic, TheImprintCountsAsMemory) {
    const TaskArena arena(1);
    const Volume volume = block({20, 20, 20}, 0);
    ChainMail without = tissue_of(volume, yielding(0.2, 0), arena);
    ChainMail with = tissue_of(volume, yielding(0.2, 0.25), arena);
    for (ChainMail* tissue : {&without, &with})
        ASSERT_TRUE(tissue->push_elements({{{10, 10, 10}}}, {1, 0, 0}).ok());
    EXPECT_EQ(with.hash(), without.hash());
    EXPECT_GT(with.state().bytes_per_resident_element, without.state().bytes_per_resident_element);
}

}  // namespace
}  // namespace pliant::test
