// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: relax/energy.cpp, chainmail/chainmail_face.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stop_token>
#include <thread>

#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "chainmail/relaxing.h"
#include "lattice/lattice.h"
#include "relax/energy.h"
#include "relax/relax_links.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Random combinations of the constraints of relaxation.
struct Case {
    Instance instance;
    std::vector<Vec3i> held;
    std::vector<RelaxTool> tools;
    int brick_size;
    double movement_mm;
    bool with_cuts;
    MaterialLaw law;
    bool yields = false;
};

Case random_case(Random& random) {
    Case c{random_instance(random, 8, 14, random.whole(0, 1)),
           {},
           {},
           random.whole(2, 17),
           0,
           random.whole(0, 1) == 1,
           {}};
    c.movement_mm = random.whole(0, 2) ? 500 : random.real(0.3, 1.5);
    const double yield = random.whole(0, 2) ? 0 : random.real(0.1, 0.9);
    c.yields = yield > 0;
    c.law = [inner = c.instance.law, movement = c.movement_mm, yield](int value) {
        ElementLimits limits = inner(value);
        limits.max_movement_mm = movement;
        limits.yield = yield;
        return limits;
    };
    return c;
}

void edit_at_random(Random& random, Lattice& lattice) {
    for (int n = random.whole(1, 4); n > 0; --n) {
        const Vec3i coord{random.whole(0, 1), random.whole(0, 1), random.whole(0, 1)};
        BrickEdits edits(std::size_t(lattice.elements_per_brick()), 0);
        for (auto& flags : edits)
            if (random.whole(0, 4) == 0) flags = std::uint8_t(1 << random.whole(0, 2));
        lattice.set_edits(coord, edits);
    }
}

RelaxTool random_tool(Random& random, const Grid& grid) {
    const auto place = [&] {
        return world_from_voxel(grid, {random.real(0, grid.size.x), random.real(0, grid.size.y),
                                       random.real(0, grid.size.z)});
    };
    const Vec3d from = place();
    return {from, random.whole(0, 1) ? from : place(), random.real(0.5, 4)};
}

/// Link by link, for a tissue without imprints.
Energy energy_by_links(const Lattice& lattice) {
    const ElasticWeights weights(lattice.materials(), lattice.grid().spacing_mm);
    Energy sum = 0;
    const Displacements all = displacements(lattice);
    for (const auto& [e, u] : all)
        for (int side = 0; side < 6; ++side) {
            const Vec3i other = beside(e, side);
            const auto there = all.find(other);
            // A link between two of them is visited twice.
            if (side % 2 == 1 && there != all.end()) continue;
            const int b = side / 2;
            const MaterialId p = lattice.material_at(e), q = lattice.material_at(other);
            if (p == kVoidMaterial || q == kVoidMaterial) continue;
            if (!lattice.is_linked(side % 2 ? e : other, b)) continue;
            const Vec3<Fixed> v = there == all.end() ? Vec3<Fixed>{0, 0, 0} : there->second;
            for (int a = 0; a < 3; ++a) {
                const std::int64_t d = std::int64_t(u[a]) - v[a];
                sum += Energy(d * d) * Energy(weights(p, b) + weights(q, b));
            }
        }
    return sum;
}

