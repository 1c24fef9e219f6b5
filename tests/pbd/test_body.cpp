// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whole bodies: the order of projection, the same bits for all, memory, and bad input.
// Covers: pbd/packer.cpp, pbd/plan.cpp, pbd/check_parts.cpp.

#include <pliant/models/pbd.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <string>

#include "pbd/plan.h"
#include "support/count_allocations.h"
#include "support/made.h"
#include "support/one_thread.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// A block with everything that can be in it, its nodes shaken and numbered at random.
PbdParts random_block(Random& random, Vec3i cells, bool solids) {
    TetMesh mesh = five_tet_block(cells, 1);
    for (Vec3d& p : mesh.nodes_mm) p = p + random.vector(0.1);
    std::vector<std::int32_t> number(mesh.nodes_mm.size());
    for (std::size_t n = 0; n < number.size(); ++n) {
        number[n] = std::int32_t(n);
        std::swap(number[n], number[std::size_t(random.whole(0, int(n)))]);
    }
    TetMesh shuffled = mesh;
    for (std::size_t n = 0; n < number.size(); ++n)
        shuffled.nodes_mm[std::size_t(number[n])] = mesh.nodes_mm[n];
    for (auto& cell : shuffled.cells)
        for (auto& node : cell) node = number[std::size_t(node)];
    auto parts = pbd_of_mesh(shuffled, {.edge_compliance = 1e-4,
                                        .volume_compliance = 1e-4,
                                        .bend_compliance = 1e-3,
                                        .bends = true,
                                        .solids = solids,
                                        .young_modulus = 1e3});
    PbdParts all = std::move(parts).value();
    for (int n = 0; n < 5; ++n)
        all.inverse_masses[std::size_t(random.whole(0, int(number.size()) - 1))] = 0;
    all.attachments = {{{0, 1, 2, 3}, {0.25, 0.25, 0.25, 0.25}, {1, 2, 0.5}, 1e-3}};
    all.planes = {{{0, 0, -0.5}, {0, 0, 1}, 0.4}};
    return all;
}

TEST(Plan, EachConstraintComesOnceAndNoPackPairOrPhaseMeetsAParticleTwice) {
    int pairs = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        PbdParts parts = random_block(
            random, {random.whole(1, 12), random.whole(1, 9), random.whole(1, 5)}, true);
        // And a few between distant particles.
        const int last = int(parts.positions.size()) - 1;
        for (int n = 0; n < 20; ++n) {
            const int a = random.whole(0, last), b = random.whole(0, last);
            if (a != b) parts.distances.push_back({.nodes = {a, b}});
        }
        const pbd::Plan plan = pbd::make_plan(parts, random.whole(1, 300));
        std::multiset<std::int32_t> numbers(plan.particle_of.begin(), plan.particle_of.end());
        EXPECT_EQ(numbers.size(), parts.positions.size());
        EXPECT_EQ(*numbers.rbegin(), last);
        std::vector<int> seen[pbd::kKinds];
        for (int kind = 0; kind < pbd::kKinds; ++kind)
            seen[kind].assign(pbd::constraint_count(parts, kind), 0);
        for (const pbd::Phase& phase : plan.phases) {
            std::vector<std::int32_t> domain_of(std::size_t(plan.particle_count), -1);
            for (std::int32_t d = phase.begin; d < phase.end; ++d)
                for (int kind = 0; kind < pbd::kKinds; ++kind) {
                    const pbd::PackRange range = plan.domains[std::size_t(d)].packs[kind];
                    const pbd::KindPlan& packs = plan.kinds[kind];
                    const auto corners = std::size_t(pbd::kCorners[kind]);
                    EXPECT_LE(range.paired_end, range.end);
                    EXPECT_EQ((range.paired_end - range.begin) % 2, 0);
                    pairs += range.paired_end - range.begin;
                    std::set<std::uint32_t> in_last;
                    for (auto pack = std::size_t(range.begin); pack < std::size_t(range.end);
                         ++pack) {
                        std::set<std::uint32_t> in_pack;
                        for (std::size_t lane = 0; lane < pbd::kPack; ++lane) {
                            const std::int32_t c = packs.constraints[pack * pbd::kPack + lane];
                            if (c >= 0) ++seen[kind][std::size_t(c)];
                            for (std::size_t n = 0; n < corners; ++n) {
                                const std::uint32_t particle =
                                    packs.corners[(pack * corners + n) * pbd::kPack + lane] / 4;
                                ASSERT_LT(particle, std::uint32_t(plan.particle_count));
                                std::int32_t& owner = domain_of[particle];
                                EXPECT_TRUE(owner < 0 || owner == d);
                                owner = d;
                                if (c < 0) continue;
                                EXPECT_TRUE(in_pack.insert(particle).second);
                                EXPECT_EQ(plan.particle_of[std::size_t(
                                              pbd::nodes_of(parts, kind, std::size_t(c))[n])],
                                          std::int32_t(particle));
                            }
                        }
                        // The second of a pair has no particle of the first.
                        const auto turn = pack - std::size_t(range.begin);
                        const bool second = turn % 2 == 1 && pack < std::size_t(range.paired_end);
                        for (const std::uint32_t particle : in_pack)
                            EXPECT_EQ(second ? in_last.count(particle) : 0, 0U);
                        in_last = in_pack;
                    }
                }
        }
        for (int kind = 0; kind < pbd::kKinds; ++kind)
            for (const int times : seen[kind]) EXPECT_EQ(times, 1);
    }
    EXPECT_GT(pairs, 100);
}

