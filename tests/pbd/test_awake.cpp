// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Projections while random parts of a body are held, against the constraints one by one.

#include "pbd/awake.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <set>

#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

constexpr int kSolid = int(PbdKind::Solid), kDistance = int(PbdKind::Distance);

PbdParts parts_of(const TetMesh& mesh) {
    return made(pbd_of_mesh(mesh, {.density = 1e-3,
                                   .edges = true,
                                   .volumes = false,
                                   .solids = true,
                                   .young_modulus = 2e4,
                                   .poisson_ratio = 0.4}));
}

/// Only a ball moves, or only every third particle in it.
bool moves(Vec3d p, Vec3d middle, double radius, std::size_t n, bool scattered) {
    return norm(p - middle) < radius && (!scattered || n % 3 == 0);
}

/// How often each constraint is projected; and that no particle is in a pack or a pair twice.
std::map<std::int32_t, int> projected(const pbd::AwakePacks<float>& awake, const pbd::Plan& plan,
                                      const AlignedVector<float>* numbers, int kind,
                                      std::size_t constraints) {
    std::map<std::int32_t, int> times;
    std::map<std::int32_t, std::int32_t> at_slot;
    for (std::size_t c = 0; c < constraints; ++c)
        if (const auto slot = awake.slot(kind, std::int32_t(c)); slot >= 0) {
            EXPECT_TRUE(at_slot.emplace(slot, std::int32_t(c)).second);
        }
    const auto corners = std::size_t(pbd::kCorners[kind]), count = std::size_t(pbd::kNumbers[kind]);
    for (std::size_t d = 0; d < plan.domains.size(); ++d)
        for (const pbd::Domain& part : awake.of_domain(d)) {
            const pbd::PackRange range = part.packs[kind];
            std::set<std::uint32_t> seen;
            for (auto pack = std::size_t(range.begin); pack < std::size_t(range.end); ++pack) {
                const bool is_second = std::int32_t(pack) < range.paired_end &&
                                       (std::int32_t(pack) - range.begin) % 2 == 1;
                if (!is_second) seen.clear();
                for (std::size_t lane = 0; lane < pbd::kPack; ++lane) {
                    const auto found = at_slot.find(std::int32_t(pack * pbd::kPack + lane));
                    if (found == at_slot.end()) continue;
                    ++times[found->second];
                    for (std::size_t n = 0; n < corners; ++n) {
                        const auto at =
                            awake.corners(kind)[(pack * corners + n) * pbd::kPack + lane];
                        EXPECT_TRUE(seen.insert(at).second);
                    }
                    const auto planned =
                        std::size_t(plan.kinds[kind].slots[std::size_t(found->second)]);
                    for (std::size_t n = 0; n < count; ++n)
                        EXPECT_EQ(awake.numbers(kind)[(pack * count + n) * pbd::kPack + lane],
                                  numbers[kind][(planned / pbd::kPack * count + n) * pbd::kPack +
                                                planned % pbd::kPack]);
                }
            }
        }
    return times;
}