TEST(Relax, EnergyNeverRisesAndEveryConstraintHoldsAfterEachSweep) {
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Case c = random_case(random);
        const TaskArena arena(1);
        ChainMail tissue = tissue_of(c.instance.volume, c.law, arena, c.brick_size);
        auto& lattice = lattice_of(tissue);
        if (c.with_cuts) edit_at_random(random, lattice);
        for (int n = 0; n < 3; ++n) {
            const Vec3d push = world_from_lattice_vector(
                lattice.grid(),
                {random.real(-1, 1) * c.instance.push_limit_mm.x, random.real(-1, 1), 0.5});
            c.held = random_grab(random, lattice.grid());
            ASSERT_TRUE(tissue.push_elements(c.held, push).ok());
        }
        if (random.whole(0, 2) == 0) c.held.clear();
        for (int n = random.whole(0, 2); n > 0; --n)
            c.tools.push_back(random_tool(random, lattice.grid()));
        const Displacements start = displacements(lattice);
        std::map<Vec3i, std::vector<double>, Before> distances;
        for (const auto& [e, u] : start)
            for (const RelaxTool& tool : c.tools)
                distances[e].push_back(distance_to_tool(lattice.grid(), lattice, e, tool));
        double last = tissue.elastic_energy_mm2();
        if (!c.yields) {
            EXPECT_EQ(last, mm2_from_energy(energy_by_links(lattice)));
        }
        const double omega = random.real(1, 1.95);
        for (int sweep = 0; sweep < 8; ++sweep) {
            relaxed(tissue,
                    {.max_sweeps = 1, .tools = c.tools, .held = c.held, .over_relaxation = omega});
            const double now = tissue.elastic_energy_mm2();
            ASSERT_LE(now, last);
            last = now;
            ASSERT_LE(worst_link(tissue, c.law), 0);
            for (const auto& [e, u] : start) {
                const Vec3<Fixed> v = lattice.displacement_at(e);
                const ElementLimits limits = c.law(lattice.value_at(e));
                const bool stays = limits.fixed || u == Vec3<Fixed>{0, 0, 0} ||
                                   std::find(c.held.begin(), c.held.end(), e) != c.held.end();
                // An imprint can pull an element away from its first rest position.
                if (stays && tissue.imprint_mm(e) == Vec3d{0, 0, 0}) {
                    ASSERT_EQ(v, u);
                }
                ASSERT_LE(norm({mm_from_units(v.x), mm_from_units(v.y), mm_from_units(v.z)}),
                          limits.max_movement_mm);
                for (std::size_t n = 0; n < c.tools.size(); ++n) {
                    const double now_mm = distance_to_tool(lattice.grid(), lattice, e, c.tools[n]);
                    const double must = std::min(distances[e][n], c.tools[n].radius_mm);
                    ASSERT_GE(now_mm, must - 1e-9);
                    distances[e][n] = std::max(distances[e][n], now_mm);
                }
            }
        }
    }
}

TEST(Relax, EnergyIsTheSumOverLinksOfWeightTimesSquare) {
    Random random(5);
    const Instance instance = random_instance(random, 9, 9, false);
    const TaskArena arena(2);
    ChainMail tissue = tissue_of(instance.volume, instance.law, arena);
    ASSERT_TRUE(tissue.push_elements({{{4, 4, 4}}}, {1.2, -0.7, 0.4}).ok());
    const Vec3d h = instance.volume.grid.spacing_mm;
    const double least = std::min({h.x, h.y, h.z});
    const auto weight = [&](Vec3i e, int b) {
        const ElementLimits l = instance.law(lattice_of(tissue).value_at(e));
        // From the limits in whole units, as stored in the links.
        const auto units = [&](double f) { return std::floor(h[b] * f / 2 * (1 << 20)); };
        const double fraction =
            (units(l.compress[b]) + units(l.stretch[b]) + 4 * units(l.shear[b])) / 6 * 2 /
            (1 << 20) / h[b];
        return std::round(std::clamp(64 * least * least / (h[b] * h[b]) / fraction, 1.0, 32767.0));
    };
    double sum = 0;
    for (int z = -15; z < 25; ++z)
        for (int y = -15; y < 25; ++y)
            for (int x = -15; x < 25; ++x)
                for (int b = 0; b < 3; ++b) {
                    const Vec3i e{x, y, z}, f = beside(e, 2 * b + 1);
                    const Vec3<Fixed> d = lattice_of(tissue).displacement_at(f) -
                                          lattice_of(tissue).displacement_at(e);
                    const Vec3d mm{mm_from_units(d.x), mm_from_units(d.y), mm_from_units(d.z)};
                    sum += (weight(e, b) + weight(f, b)) * dot(mm, mm);
                }
    EXPECT_GT(sum, 1);
    EXPECT_NEAR(tissue.elastic_energy_mm2() / sum, 1, 1e-9);
}