class Methods : public ::testing::TestWithParam<PbdMethod> {};

TEST_P(Methods, VectorsAndThreadsDontChangeABit) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        // The last one is so large that threads share its particles too.
        const Vec3i cells = seed < 6 ? Vec3i{9, 6, 4} : Vec3i{22, 18, 13};
        const PbdParts parts = random_block(random, cells, GetParam() == PbdMethod::Compliance);
        std::uint64_t expected = 0;
        for (const bool vectors : {true, false})
            for (const int threads : {1, 2, 4}) {
                const TaskArena arena(threads);
                auto body = PbdBody::create(parts, {.time_step = 0.02,
                                                    .sub_steps = 3,
                                                    .iterations = 2,
                                                    .gravity = {1, 2, -9.81},
                                                    .damping = 1,
                                                    .method = GetParam(),
                                                    .vectors = vectors,
                                                    .domain_particles = 40,
                                                    .warm_starts = seed % 2 == 0});
                ASSERT_TRUE(body.ok()) << body.error().message;
                const std::uint64_t before = body->hash();
                ASSERT_TRUE(body->step(4, arena).ok());
                EXPECT_NE(body->hash(), before);
                if (expected == 0) expected = body->hash();
                EXPECT_EQ(body->hash(), expected) << vectors << ' ' << threads;
            }
    }
}
INSTANTIATE_TEST_SUITE_P(All, Methods,
                         ::testing::Values(PbdMethod::Compliance, PbdMethod::Stiffness));

TEST(Body, FloatsAreDoublesToFourDigits) {
    Random random(3);
    const PbdParts parts = random_block(random, {6, 4, 3}, false);
    std::vector<Vec3d> positions[2];
    for (const bool wide : {false, true}) {
        auto body = PbdBody::create(
            parts, {.sub_steps = 4,
                    .gravity = {0, 0, -9.81},
                    .precision = wide ? PbdPrecision::Double : PbdPrecision::Float});
        ASSERT_TRUE(body->step(6, one_thread()).ok());
        positions[wide].resize(parts.positions.size());
        body->get_positions(positions[wide]);
    }
    double farthest = 0, moved = 0;
    for (std::size_t n = 0; n < parts.positions.size(); ++n) {
        farthest = std::max(farthest, norm(positions[0][n] - positions[1][n]));
        moved = std::max(moved, norm(positions[1][n] - parts.positions[n]));
    }
    EXPECT_GT(moved, 0.05);
    EXPECT_LT(farthest, 1e-4 * moved);
}

