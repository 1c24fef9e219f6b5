// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies where memory runs out: what fails changes nothing, and later steps give the bits of a body
// on which nothing failed.

#include <gtest/gtest.h>
#include <pliant/pbd.h>
#include <pliant/pbd_boxes.h>

#include <cstdio>
#include <memory>

#include "support/each_allocation.h"
#include "support/made.h"

namespace pliant::test {
namespace {

PbdParts block() {
    auto parts = pbd_of_mesh(
        five_tet_block({5, 4, 4}, 1),
        {.edge_compliance = 1e-4, .volume_compliance = 1e-4, .solids = true, .young_modulus = 1e3});
    PbdParts all = made(std::move(parts));
    for (std::size_t n = 0; n < all.places.size(); ++n)
        if (all.places[n].x < 0.5) all.inverse_masses[n] = 0;
    return all;
}

constexpr PbdSettings kSettings{.gravity = {0, 0, -9.81}, .packs_anew = true};

const TaskArena& arena() {
    static const TaskArena one(1);
    return one;
}

/// Held particles are let go: the packs are made anew in the next step.
std::unique_ptr<PbdBody> let_go_body() {
    auto body = std::make_unique<PbdBody>(made(PbdBody::create(block(), kSettings)));
    EXPECT_TRUE(body->step(3, arena()).ok());
    for (std::int32_t n = 0; n < body->particle_count(); ++n)
        if (body->inverse_mass(n) == 0) {
            EXPECT_TRUE(body->set_inverse_mass(n, 0.5).ok());
        }
    return body;
}

const auto hash_of = [](const PbdBody& body) { return body.hash(); };

TEST(BodiesWithoutMemory, AStepIsAllOrNothing) {
    const auto step = [](PbdBody& body) { return body.step(1, arena()); };
    const Failures found = fail_each_allocation(let_go_body, step, hash_of, {.fresh = true});
    std::printf("step: %d of %lld allocations failed\n", found.failed,
                static_cast<long long>(found.allocations));
}

TEST(BodiesWithoutMemory, StepsAfterAFailureGiveTheSameBits) {
    const auto twin = let_go_body();
    ASSERT_TRUE(twin->step(10, arena()).ok());
    for (int n = 0; n < 40; ++n) {
        const auto body = let_go_body();
        {
            const FailingAllocation failing(n);
            if (body->step(1, arena()).ok()) {
                EXPECT_GT(n, 0);
                break;
            }
        }
        ASSERT_TRUE(body->step(10, arena()).ok());
        EXPECT_EQ(body->hash(), twin->hash()) << "allocation " << n;
    }
}

TEST(BodiesWithoutMemory, LoadsAndStatesAreSetAltogetherOrNotAtAll) {
    const std::vector<std::int32_t> particles{1, 2, 3, 40};
    const std::vector<Vec3d> forces(4, Vec3d{0, 0, 5});
    const auto make = [] {
        return std::make_unique<PbdBody>(made(PbdBody::create(block(), kSettings)));
    };
    // What was loaded shows in the next step.
    const auto later = [](const PbdBody& body) { return body.hash(); };
    fail_each_allocation(
        make, [&](PbdBody& body) { return body.load(particles, forces); }, later);
    const auto place = [](PbdBody& body) { return body.set_state(0, {0, 0, 1}, {0, 0, 0}); };
    fail_each_allocation(make, place, hash_of);
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
    ASSERT_TRUE(body->step(2, arena()).ok());
    ASSERT_TRUE(twin->step(2, arena()).ok());
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