TEST(Relax, EnergyKnowsWhatChangedSinceItWasAskedLast) {
    const std::uint64_t seed = 8;
    SCOPED_TRACE(seed);
    Random random(seed);
    const Instance instance = random_instance(random, 30, 30, true);
    const TaskArena arena(2);
    ChainMail tissue = tissue_of(instance.volume, instance.law, arena);
    const auto fresh = [&] {
        return mm2_from_energy(elastic_energy(lattice_of(tissue), PlasticRest{}, arena));
    };
    const auto somewhere = [&] {
        return Vec3i{random.whole(2, 27), random.whole(2, 27), random.whole(2, 27)};
    };
    for (int turn = 0; turn < 120; ++turn) {
        const int choice = random.whole(0, 9);
        if (choice < 5) {
            ASSERT_TRUE(tissue.push_elements({{somewhere()}}, random.vector(4)).ok());
        } else if (choice < 7) {
            ASSERT_TRUE(tissue.relax({.max_sweeps = random.whole(1, 4)}).ok());
        } else if (choice < 8) {
            if (tissue.undo_steps() > 0) {
                ASSERT_TRUE(tissue.undo().ok());
            }
        } else if (choice < 9) {
            const Vec3i e = somewhere();
            const Vec3d from =
                world_from_voxel(instance.volume.grid, {double(e.x), double(e.y), double(e.z)});
            ASSERT_TRUE(tissue.carve({.from_mm = from, .to_mm = from, .radius_mm = 2}).ok());
        } else if (turn % 3 == 0) {
            tissue.reset();
        }
        ASSERT_EQ(tissue.elastic_energy_mm2(), fresh()) << "turn " << turn;
    }
}

TEST(Relax, ReleasedTissueReturnsToRestExactly) {
    const TaskArena arena(2);
    for (const bool plain : {false, true}) {
        const Volume volume = block({24, 24, 24}, 0, {1, 1, 1.7});
        ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
        ASSERT_TRUE(tissue.push({.point_mm = {12, 12, 20}, .push_mm = {1, -0.8, 0.5}}).ok());
        double last = tissue.elastic_energy_mm2();
        RelaxReport report;
        int sweeps = 0;
        while (!report.settled && sweeps < 5000) {
            report = relaxed(tissue, {.max_sweeps = 10, .over_relaxation = plain ? 1 : 1.9});
            sweeps += report.sweeps;
            const double now = tissue.elastic_energy_mm2();
            ASSERT_LE(now, last);
            last = now;
        }
        EXPECT_TRUE(report.settled);
        EXPECT_EQ(tissue.state().resident_bricks, 0);
        EXPECT_EQ(last, 0);
        RecordProperty(plain ? "plain_sweeps" : "sweeps", sweeps);
    }
}

TEST(Relax, MixedMaterialReturnsToRestToo) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Instance instance = random_instance(random, 8, 14, true);
        const TaskArena arena(1);
        ChainMail tissue = tissue_of(instance.volume, instance.law, arena);
        ASSERT_TRUE(
            tissue.push_elements(random_grab(random, instance.volume.grid), {.5, .4, 0}).ok());
        EXPECT_TRUE(relaxed(tissue, {.max_sweeps = 20000}).settled);
        EXPECT_EQ(tissue.moved_box(), Box3i{});
    }
}