TEST(Body, NothingIsAllocatedInAStepAfterTheFirst) {
    Random random(4);
    const PbdParts parts = random_block(random, {12, 10, 8}, true);
    for (const int threads : {1, 2}) {
        const TaskArena arena(threads);
        auto body = PbdBody::create(parts, {.gravity = {0, 0, -9.81}, .domain_particles = 100});
        ASSERT_TRUE(body->step(2, arena).ok());
        const std::int64_t before = allocation_count();
        ASSERT_TRUE(body->step(3, arena).ok());
        ASSERT_TRUE(body->move_attachment(0, {1, 2, 0.75}).ok());
        ASSERT_TRUE(body->step(3, arena).ok());
        EXPECT_EQ(allocation_count() - before, 0);
    }
}

TEST(Body, ConstraintForcesOnAHeldNodeAreTheWeightOfWhatHangsFromIt) {
    PbdParts parts{.positions = {{0, 0, 0}, {0, 0, -1}, {0, 0, -2}}, .inverse_masses = {0, 1, 0.5}};
    parts.distances = {{.nodes = {0, 1}, .compliance = 1e-3},
                       {.nodes = {1, 2}, .compliance = 1e-3}};
    auto body = PbdBody::create(
        parts, {.gravity = {0, 0, -10}, .damping = 10, .precision = PbdPrecision::Double});
    ASSERT_TRUE(body->step(900, one_thread()).ok());
    const auto forces = body->constraint_forces();
    EXPECT_NEAR(forces[0].z, -30, 1e-6);
    EXPECT_NEAR(forces[2].z, 20, 1e-6);
    EXPECT_NEAR(body->multiplier(PbdKind::Distance, 0), -30, 1e-6);
    // One iteration per sub-step: the second link undoes part of the first one's projection, by h²
    // g.
    EXPECT_NEAR(body->position(2).z, -2 - 0.03 - 0.02, 1e-4);
}

/// A block of 40 mm that hangs from its top, at rest under its weight.
struct HangingBlock {
    PbdParts parts;
    std::vector<Vec3d> positions;
    double work = 0;  ///< of gravity for a stretch of 1 mm [g mm/s²]

    /// The law's energy [g mm²/s²] with the block stretched: Ψ = ½µ(tr FᵀF − 3) +
    /// ½(λ + µ)(J − 1 − µ/(λ + µ))².
    double energy(double stretch_mm) const {
        double sum = 0;
        for (const PbdSolid& solid : parts.solids) {
            const double nu = solid.poisson_ratio, mu = solid.young_modulus / (2 * (1 + nu));
            const double sum_of_lame = 2 * mu * nu / (1 - 2 * nu) + mu;
            const auto edges = [&](const std::vector<Vec3d>& x, double by) {
                std::array<Vec3d, 4> at;
                for (std::size_t k = 0; k < 4; ++k) {
                    const auto n = std::size_t(solid.nodes[k]);
                    at[k] = x[n] - by * share_of(n) * Vec3d{0, 0, 1};
                }
                return Mat3d{{at[1] - at[0], at[2] - at[0], at[3] - at[0]}};
            };
            const Mat3d rest = edges(parts.positions, 0);
            const Mat3d f = edges(positions, stretch_mm) * inverse(rest);
            const auto volume = [](const Mat3d& m) {
                return dot(cross(m.columns[0], m.columns[1]), m.columns[2]);
            };
            double trace = 0;
            for (const Vec3d& c : f.columns) trace += dot(c, c);
            const double j = volume(f) - 1 - mu / sum_of_lame;
            sum += volume(rest) / 6 * (0.5 * mu * (trace - 3) + 0.5 * sum_of_lame * j * j);
        }
        return sum;
    }
    /// 0 at the top, which is held, 1 at the foot.
    double share_of(std::size_t node) const { return 1 - parts.positions[node].z / 40; }
    /// What a stretch stores over what gravity gives: 1 in equilibrium, whatever the elements.
    double balance() const {
        constexpr double kBy_mm = 1e-4;
        return (energy(kBy_mm) - energy(-kBy_mm)) / (2 * kBy_mm) / work;
    }
};

