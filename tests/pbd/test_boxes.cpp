// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Boxes against brute force, collisions of the published hash, and transitions between active sets.
// Covers: pbd/builders.cpp.

#include <gtest/gtest.h>
#include <pliant/models/pbd.h>

#include <algorithm>
#include <cstdio>

#include "support/made.h"
#include "support/random.h"

namespace pliant::test {
namespace {

TEST(PbdBoxes, ATipWakesTheBoxAroundIt) {
    const TetMesh block = five_tet_block({10, 10, 10}, 1);
    auto parts = made(pbd_of_mesh(block, {}));
    for (int n = 0; n < 60; ++n) {
        const Vec3d tip{0.5 + n % 10, 0.5 + n / 10, 4.5};
        PbdBoxes boxes = made(PbdBoxes::create(block, {.side = 1}));
        EXPECT_EQ(boxes.box_counts(), (Vec3i{10, 10, 10}));
        PbdBody body = made(PbdBody::create(parts, {}));
        ASSERT_TRUE(boxes.update(std::span(&tip, 1), 0, body).ok());
        EXPECT_EQ(boxes.active_boxes(), 1);
        EXPECT_TRUE(boxes.is_active(boxes.linear_index(boxes.box_at(tip))));
    }
}

TEST(PbdBoxes, HoldTheTetrahedraThatBruteForceFinds) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        TetMesh mesh;
        for (int t = 0; t < 200; ++t) {
            const Vec3d at = random.vector(8);
            const Vec3d a = random.vector(1), b = random.vector(1), c = random.vector(1);
            const double volume = dot(cross(a, b), c);
            if (std::abs(volume) < 0.05) continue;
            const auto n = std::int32_t(mesh.nodes_mm.size());
            for (const Vec3d& p : {at, at + a, at + b, at + c}) mesh.nodes_mm.push_back(p);
            mesh.cells.push_back(
                {n, volume > 0 ? n + 1 : n + 2, volume > 0 ? n + 2 : n + 1, n + 3});
        }
        const double d = random.real(1.5, 5);
        PbdBoxes boxes = made(PbdBoxes::create(mesh, {.side = d}));
        Vec3d low = mesh.nodes_mm[0];
        for (const Vec3d& p : mesh.nodes_mm)
            for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]);
        const Vec3i counts = boxes.box_counts();
        for (int k = 0; k < counts.z; ++k)
            for (int j = 0; j < counts.y; ++j)
                for (int i = 0; i < counts.x; ++i) {
                    const Vec3i box{i, j, k};
                    std::vector<std::int32_t> expected;
                    for (std::size_t t = 0; t < mesh.cells.size(); ++t) {
                        bool meets = true;
                        for (int c = 0; c < 3; ++c) {
                            double from = 1e9, to = -1e9;
                            for (const std::int32_t n : mesh.cells[t]) {
                                from = std::min(from, mesh.nodes_mm[std::size_t(n)][c]);
                                to = std::max(to, mesh.nodes_mm[std::size_t(n)][c]);
                            }
                            meets &= to >= low[c] + d * box[c] - d / 3;
                            meets &= from < low[c] + d * (box[c] + 1) + d / 3;
                        }
                        if (meets) expected.push_back(std::int32_t(t));
                    }
                    const auto found = boxes.tetrahedra(boxes.linear_index(box));
                    EXPECT_TRUE(
                        std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
                }
    }
}