TEST(Relax, WithAHeldPatchItReachesTheDiscreteHarmonicState) {
    const TaskArena arena(2);
    Volume volume = block({14, 14, 14}, 0, {1, 1.3, 0.8});
    auto& voxels = std::get<VoxelArray<std::int16_t>>(volume.voxels);
    for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = std::int16_t(n / 5 % 2);
    // Limits above the push: no link binds in any state.
    const MaterialLaw law = [](int value) {
        const double limit = value == 1 ? 0.9 : 0.5;
        return one_material(limit)(0);
    };
    ChainMail tissue = tissue_of(volume, law, arena);
    std::vector<Vec3i> pushed;
    for (int z = 2; z < 12; ++z)
        for (int y = 2; y < 12; ++y)
            for (int x = 2; x < 12; ++x) pushed.push_back({x, y, z});
    const std::vector<Vec3i> held{{6, 6, 6}, {7, 6, 6}, {6, 7, 6}, {7, 7, 8}};
    ASSERT_TRUE(tissue.push_elements(pushed, {0.25, 0, -0.17}).ok());
    EXPECT_TRUE(relaxed(tissue, {.max_sweeps = 5000, .held = held}).settled);
    // The same by a plain Gauss-Seidel in doubles, with an error bound for a residual of half a
    // unit at every element: the solution for a load of half a unit.
    const auto weight = [&](Vec3i e, Vec3i f, int b) {
        const double h = volume.grid.spacing_mm[b];
        const auto end = [&](Vec3i p) {
            const double limit = lattice_of(tissue).value_at(p) == 1 ? 0.9 : 0.5;
            return std::round(64 * 0.8 * 0.8 / (h * h) / limit);
        };
        return end(e) + end(f);
    };
    std::map<Vec3i, std::pair<double, double>, Before> harmonic;  // for a push by 1; bound [units]
    for (const Vec3i& e : pushed) harmonic[e] = {1, 0};
    for (int sweep = 0; sweep < 400; ++sweep)
        for (auto& [e, solution] : harmonic) {
            if (std::find(held.begin(), held.end(), e) != held.end()) continue;
            double sum = 0, part = 0, bound = 0;
            for (int side = 0; side < 6; ++side) {
                const auto found = harmonic.find(beside(e, side));
                const double w = weight(e, beside(e, side), side / 2);
                sum += w;
                if (found == harmonic.end()) continue;
                part += w * found->second.first;
                bound += w * found->second.second;
            }
            solution = {part / sum, bound / sum + 0.5};
        }
    double worst_units = 0;
    for (const auto& [e, solution] : harmonic) {
        const Vec3<Fixed> v = lattice_of(tissue).displacement_at(e);
        for (const auto& [a, push_mm] : {std::pair{0, 0.25}, std::pair{2, -0.17}}) {
            const double apart = std::abs(v[a] - solution.first * push_mm * kUnitsPerMm);
            ASSERT_LE(apart, solution.second + 0.6);
            worst_units = std::max(worst_units, apart);
        }
    }
    EXPECT_LT(worst_units, 5);  // nanometres
    RecordProperty("worst_units", std::to_string(worst_units));
}

std::uint64_t hash_after(const Case& c, int threads, int brick_size, int slice_sweeps, int sweeps) {
    const TaskArena arena(threads);
    ChainMail tissue = tissue_of(c.instance.volume, c.law, arena, brick_size);
    EXPECT_TRUE(tissue.push_elements(c.held, {0.9, -0.6, 0.7}).ok());
    for (int done = 0; done < sweeps; done += slice_sweeps)
        relaxed(tissue, {.max_sweeps = slice_sweeps, .tools = c.tools, .held = c.held});
    return tissue.hash();
}

TEST(Relax, ThreadsBrickSizeAndSlicesDoNotChangeTheResult) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        Case c = random_case(random);
        c.held = random_grab(random, c.instance.volume.grid);
        c.tools.push_back(random_tool(random, c.instance.volume.grid));
        const std::uint64_t expected = hash_after(c, 1, 8, 24, 24);
        EXPECT_NE(expected, hash_after(c, 1, 8, 1, 1));
        EXPECT_EQ(hash_after(c, 2, 8, 24, 24), expected);
        EXPECT_EQ(hash_after(c, 4, 8, 24, 24), expected);
        EXPECT_EQ(hash_after(c, 2, 3, 24, 24), expected);
        EXPECT_EQ(hash_after(c, 1, 16, 24, 24), expected);
        EXPECT_EQ(hash_after(c, 1, 13, 24, 24), expected);
        EXPECT_EQ(hash_after(c, 2, 8, 1, 24), expected);
        EXPECT_EQ(hash_after(c, 2, 5, 3, 24), expected);
    }
}