/// @param sub_steps  0: as many as warm starts need
HangingBlock hanging_block(int cells, double young_pa, std::int32_t sub_steps, bool warm) {
    HangingBlock block;
    const TetMesh mesh = five_tet_block({cells, cells, cells}, 40.0 / cells);
    block.parts = std::move(pbd_of_mesh(mesh, {.density = 1e-3,
                                               .edges = false,
                                               .volumes = false,
                                               .solids = true,
                                               .young_modulus = young_pa,
                                               .poisson_ratio = 0.45}))
                      .value();
    constexpr double kStep_s = 1.0 / 60, kGravity = 9810;
    for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n) {
        double& w = block.parts.inverse_masses[n];
        if (mesh.nodes_mm[n].z > 39.9)
            w = 0;
        else
            block.work += kGravity / w * block.share_of(n);
    }
    if (sub_steps == 0) sub_steps = std::int32_t(std::ceil(wave_sub_steps(block.parts, kStep_s)));
    auto body = PbdBody::create(block.parts, {.time_step = kStep_s,
                                              .sub_steps = sub_steps,
                                              .gravity = {0, 0, -kGravity},
                                              .damping = 5,
                                              .warm_starts = warm});
    EXPECT_TRUE(body.ok());
    EXPECT_TRUE(body->step(120, one_thread()).ok());
    block.positions.resize(mesh.nodes_mm.size());
    body->get_positions(block.positions);
    return block;
}

TEST(Body, AtRestTheForcesOfTheLawBalanceTheLoad) {
    for (const auto& [cells, young_pa] : {std::pair(5, 3e3), {5, 15e3}, {8, 15e3}})
        EXPECT_NEAR(hanging_block(cells, young_pa, 0, true).balance(), 1, 0.05)
            << cells << ' ' << young_pa;
    // Without, they exceed it by what a sub-step doesn't find; with fewer sub-steps than a wave
    // needs, nothing shakes.
    EXPECT_GT(hanging_block(8, 15e3, 10, false).balance(), 1.5);
    const double few = hanging_block(8, 15e3, 10, true).balance();
    EXPECT_GT(few, 1);
    EXPECT_LT(few, hanging_block(8, 15e3, 10, false).balance());
}

// Loads of particles that are their weights act as gravity does, also where sub-steps begin with
// the last forces.
TEST(Body, LoadsActAsGravity) {
    const TaskArena arena(1);
    for (const PbdPrecision precision : {PbdPrecision::Float, PbdPrecision::Double})
        for (const bool warm : {false, true}) {
            PbdParts parts =
                made(pbd_of_mesh(five_tet_block({2, 2, 4}, 5), {.density = 1e-3,
                                                                .edges = false,
                                                                .volumes = false,
                                                                .solids = true,
                                                                .young_modulus = 1e4}));
            std::vector<std::int32_t> particles;
            std::vector<Vec3d> forces;
            for (std::size_t n = 0; n < parts.positions.size(); ++n) {
                double& w = parts.inverse_masses[n];
                if (parts.positions[n].z == 0) {
                    w = 0;
                    continue;
                }
                particles.push_back(std::int32_t(n));
                forces.push_back({9810 / w, 0, 0});
            }
            const auto body_in = [&](Vec3d gravity) {
                return made(PbdBody::create(parts, {.time_step = 1.0 / 60,
                                                    .sub_steps = 30,
                                                    .gravity = gravity,
                                                    .damping = 20,
                                                    .precision = precision,
                                                    .warm_starts = warm}));
            };
            PbdBody heavy = body_in({9810, 0, 0}), loaded = body_in({0, 0, 0});
            ASSERT_TRUE(loaded.load(particles, forces).ok());
            for (PbdBody* body : {&heavy, &loaded}) ASSERT_TRUE(body->step(60, arena).ok());
            for (const std::int32_t n : particles)
                EXPECT_LT(norm(heavy.position(n) - loaded.position(n)), 1e-3) << n;
            EXPECT_GT(heavy.position(particles.back()).x - 10, 0.5);
        }
}