TEST(AwakePacks, ProjectWhatMovesOnceEach) {
    const TetMesh block = five_tet_block({16, 9, 7}, 1);
    const PbdParts parts = parts_of(block);
    const pbd::Plan plan = pbd::make_plan(parts, 300);
    AlignedVector<float> numbers[pbd::kKinds];
    Random random(7);
    for (int kind = 0; kind < pbd::kKinds; ++kind) {
        numbers[kind].resize(plan.kinds[kind].constraints.size() *
                             std::size_t(pbd::kNumbers[kind]));
        for (float& number : numbers[kind]) number = float(random.real(1, 2));
    }
    for (const bool anew : {false, true}) {
        pbd::AwakePacks<float> awake(parts, plan, numbers, anew);
        std::size_t needless = 0, needed = 0;
        for (int round = 0; round < 12; ++round) {
            SCOPED_TRACE(round);
            const Vec3d middle{random.real(0, 16), random.real(0, 9), random.real(0, 7)};
            const double radius = round % 4 == 3 ? 100 : random.real(2, 7);
            std::vector<float> x(std::size_t(plan.particle_count) * 4, 0.0f);
            for (std::size_t n = 0; n < parts.positions.size(); ++n)
                if (moves(parts.positions[n], middle, radius, n, round % 4 == 2))
                    x[std::size_t(plan.particle_of[n]) * 4 + 3] = 1;
            awake.update(x.data());
            for (const int kind : {kDistance, kSolid}) {
                const std::size_t count = pbd::constraint_count(parts, kind);
                const auto times = projected(awake, plan, numbers, kind, count);
                for (std::size_t c = 0; c < count; ++c) {
                    bool must = false;
                    for (const std::int32_t n : pbd::nodes_of(parts, kind, c))
                        must |= x[std::size_t(plan.particle_of[std::size_t(n)]) * 4 + 3] > 0;
                    const auto found = times.find(std::int32_t(c));
                    const int is = found == times.end() ? 0 : found->second;
                    EXPECT_LE(is, 1);
                    if (must) {
                        EXPECT_EQ(is, 1);
                    }
                    needed += must;
                    needless += is && !must;
                }
            }
        }
        std::printf("%s: %zu needed, %zu needless\n", anew ? "anew" : "as planned", needed,
                    needless);
        if (anew) {
            EXPECT_LT(double(needless), 0.1 * double(needed));
        }
    }
}

/// Steps of a body of which changing parts are held, then of all of it.
std::uint64_t walked(const PbdParts& parts, const PbdSettings& settings, int threads,
                     std::vector<Vec3d>& positions) {
    const TaskArena arena(threads);
    PbdBody body = made(PbdBody::create(parts, settings));
    std::vector<std::int32_t> all;
    std::vector<Vec3d> forces;
    for (std::size_t n = 0; n < parts.positions.size(); ++n) {
        all.push_back(std::int32_t(n));
        forces.push_back({0, 0, parts.positions[n].z == 7 ? -150.0 : 0.0});
    }
    EXPECT_TRUE(body.load(all, forces).ok());
    for (int round = 0; round < 5; ++round) {
        const Vec3d middle{4.0 * round, 4, 6};
        for (std::size_t n = 0; n < parts.positions.size(); ++n)
            EXPECT_TRUE(
                body.set_inverse_mass(std::int32_t(n),
                                      round == 4 || moves(parts.positions[n], middle, 5, n, false)
                                          ? parts.inverse_masses[n]
                                          : 0)
                    .ok());
        EXPECT_TRUE(body.step(round == 4 ? 150 : 8, arena).ok());
    }
    positions.resize(parts.positions.size());
    body.get_positions(positions);
    return body.hash();
}

TEST(AwakePacks, EndWhereThePlanEndsWithAnyThreadsAndLanes) {
    const TetMesh block = five_tet_block({16, 9, 7}, 1);
    PbdParts parts = parts_of(block);
    for (std::size_t n = 0; n < parts.positions.size(); ++n)
        if (parts.positions[n].z == 0) parts.inverse_masses[n] = 0;
    PbdSettings s{.time_step = 2e-3, .sub_steps = 10, .damping = 60, .domain_particles = 300};
    std::vector<Vec3d> planned, anew, other;
    walked(parts, s, 1, planned);
    s.repacks = true;
    const std::uint64_t hash = walked(parts, s, 1, anew);
    EXPECT_EQ(walked(parts, s, 4, other), hash);
    s.vectors = false;
    EXPECT_EQ(walked(parts, s, 2, other), hash);
    double apart = 0, moved = 0;
    for (std::size_t n = 0; n < planned.size(); ++n) {
        apart = std::max(apart, norm(planned[n] - anew[n]));
        moved = std::max(moved, norm(planned[n] - parts.positions[n]));
    }
    std::printf("moved %.4f, apart %.2e\n", moved, apart);
    EXPECT_GT(moved, 0.02);
    EXPECT_LT(apart, 1e-3 * moved);
}

}  // namespace
}  // namespace pliant::test