TEST(Relax, ShortSlicesOfTimeArriveWhereOneLongOneDoes) {
    const TaskArena arena(2);
    const Volume volume = block({40, 40, 40}, 0);
    const std::vector<Vec3i> held{{20, 20, 20}};
    const auto run = [&](double budget_ms) {
        ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
        EXPECT_TRUE(tissue.push_elements(held, {2, 1, 0}).ok());
        int slices = 1;
        while (!relaxed(tissue, {.budget_ms = budget_ms, .held = held}).settled) ++slices;
        EXPECT_EQ(slices > 1, std::isfinite(budget_ms));
        return tissue.hash();
    };
    EXPECT_EQ(run(0.05), run(std::numeric_limits<double>::infinity()));
}

TEST(Relax, SlicesOfSomeBricksWithPushesBetweenThemDoNotDependOnThreads) {
    const Volume volume = block({44, 40, 36}, 0);
    const std::vector<Vec3i> held{{20, 20, 20}};
    const auto run = [&](int threads, std::span<const std::int64_t> bricks) {
        const TaskArena arena(threads);
        ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
        std::vector<std::int64_t> relaxed_bricks;
        for (const std::int64_t count : bricks) {
            EXPECT_TRUE(tissue.push_elements(held, {0.5, 0.25, 0}).ok());
            const RelaxReport report =
                relaxed(tissue, {.max_sweeps = 1, .max_bricks = count, .held = held});
            EXPECT_TRUE(report.bricks == count || (report.bricks < count && report.sweeps == 1));
            relaxed_bricks.push_back(report.bricks);
        }
        return std::pair(tissue.hash(), relaxed_bricks);
    };
    const std::vector<std::int64_t> some{3, 1, 0, 17, 40, 2, 1000, 5, 61, 23, 9};
    const auto expected = run(1, some);
    EXPECT_LT(expected.second[6], 1000);
    for (const int threads : {2, 3, 4}) EXPECT_EQ(run(threads, some), expected) << threads;
    // The report's numbers end slices at the same bricks.
    EXPECT_EQ(run(2, expected.second), expected);
}

TEST(Relax, ManySlicesOfSomeBricksAreOneLongOne) {
    const TaskArena arena(2);
    const Volume volume = block({40, 40, 40}, 0);
    const std::vector<Vec3i> held{{20, 20, 20}};
    const auto run = [&](std::int64_t bricks) {
        ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
        EXPECT_TRUE(tissue.push_elements(held, {2, 1, 0}).ok());
        int slices = 1;
        while (!relaxed(tissue, {.max_bricks = bricks, .held = held}).settled) ++slices;
        EXPECT_EQ(slices > 1, bricks < 1'000'000);
        return tissue.hash();
    };
    EXPECT_EQ(run(7), run(std::numeric_limits<std::int64_t>::max()));
}

TEST(Relax, NoTimeMeansNoChange) {
    const TaskArena arena(1);
    const Volume volume = block({16, 16, 16}, 0);
    ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
    ASSERT_TRUE(tissue.push({.point_mm = {8, 8, 8}, .push_mm = {1, 0, 0}}).ok());
    const std::uint64_t hash = tissue.hash();
    const RelaxReport report = relaxed(tissue, {.budget_ms = 0, .measure_energy = true});
    EXPECT_EQ(report.sweeps, 0);
    EXPECT_FALSE(report.settled);
    EXPECT_GT(report.energy_before_mm2, 0);
    EXPECT_EQ(report.energy_before_mm2, report.energy_after_mm2);
    EXPECT_EQ(tissue.hash(), hash);
}

TEST(Relax, AnotherThreadCanStopASlice) {
    const TaskArena arena(2);
    const Volume volume = block({48, 48, 48}, 0);
    const MaterialLaw law = one_material(0.2);
    ChainMail tissue = tissue_of(volume, law, arena);
    const std::vector<Vec3i> held{{24, 24, 24}};
    ASSERT_TRUE(tissue.push_elements(held, {3, 2, 0}).ok());
    std::stop_source source;
    // Slices between frames, until a push comes.
    std::jthread other([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        source.request_stop();
    });
    int slices = 0;
    for (; !source.stop_requested() && slices < 100000; ++slices)
        relaxed(tissue, {.budget_ms = 1, .stop = source.get_token(), .held = held});
    EXPECT_TRUE(source.stop_requested());
    const std::uint64_t hash = tissue.hash();
    EXPECT_EQ(relaxed(tissue, {.stop = source.get_token(), .held = held}).sweeps, 0);
    EXPECT_EQ(tissue.hash(), hash);
    EXPECT_LE(worst_link(tissue, law), 0);
}