// Case 16: a load walks along a bar that its lower side holds; each step's largest movement of a
// particle, in steps in which boxes wake up or fall asleep, and in others.
TEST(PbdBoxes, AHandOverMovesNothingMoreThanOtherStepsDo) {
    const TaskArena arena(2);
    const TetMesh bar = five_tet_block({60, 4, 4}, 1);
    auto parts = made(pbd_of_mesh(bar, {.density = 1e-3,
                                        .edges = false,
                                        .volumes = false,
                                        .solids = true,
                                        .young_modulus = 2e4,
                                        .poisson_ratio = 0.4}));
    for (std::size_t n = 0; n < bar.nodes_mm.size(); ++n)
        if (bar.nodes_mm[n].z == 0) parts.inverse_masses[n] = 0;
    const PbdSettings settings{.time_step = 2e-3, .sub_steps = 20, .damping = 100};
    PbdBody full = made(PbdBody::create(parts, settings));
    PbdBody local = made(PbdBody::create(parts, settings));
    PbdBoxes boxes = made(PbdBoxes::create(bar, {.side = 8, .settled = 5e-4}));
    const auto count = std::size_t(full.particle_count());
    std::vector<Vec3d> before(count), now(count);
    double crossing = 0, inside = 0, difference = 0, moved = 0, share = 0;
    int changes = 0;
    const int steps = 900;
    for (int n = 0; n < steps; ++n) {
        const Vec3d at{6 + 48.0 * n / steps, 2, 4};
        std::vector<std::int32_t> particles;
        std::vector<Vec3d> forces;
        for (std::size_t p = 0; p < count; ++p) {
            const double distance = norm(bar.nodes_mm[p] - at);
            if (distance >= 2) continue;
            particles.push_back(std::int32_t(p));
            forces.push_back((1 - distance / 2) * std::min(1.0, n / 50.0) * Vec3d{0, 0, -1.5e3});
        }
        ASSERT_TRUE(full.load(particles, forces).ok());
        ASSERT_TRUE(local.load(particles, forces).ok());
        const auto was = boxes.active_tetrahedra();
        ASSERT_TRUE(boxes.update(std::span(&at, 1), 9, local).ok());
        const bool changed = n > 0 && boxes.active_tetrahedra() != was;
        local.get_positions(before);
        ASSERT_TRUE(full.step(1, arena).ok());
        ASSERT_TRUE(local.step(1, arena).ok());
        local.get_positions(now);
        double most = 0;
        for (std::size_t p = 0; p < count; ++p) most = std::max(most, norm(now[p] - before[p]));
        (changed ? crossing : inside) = std::max(changed ? crossing : inside, most);
        changes += changed;
        share += double(boxes.active_tetrahedra()) / double(bar.cells.size()) / steps;
        if (n < 100) continue;
        for (std::size_t p = 0; p < count; ++p) {
            const Vec3d place = full.position(std::int32_t(p));
            difference = std::max(difference, norm(place - now[p]));
            moved = std::max(moved, norm(place - bar.nodes_mm[p]));
        }
    }
    std::printf(
        "hand-over: %d, largest movement %.5f, otherwise %.5f; local against full %.5f of "
        "%.5f; active share %.2f\n",
        changes, crossing, inside, difference, moved, share);
    EXPECT_GE(changes, 4);
    EXPECT_LE(crossing, 2 * inside);
    EXPECT_GT(moved, 0.1);
    EXPECT_LT(difference, 0.02 * moved);
    EXPECT_LT(share, 0.8);
}

TEST(PbdBoxes, HoldWhatIsOutside) {
    const TaskArena arena(1);
    const TetMesh bar = five_tet_block({40, 3, 3}, 1);
    PbdBody body = made(PbdBody::create(made(pbd_of_mesh(bar, {.edge_compliance = 1e-4})),
                                        {.gravity = {0, 0, -10}}));
    PbdBoxes boxes = made(PbdBoxes::create(bar, {.side = 5}));
    const Vec3d at{22, 1, 1};
    for (int n = 0; n < 40; ++n) {
        ASSERT_TRUE(boxes.update(std::span(&at, 1), 0.5, body).ok());
        ASSERT_TRUE(body.step(1, arena).ok());
    }
    int movable = 0;
    for (std::size_t p = 0; p < bar.nodes_mm.size(); ++p) {
        bool all_active = true;
        for (std::size_t t = 0; t < bar.cells.size(); ++t) {
            const auto& cell = bar.cells[t];
            if (std::find(cell.begin(), cell.end(), std::int32_t(p)) == cell.end()) continue;
            bool active = false;
            for (std::int32_t b = 0; b < 8; ++b) {
                const auto held = boxes.tetrahedra(b);
                active |= boxes.is_active(b) &&
                          std::binary_search(held.begin(), held.end(), std::int32_t(t));
            }
            all_active &= active;
        }
        EXPECT_EQ(body.inverse_mass(std::int32_t(p)) > 0, all_active);
        if (!all_active) {
            EXPECT_LT(norm(body.position(std::int32_t(p)) - bar.nodes_mm[p]), 1e-5);
        }
        movable += all_active;
    }
    EXPECT_GT(movable, 50);
    EXPECT_LT(movable, int(bar.nodes_mm.size()) / 2);
    EXPECT_FALSE(PbdBoxes::create(bar, {.side = 0}).ok());
    EXPECT_FALSE(PbdBoxes::create(bar, {.side = 1e-6}).ok());
    EXPECT_FALSE(PbdBoxes::create(bar, {.blend_steps = 0}).ok());
    EXPECT_FALSE(boxes.update(std::span(&at, 1), -1, body).ok());
}

}  // namespace
}  // namespace pliant::test
