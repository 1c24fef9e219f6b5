// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies where memory runs out: a failed call changes nothing, and later steps give the bits of a
// body without failures.
// Covers: pbd/body.cpp.

#include <gtest/gtest.h>
#include <pliant/core/tasks.h>
#include <pliant/models/pbd.h>

#include <memory>
#include <vector>

#include "support/each_allocation.h"
#include "support/made.h"

namespace pliant::test {
namespace {

PbdParts block() {
    auto parts = pbd_of_mesh(
        five_tet_block({5, 4, 4}, 1),
        {.edge_compliance = 1e-4, .volume_compliance = 1e-4, .solids = true, .young_modulus = 1e3});
    PbdParts all = made(std::move(parts));
    for (std::size_t n = 0; n < all.positions.size(); ++n)
        if (all.positions[n].x < 0.5) all.inverse_masses[n] = 0;
    return all;
}

constexpr PbdSettings kSettings{.gravity = {0, 0, -9.81}, .repacks = true};

void let_go(PbdBody& body) {
    for (std::int32_t n = 0; n < body.particle_count(); ++n)
        if (body.inverse_mass(n) == 0) {
            EXPECT_TRUE(body.set_inverse_mass(n, 0.5).ok());
        }
}

const auto hash_of = [](const PbdBody& body) { return body.hash(); };

TEST(BodiesWithoutMemory, AFirstStepIsAllOrNothing) {
    const TaskArena one(1);
    const auto make = [] {
        return std::make_unique<PbdBody>(made(PbdBody::create(block(), kSettings)));
    };
    const auto twin = make();
    ASSERT_TRUE(twin->step(6, one).ok());
    int failed = 0;
    for (int n = 0;; ++n) {
        const auto body = make();
        const std::uint64_t before = body->hash();
        Status status = Ok{};
        {
            const FailingAllocation failing(n);
            status = body->step(1, one);
        }
        if (status.ok()) break;
        ++failed;
        EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
        ASSERT_EQ(body->hash(), before) << "allocation " << n;
        ASSERT_TRUE(body->step(6, one).ok());
        EXPECT_EQ(body->hash(), twin->hash()) << "allocation " << n;
    }
    EXPECT_GT(failed, 0);
}

// Steps after the first one, after held particles were let go, so that packs are made anew, and
// with loads: all of them with no memory at all.
TEST(BodiesWithoutMemory, LaterStepsNeedNone) {
    for (const bool repacks : {false, true})
        for (const int threads : {1, 2}) {
            const TaskArena arena(threads);
            PbdSettings settings = kSettings;
            settings.repacks = repacks;
            PbdBody body = made(PbdBody::create(block(), settings)),
                    twin = made(PbdBody::create(block(), settings));
            const auto step_both = [&] {
                Status status = Ok{};
                {
                    const FailingAllocation failing(0);
                    for (int n = 0; n < 5 && status.ok(); ++n) status = body.step(1, arena);
                }
                ASSERT_TRUE(status.ok()) << status.error().message;
                ASSERT_TRUE(twin.step(5, arena).ok());
                EXPECT_EQ(body.hash(), twin.hash());
            };
            for (PbdBody* each : {&body, &twin}) ASSERT_TRUE(each->step(1, arena).ok());
            step_both();
            for (PbdBody* each : {&body, &twin}) let_go(*each);
            step_both();
            const std::int32_t pulled = 40;
            const Vec3d pull{0, 0, 5};
            for (PbdBody* each : {&body, &twin})
                ASSERT_TRUE(each->load({&pulled, 1}, {&pull, 1}).ok());
            step_both();
        }
}

TEST(BodiesWithoutMemory, LoadsAndStatesAreSetAltogetherOrNotAtAll) {
    const std::vector<std::int32_t> particles{1, 2, 3, 40};
    const std::vector<Vec3d> forces(4, Vec3d{0, 0, 5});
    const auto make = [] {
        return std::make_unique<PbdBody>(made(PbdBody::create(block(), kSettings)));
    };
    // Loads take effect in the next step.
    const auto later = [](const PbdBody& body) { return body.hash(); };
    fail_each_allocation(
        make, [&](PbdBody& body) { return body.load(particles, forces); }, later);
    const auto place = [](PbdBody& body) { return body.set_state(0, {0, 0, 1}, {0, 0, 0}); };
    fail_each_allocation(make, place, hash_of);
    const TaskArena one(1);
    const auto body = make(), twin = make();
    ASSERT_TRUE(twin->load(particles, forces).ok());
    ASSERT_TRUE(body->load(particles, forces).ok());
    const std::vector<std::int32_t> more(500, 3);
    const std::vector<Vec3d> pulls(500, Vec3d{1, 0, 0});
    {
        const FailingAllocation failing(0);
        const Status status = body->load(more, pulls);
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().code, ErrorCode::LimitExceeded);
    }
    ASSERT_TRUE(body->step(2, one).ok());
    ASSERT_TRUE(twin->step(2, one).ok());
    EXPECT_EQ(body->hash(), twin->hash());  // the former loads are still there
}

TEST(BodiesWithoutMemory, WhatCantBeMadeIsAnError) {
    int failed = 0;
    for (int n = 0; n < 400; n = n < 40 ? n + 1 : n + 13) {
        PbdParts parts = block();
        const FailingAllocation failing(n);
        const auto body = PbdBody::create(std::move(parts), kSettings);
        if (body.ok()) break;
        ++failed;
        if (body.error().code != ErrorCode::LimitExceeded) FAIL() << "allocation " << n;
    }
    EXPECT_GT(failed, 10);
}

}  // namespace
}  // namespace pliant::test