// The top of a block is put back after each sub-step, as contact does it. The next sub-step is then
// that of a body which remembers its forces, or of one that has found them by trials.
TEST(Body, TrialsFindTheForcesOfTheLastSubStep) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Vec3d shift = random.vector(0.5) + Vec3d{0, 0, -2};
        const double young_pa = random.ratio(3e3, 30e3);
        constexpr int kRemembers = -1;
        const auto after = [&](int trials, int threads) {
            const TaskArena arena(threads);
            const TetMesh mesh = five_tet_block({4, 4, 4}, 2);
            PbdParts parts = std::move(pbd_of_mesh(mesh, {.density = 1e-3,
                                                          .edges = false,
                                                          .volumes = false,
                                                          .solids = true,
                                                          .young_modulus = young_pa}))
                                 .value();
            std::vector<std::int32_t> top;
            for (std::size_t n = 0; n < mesh.nodes_mm.size(); ++n)
                if (mesh.nodes_mm[n].z == 0)
                    parts.inverse_masses[n] = 0;
                else if (mesh.nodes_mm[n].z == 8)
                    top.push_back(std::int32_t(n));
            const double step_s = 1.0 / 60 / std::ceil(wave_sub_steps(parts, 1.0 / 60));
            PbdBody body = made(PbdBody::create(
                parts, {.time_step = step_s, .sub_steps = 1, .damping = 20, .warm_starts = true}));
            const auto put_back = [&] {
                for (const std::int32_t n : top)
                    EXPECT_TRUE(
                        body.set_state(n, mesh.nodes_mm[std::size_t(n)] + shift, {0, 0, 0}).ok());
            };
            put_back();
            for (int n = 0; n < 2000; ++n) {
                EXPECT_TRUE(body.step(1, arena).ok());
                put_back();
            }
            if (trials != kRemembers) body.recall_forces(trials);
            EXPECT_TRUE(body.step(1, arena).ok());
            std::vector<Vec3d> positions(mesh.nodes_mm.size());
            body.get_positions(positions);
            return positions;
        };
        const auto remembered = after(kRemembers, 1);
        const auto error = [&](int trials) {
            const auto x = after(trials, 1);
            double sum = 0;
            for (std::size_t n = 0; n < x.size(); ++n)
                sum += dot(x[n] - remembered[n], x[n] - remembered[n]);
            return std::sqrt(sum);
        };
        const double none = error(0), some = error(8);
        std::printf("seed %d: E %.0f Pa, error %.5f mm without trials, %.5f mm with 8\n", int(seed),
                    young_pa, none, some);
        EXPECT_GT(none, 0.02);
        EXPECT_LT(some, 0.05 * none);
        EXPECT_EQ(after(8, 1), after(8, 2));
    }
}

TEST(Body, WhatIsNoNumberAnyMoreIsRefusedAndTakenBack) {
    PbdParts parts{.positions = {{0, 0, 0}, {1, 0, 0}}, .inverse_masses = {1, 1}};
    parts.distances = {{.nodes = {0, 1}}};
    auto body = PbdBody::create(parts, {.gravity = {1e30, 0, 0}});
    ASSERT_TRUE(body.ok());
    Status status = Ok{};
    int steps = 0;
    std::uint64_t before = 0;
    for (; status.ok() && steps < 100000000; ++steps) {
        before = body->hash();
        if (steps == 3) {
            ASSERT_TRUE(body->set_state(0, {3e38, 0, 0}, {3e38, 0, 0}).ok());
            before = body->hash();
        }
        status = body->step(1, one_thread());
    }
    EXPECT_EQ(steps, 4);
    EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(body->hash(), before);
}

PbdParts good_parts() {
    return *pbd_of_mesh(five_tet_block({1, 1, 1}, 1), {.bends = true, .solids = true});
}