TEST(Relax, LinksOutsideOfTheirLimitsDoNotGetWorse) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1);
        const Volume volume = block({12, 12, 12}, 0);
        ChainMail tissue = tissue_of(volume, one_material(0.1), arena, 4);
        ASSERT_TRUE(tissue.push_elements({{{6, 6, 6}}}, {0.5, 0, 0}).ok());
        auto& lattice = lattice_of(tissue);
        lattice.set_may_exceed_limits(true);
        for (const int index : lattice.resident_bricks()) {
            for (Fixed* u : lattice.brick(index).u)
                for (int n = 0; n < lattice.elements_per_brick(); ++n)
                    u[n] = units_from_mm(random.real(-0.2, 0.2));
            lattice.update_bounds(index);
        }
        lattice.tick();
        const auto excess = [&] {
            std::vector<std::int64_t> all;
            for (int z = -3; z < 15; ++z)
                for (int y = -3; y < 15; ++y)
                    for (int x = -3; x < 15; ++x)
                        for (int b = 0; b < 3; ++b) {
                            const Vec3i e{x, y, z};
                            const Vec3<Fixed> d = lattice.displacement_at(beside(e, 2 * b + 1)) -
                                                  lattice.displacement_at(e);
                            for (int a = 0; a < 3; ++a) all.push_back(d[a]);
                        }
            return all;
        };
        const std::int64_t limit = 2 * units_from_mm(0.05);
        std::vector<std::int64_t> last = excess();
        double energy = tissue.elastic_energy_mm2();
        for (int sweep = 0; sweep < 10; ++sweep) {
            relaxed(tissue, {.max_sweeps = 1});
            const auto now = excess();
            for (std::size_t n = 0; n < now.size(); ++n) {
                ASSERT_LE(now[n], std::max(limit, last[n]));
                ASSERT_GE(now[n], std::min(-limit, last[n]));
            }
            ASSERT_LE(tissue.elastic_energy_mm2(), energy);
            energy = tissue.elastic_energy_mm2();
            last = now;
        }
    }
}

TEST(Relax, OptionsThatMakeNoSenseAreNamed) {
    const TaskArena arena(1);
    const Volume volume = block({8, 8, 8}, 0);
    ChainMail tissue = tissue_of(volume, one_material(0.2), arena);
    const auto message = [&](const RelaxOptions& options) {
        const auto report = tissue.relax(options);
        return report.ok() ? std::string() : report.error().message;
    };
    EXPECT_EQ(message({.budget_ms = -1}), "relax: budget_ms: expected 0 or more, found -1");
    EXPECT_EQ(message({.max_sweeps = -2}), "relax: max_sweeps: expected 0 or more, found -2");
    EXPECT_EQ(message({.over_relaxation = 2}),
              "relax: over_relaxation: expected 1 to 1.95, found 2");
    EXPECT_EQ(message({.tools = {{{0, 0, 0}, {0, 0, 0}, 0}}}),
              "relax: tools: radius_mm: expected more than 0, up to 100000, found 0");
    EXPECT_EQ(message({.tools = {{{0, 0, 0}, {0, 0, 0}, 100001}}}),
              "relax: tools: radius_mm: expected more than 0, up to 100000, found 100001");
    EXPECT_EQ(message({.budget_ms = 0, .tools = {{{0, 0, 0}, {0, 0, 0}, 100000}}}), "");
    EXPECT_EQ(message({.tools = {{{0, 0, 0}, {NAN, 0, 0}, 1}}}),
              "relax: tools: expected positions up to 100000 mm from the origin, found nan");
    EXPECT_EQ(message({}), "");
}

}  // namespace
}  // namespace pliant::test
