// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The largest valid step against brute force: the oracle tests the state at many fractions, and the
// first invalid one is bracketed.

#include <gtest/gtest.h>

#include "chainmail/chainmail_impl.h"
#include "chainmail/oracle.h"
#include "chainmail/tissues.h"
#include "lattice/lattice.h"
#include "material/limit_units.h"

namespace pliant::test {
namespace {

/// Random lattice with tight movement limits and some bone.
Instance limited_instance(Random& random) {
    Instance instance = random_instance(random, 5, 7, true);
    const double tightest = random.real(0.2, 1.5);
    instance.law = [law = instance.law, tightest](int value) {
        ElementLimits limits = law(value);
        limits.max_movement_mm = value < 0 ? 500 : tightest * (1 + value % 3);
        return limits;
    };
    return instance;
}

bool is_valid(const Oracle<double>& oracle) {
    bool valid = true;
    oracle.for_each([&](Vec3i e) {
        const ElementLimits& limits = oracle.limits(e);
        const Vec3d u{oracle.displacement(e, 0), oracle.displacement(e, 1),
                      oracle.displacement(e, 2)};
        // Tolerances: quantised limits are tighter by up to a few units per link on the path.
        if (limits.fixed) valid &= norm(u) < 1e-4;
        valid &= norm(u) < limits.max_movement_mm + 1e-4;
    });
    return valid;
}

/// Largest fraction up to which every state is valid.
double brute_force_fraction(const Oracle<double>& before, std::span<const Vec3i> grabbed,
                            Vec3d push_mm) {
    const auto valid_at = [&](double f) {
        Oracle<double> after = before;
        after.push(grabbed, f * push_mm);
        return is_valid(after);
    };
    constexpr int kScan = 16;
    for (int n = 1; n <= kScan; ++n) {
        if (valid_at(double(n) / kScan)) continue;
        double low = double(n - 1) / kScan, high = double(n) / kScan;
        while (high - low > 2e-4) {
            const double middle = (low + high) / 2;
            (valid_at(middle) ? low : high) = middle;
        }
        return low;
    }
    return 1;
}

TEST(Step, FractionIsTheLargestValidOne) {
    int limited = 0, rejected = 0, by_bone = 0, by_movement = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1);
        const Instance instance = limited_instance(random);
        ChainMail tissue = tissue_of(instance, arena);
        Oracle<double> oracle(instance.volume, instance.law, kInstanceMargin);
        for (int step = 0; step < 2; ++step) {
            const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
            const Vec3d push_mm = random.vector(instance.push_limit_mm.x);
            const auto report = tissue.push_elements(grabbed, push_mm);
            ASSERT_TRUE(report.ok());
            const double expected = brute_force_fraction(oracle, grabbed, push_mm);
            ASSERT_NEAR(report->step_fraction, expected, 1e-3);
            oracle.push(grabbed, report->step_fraction * push_mm);
            limited += report->status == PushStatus::Limited;
            rejected += report->status == PushStatus::Rejected;
            by_bone += report->limited_by == LimitedBy::Bone;
            by_movement += report->limited_by == LimitedBy::Movement;
            EXPECT_EQ(report->status == PushStatus::Applied, report->limited_by == LimitedBy::None);
        }
    }
    // The instances cover every outcome.
    EXPECT_GT(limited, 10);
    EXPECT_GT(rejected, 2);
    EXPECT_GT(by_bone, 5);
    EXPECT_GT(by_movement, 5);
}

TEST(Step, BoneNeverMovesAndMovementLimitsHoldToTheUnit) {
    for (std::uint64_t seed = 100; seed < 130; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        const Instance instance = limited_instance(random);
        ChainMail tissue = tissue_of(instance, arena);
        for (int step = 0; step < 8; ++step) {
            const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
            ASSERT_TRUE(tissue.push_elements(grabbed, random.vector(6)).ok());
            for (int z = 0; z < instance.volume.grid.size.z; ++z)
                for (int y = 0; y < instance.volume.grid.size.y; ++y)
                    for (int x = 0; x < instance.volume.grid.size.x; ++x) {
                        const int value = int(instance.volume.at({x, y, z}));
                        const ElementLimits limits = instance.law(value);
                        const Vec3<Fixed> u = lattice_of(tissue).displacement_at({x, y, z});
                        const Vec3d mm{mm_from_units(u.x), mm_from_units(u.y), mm_from_units(u.z)};
                        ASSERT_TRUE(!limits.fixed || u == (Vec3<Fixed>{0, 0, 0}));
                        ASSERT_LE(norm(mm), limits.max_movement_mm);
                    }
        }
    }
}

}  // namespace
}  // namespace pliant::test