TEST(Body, BadInputIsRefusedWithOneLineThatNamesIt) {
    const double nan = std::nan(""), infinite = HUGE_VAL;
    struct Case {
        const char* says;
        std::function<void(PbdParts&, PbdSettings&)> spoil;
    };
    const Case cases[] = {
        {"solid 2: expected a volume above 0, found -",
         [](PbdParts& p, PbdSettings&) { std::swap(p.solids[2].nodes[1], p.solids[2].nodes[2]); }},
        {"volume 1: expected a volume above 0, found -",
         [](PbdParts& p, PbdSettings&) {
             std::swap(p.volumes[1].nodes[1], p.volumes[1].nodes[2]);
         }},
        {"particle 3: expected an inverse mass of 0 or more, found inf: a mass of 0",
         [&](PbdParts& p, PbdSettings&) { p.inverse_masses[3] = infinite; }},
        {"particle 3: expected an inverse mass of 0 or more, found -1",
         [](PbdParts& p, PbdSettings&) { p.inverse_masses[3] = -1; }},
        {"distance 4: expected nodes below 8, found 8",
         [](PbdParts& p, PbdSettings&) { p.distances[4].nodes[1] = 8; }},
        {"distance 4: expected different nodes, found ",
         [](PbdParts& p, PbdSettings&) { p.distances[4].nodes[1] = p.distances[4].nodes[0]; }},
        {"bend 0: expected a compliance of 0 or more, found -2",
         [](PbdParts& p, PbdSettings&) { p.bends[0].compliance = -2; }},
        {"volume 0: expected a compliance of 0 or more, found nan",
         [&](PbdParts& p, PbdSettings&) { p.volumes[0].compliance = nan; }},
        {"distance 0: expected a stiffness of 0 to 1, found 1.5",
         [](PbdParts& p, PbdSettings&) { p.distances[0].stiffness = 1.5; }},
        {"position 5: expected three numbers",
         [&](PbdParts& p, PbdSettings&) { p.positions[5].y = nan; }},
        {"inverse_masses: expected one for each of 8 positions, found 7",
         [](PbdParts& p, PbdSettings&) { p.inverse_masses.pop_back(); }},
        {"solid 0: expected a Poisson's ratio above 0 and below 0.5, found 0.5",
         [](PbdParts& p, PbdSettings&) { p.solids[0].poisson_ratio = 0.5; }},
        {"solid 0: expected a Young's modulus above 0, found 0",
         [](PbdParts& p, PbdSettings&) { p.solids[0].young_modulus = 0; }},
        {"solid 0: expected method Compliance",
         [](PbdParts&, PbdSettings& s) { s.method = PbdMethod::Stiffness; }},
        {"attachment 0: expected nodes below 8, found -1",
         [](PbdParts& p, PbdSettings&) {
             p.attachments = {{.nodes = {-1, 0, 0, 0}}};
         }},
        {"plane 0: expected a normal that isn't 0",
         [](PbdParts& p, PbdSettings&) {
             p.planes = {{.normal = {0, 0, 0}}};
         }},
        {"time_step: expected above 0, found 0",
         [](PbdParts&, PbdSettings& s) { s.time_step = 0; }},
        {"sub_steps: expected 1 or more, found 0",
         [](PbdParts&, PbdSettings& s) { s.sub_steps = 0; }},
        {"iterations: expected 1 or more, found -1",
         [](PbdParts&, PbdSettings& s) { s.iterations = -1; }},
        {"gravity: expected one number or three",
         [&](PbdParts&, PbdSettings& s) { s.gravity.x = nan; }},
        {"damping: expected 0 to 600, one over the sub-step, found 601",
         [](PbdParts&, PbdSettings& s) { s.damping = 601; }},
        {"volume_recovery: expected 0 to 20, the damping, found 21",
         [](PbdParts&, PbdSettings& s) {
             s.damping = 20;
             s.volume_recovery = 21;
         }},
    };
    ASSERT_TRUE(PbdBody::create(good_parts(), {}).ok());
    for (const Case& c : cases) {
        PbdParts parts = good_parts();
        PbdSettings settings;
        c.spoil(parts, settings);
        const auto body = PbdBody::create(parts, settings);
        ASSERT_FALSE(body.ok()) << c.says;
        EXPECT_EQ(body.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(body.error().message.rfind(c.says, 0), 0U) << body.error().message;
        EXPECT_EQ(body.error().message.find('\n'), std::string::npos);
    }
    EXPECT_EQ(pbd_of_mesh(five_tet_block({1, 1, 1}, 1), {.density = 0}).error().message,
              "density: expected one above 0, found 0.000000");
    auto body = PbdBody::create(good_parts(), {});
    EXPECT_EQ(body->set_state(8, {0, 0, 0}, {0, 0, 0}).error().message,
              "set_state: expected a particle below 8, found 8");
    EXPECT_FALSE(body->set_state(0, {nan, 0, 0}, {0, 0, 0}).ok());
    EXPECT_FALSE(body->set_inverse_mass(0, -1).ok());
    EXPECT_EQ(body->load(std::array{0, 9}, std::array{Vec3d{}, Vec3d{}}).error().message,
              "load: expected a particle below 8, found 9");
    EXPECT_FALSE(body->load(std::array{0}, std::array{Vec3d{nan, 0, 0}}).ok());
    EXPECT_FALSE(body->load(std::array{0}, {}).ok());
    EXPECT_FALSE(body->move_attachment(0, {0, 0, 0}).ok());
    EXPECT_FALSE(body->step(-1, one_thread()).ok());
}

TEST(Body, AMeshBecomesItsEdgesItsCellsAndTheFoldsOfItsBoundary) {
    const TetMesh mesh = five_tet_block({20, 10, 10}, 0.25);
    const auto parts = pbd_of_mesh(mesh, {.density = 8, .bends = true});
    ASSERT_TRUE(parts.ok());
    EXPECT_EQ(parts->positions.size(), 2541U);  // as in the published block
    EXPECT_EQ(parts->volumes.size(), 10000U);
    EXPECT_EQ(parts->distances.size(), 13540U);
    // Euler: a closed surface of F triangles has 3F/2 edges; F is two for each square of the box.
    EXPECT_EQ(parts->bends.size(), 3U * (2 * (200 + 200 + 100)));
    double mass = 0;
    for (const double w : parts->inverse_masses) mass += 1 / w;
    EXPECT_NEAR(mass, 8 * 5 * 2.5 * 2.5, 1e-9);
    EXPECT_TRUE(check_mesh(mesh).ok());
}

/// Result of one sub-step's projections for a small displacement u of a body at rest.
std::vector<Vec3d> projected(const PbdParts& parts, const PbdSettings& settings,
                             const std::vector<Vec3d>& u) {
    PbdBody body = made(PbdBody::create(parts, settings));
    for (std::size_t n = 0; n < u.size(); ++n)
        EXPECT_TRUE(body.set_state(std::int32_t(n), parts.positions[n] + u[n], {0, 0, 0}).ok());
    EXPECT_TRUE(body.step(1, TaskArena(1)).ok());
    std::vector<Vec3d> after(u.size());
    body.get_positions(after);
    for (std::size_t n = 0; n < u.size(); ++n) after[n] = after[n] - parts.positions[n];
    return after;
}

// With masses M and projections P, uᵀMPv = vᵀMPu: then no step feeds a shake (docs/method/pbd.md).
TEST(PbdBody, ProjectionsToAndFroAreSymmetric) {
    const std::uint64_t seed = 11;
    SCOPED_TRACE(seed);
    Random random(seed);
    PbdParts parts = random_block(random, {5, 4, 3}, false);
    parts.attachments.clear();  // whose targets aren't where it rests
    parts.planes.clear();
    for (const bool alternates : {false, true}) {
        const PbdSettings settings{.time_step = 1e-3,
                                   .sub_steps = 1,
                                   .iterations = 2,
                                   .precision = PbdPrecision::Double,
                                   .domain_particles = 40,
                                   .alternates = alternates};
        double worst = 0;
        for (int pair = 0; pair < 5; ++pair) {
            std::vector<Vec3d> u, v;
            for (std::size_t n = 0; n < parts.positions.size(); ++n) {
                const double most = parts.inverse_masses[n] > 0 ? 1e-6 : 0;
                u.push_back(random.vector(most));
                v.push_back(random.vector(most));
            }
            const auto pu = projected(parts, settings, u), pv = projected(parts, settings, v);
            double one = 0, other = 0, size = 0;
            for (std::size_t n = 0; n < u.size(); ++n) {
                if (!(parts.inverse_masses[n] > 0)) continue;
                const double mass = 1 / parts.inverse_masses[n];
                one += mass * dot(v[n], pu[n]);
                other += mass * dot(u[n], pv[n]);
                size += mass * norm(u[n]) * norm(v[n]);
            }
            worst = std::max(worst, std::abs(one - other) / size);
        }
        std::printf("%s: %.2e\n", alternates ? "to and fro" : "in one order", worst);
        if (alternates) {
            EXPECT_LT(worst, 1e-7);
        } else {
            EXPECT_GT(worst, 1e-6);
        }
    }
    EXPECT_FALSE(PbdBody::create(parts, {.iterations = 3, .alternates = true}).ok());
}

}  // namespace
}  // namespace pliant::test
