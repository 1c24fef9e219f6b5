// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hard volumes of a vessel under a lasting pressure, with as few sub-steps as real time allows: the
// remaining error with and without recovery.
// Covers: pbd/solver.cpp.

#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "support/made.h"

namespace pliant::test {
namespace {

constexpr double kInner = 6, kLength = 24, kTimeStep = 1.0 / 256;

struct Vessel {
    PbdParts parts;
    std::vector<std::int32_t> inner;
    std::vector<Vec3d> forces;  ///< of a pressure of 1

    Vessel() {
        std::vector<CentrePoint> way;
        for (int n = 0; n <= 12; ++n) way.push_back({{0, 0, kLength * n / 12}, kInner});
        const VesselWall wall =
            test::made(swept_tube(way, {.thickness_mm = 1.5, .layers = 2, .sectors = 20}));
        // As heavy as the wall of pliant vessel.
        parts = test::made(pbd_of_mesh(
            wall.mesh,
            {.density = 0.02, .edge_compliance = 1e-3, .bend_compliance = 1, .bends = true}));
        for (std::size_t n = 0; n < parts.positions.size(); ++n) {
            const Vec3d p = parts.positions[n];
            if (p.z < 1e-6 || p.z > kLength - 1e-6) parts.inverse_masses[n] = 0;
            if (std::hypot(p.x, p.y) > kInner + 1e-3) continue;
            inner.push_back(std::int32_t(n));
            forces.push_back((1 / kInner) * Vec3d{p.x, p.y, 0});
        }
        const double area = 2 * std::numbers::pi * kInner * kLength / double(inner.size());
        for (Vec3d& f : forces) f = area * f;
    }
    void press(double pressure, PbdBody& body) const {
        std::vector<Vec3d> all;
        for (const Vec3d& f : forces) all.push_back(pressure * f);
        EXPECT_TRUE(body.load(inner, all).ok());
    }
    VolumeChange change(const PbdBody& body) const {
        std::vector<Vec3d> positions(parts.positions.size());
        body.get_positions(positions);
        return volume_change(parts, positions);
    }
    double inner_radius(const PbdBody& body) const {
        double sum = 0;
        int count = 0;
        for (const std::int32_t n : inner) {
            const Vec3d p = body.position(n);
            if (std::abs(p.z - 0.5 * kLength) > 0.25 * kLength) continue;
            sum += std::hypot(p.x, p.y);
            ++count;
        }
        return sum / count;
    }
    double speed(const PbdBody& body) const {
        double most = 0;
        for (std::int32_t n = 0; n < body.particle_count(); ++n)
            most = std::max(most, norm(body.velocity(n)));
        return most;
    }
};

TEST(VolumeRecovery, ALoadThatLastsStopsShowing) {
    const TaskArena arena(1);
    const Vessel vessel;
    double mean[2], radius[2], left[2];
    for (const bool recovers : {false, true}) {
        PbdBody body =
            test::made(PbdBody::create(vessel.parts, {.time_step = kTimeStep,
                                                      .sub_steps = 5,
                                                      .damping = 20,
                                                      .volume_recovery = recovers ? 10.0 : 0}));
        vessel.press(20, body);
        ASSERT_TRUE(body.step(384, arena).ok());
        const VolumeChange loaded = vessel.change(body);
        mean[recovers] = loaded.mean;
        radius[recovers] = vessel.inner_radius(body);
        const double speed = vessel.speed(body);
        vessel.press(0, body);
        ASSERT_TRUE(body.step(384, arena).ok());
        const VolumeChange after = vessel.change(body);
        std::printf(
            "%s: radius %.3f mm, mean %.4f %%, largest %.3f %%, total %.4f %%, speed %.4f mm/s; "
            "unloaded %.3f mm, mean %.4f %%, speed %.4f mm/s\n",
            recovers ? "recovers" : "doesn't", radius[recovers], 100 * loaded.mean,
            100 * loaded.largest, 100 * loaded.total, speed, vessel.inner_radius(body),
            100 * after.mean, vessel.speed(body));
        EXPECT_NEAR(vessel.inner_radius(body), kInner, recovers ? 0.03 : 0.001);
        left[recovers] = after.mean;
    }
    EXPECT_GT(mean[false], 1.5e-3);
    EXPECT_LE(mean[true], 1e-3);
    // Targets that stayed where the load has moved them would leave their shift behind.
    EXPECT_LE(left[true], 5e-4);
    EXPECT_LE(left[false], 1e-5);
    EXPECT_GT(radius[true], 1.003 * kInner);  // volumes that are kept make it stiffer
}

// With boxes' packs made anew, too: shifted targets move with their constraints.
TEST(VolumeRecovery, IsTheSameForThreadsVectorsAndPacks) {
    const Vessel vessel;
    for (const bool anew : {false, true}) {
        std::uint64_t expected = 0;
        double mean = 0;
        for (const int threads : {1, 2, 4})
            for (const bool vectors : {true, false}) {
                const TaskArena arena(threads);
                PbdBody body = test::made(PbdBody::create(vessel.parts, {.time_step = kTimeStep,
                                                                         .sub_steps = 5,
                                                                         .damping = 20,
                                                                         .vectors = vectors,
                                                                         .domain_particles = 200,
                                                                         .volume_recovery = 10,
                                                                         .repacks = anew}));
                // Half of it is held, then less of it, then more.
                for (const double held : {12.0, 6.0, 16.0}) {
                    for (std::int32_t n = 0; n < body.particle_count(); ++n) {
                        const double z = vessel.parts.positions[std::size_t(n)].z;
                        const double w = vessel.parts.inverse_masses[std::size_t(n)];
                        ASSERT_TRUE(body.set_inverse_mass(n, z < held ? 0 : w).ok());
                    }
                    vessel.press(20, body);
                    ASSERT_TRUE(body.step(8, arena).ok());
                }
                if (expected == 0) expected = body.hash();
                if (mean == 0) mean = vessel.change(body).mean;
                EXPECT_EQ(body.hash(), expected) << threads << ' ' << vectors;
                EXPECT_EQ(vessel.change(body).mean, mean);
            }
    }
}

}  // namespace
}  // namespace pliant::test
