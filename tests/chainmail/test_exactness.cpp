// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The heart of Pliant: solvers against the brute-force oracle, on random lattices.
// Covers: chainmail/chainmail.cpp, propagate/propagate_*.cpp.

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "chainmail/oracle.h"
#include "lattice/lattice.h"
#include "material/limit_units.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kExactnessSeed = 20260101;

// The brute force is slow under a sanitizer, which checks memory and not the numbers.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kInstances = 24;
#else
constexpr std::uint64_t kInstances = 240;
#endif

ChainMail make_tissue(const Instance& instance, ChainMailSolver solver, int brick_size,
                      const TaskArena& arena) {
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    settings.solver = solver;
    settings.brick_size = brick_size;
    return std::move(ChainMail::create(instance.volume, settings, arena)).value();
}

Vec3<Fixed> displacement(const ChainMail& tissue, Vec3i e) {
    return lattice_of(tissue).displacement_at(e);
}

/// Half of the lattices have the size required by the vector instructions.
int random_brick_size(Random& random) {
    const int size = random.whole(2, 15);
    return size < 10 ? size : 8;
}

struct Errors {
    double voxels = 0;       ///< largest distance from the oracle in doubles
    std::int64_t units = 0;  ///< largest distance from the oracle in integers
    std::int64_t moved = 0;
};

Errors compare(const ChainMail& tissue, const Oracle<std::int64_t>& exact,
               const Oracle<double>& real) {
    Errors errors;
    exact.for_each([&](Vec3i e) {
        const Vec3<Fixed> u = displacement(tissue, e);
        bool moved = false;
        for (int a = 0; a < 3; ++a) {
            moved |= exact.displacement(e, a) != 0;
            errors.units = std::max(errors.units, std::abs(u[a] - exact.displacement(e, a)));
            errors.voxels =
                std::max(errors.voxels, std::abs(mm_from_units(u[a]) - real.displacement(e, a)) /
                                            tissue.volume().grid.spacing_mm[a]);
        }
        errors.moved += moved;
    });
    return errors;
}

/// @param[in,out] pushes  compared ones @param[in,out] moved  elements that they moved
void run_exact_instance(std::uint64_t seed, int& pushes, std::int64_t& moved) {
    Random random(seed);
    const TaskArena arena(1 + int(seed % 2));
    const Instance instance = random_instance(random, 4, 9, true);
    const Grid& grid = instance.volume.grid;
    ChainMail sweep =
        make_tissue(instance, ChainMailSolver::Sweep, random_brick_size(random), arena);
    ChainMail heap = make_tissue(instance, ChainMailSolver::Heap, 8, arena);
    Oracle<std::int64_t> exact(instance.volume, instance.law, kInstanceMargin);
    Oracle<double> real(instance.volume, instance.law, kInstanceMargin);
    Vec3d last{0, 0, 0};
    std::vector<Vec3i> grabbed = random_grab(random, grid);
    for (int step = 0; step < 4; ++step) {
        const Vec3d push_mm = step == 2 ? -1.0 * last : random.vector(instance.push_limit_mm.x);
        if (step != 2) grabbed = random_grab(random, grid);
        last = push_mm;
        const Vec3<Fixed> before = displacement(sweep, grabbed[0]);
        const auto report = sweep.push_elements(grabbed, push_mm);
        const auto same = heap.push_elements(grabbed, push_mm);
        ASSERT_TRUE(report.ok() && same.ok());
        const Vec3<Fixed> done = displacement(sweep, grabbed[0]) - before;
        for (int a = 0; a < 3; ++a)
            ASSERT_NEAR(mm_from_units(done[a]), report->step_fraction * push_mm[a], 3e-6);
        exact.push(grabbed, Vec3<std::int64_t>{done.x, done.y, done.z});
        real.push(grabbed, {mm_from_units(done.x), mm_from_units(done.y), mm_from_units(done.z)});
        ASSERT_TRUE(exact.margin_at_rest()) << "the instance outgrew its margin";
        const Errors errors = compare(sweep, exact, real);
        EXPECT_EQ(errors.units, 0);
        EXPECT_LT(errors.voxels, 1e-4);
        EXPECT_EQ(sweep.hash(), heap.hash());
        EXPECT_EQ(report->step_fraction, same->step_fraction);
        const LatticeState state = sweep.state();
        EXPECT_EQ(state.moved_elements, errors.moved);
        EXPECT_LT(state.max_violation_mm, 1e-4 * 0.7);
        ++pushes;
        moved += errors.moved;
    }
}

TEST(Exactness, SolversEqualTheOracleOnRandomLattices) {
    int pushes = 0;
    std::int64_t moved = 0;
    for (std::uint64_t n = 0; n < kInstances && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kExactnessSeed + n));
        run_exact_instance(kExactnessSeed + n, pushes, moved);
    }
    std::printf("%d pushes, %lld moved elements\n", pushes, static_cast<long long>(moved));
}

TEST(Exactness, TheOracleNoticesASingleUnit) {
    Random random(kExactnessSeed);
    const TaskArena arena(1);
    const Instance instance = random_instance(random, 6, 6, false);
    ChainMail tissue = make_tissue(instance, ChainMailSolver::Sweep, 8, arena);
    Oracle<std::int64_t> exact(instance.volume, instance.law, kInstanceMargin);
    Oracle<double> real(instance.volume, instance.law, kInstanceMargin);
    const std::vector<Vec3i> grabbed = {{3, 3, 3}};
    ASSERT_TRUE(tissue.push_elements(grabbed, instance.push_limit_mm).ok());
    const Vec3<Fixed> done = displacement(tissue, grabbed[0]);
    exact.push(grabbed, Vec3<std::int64_t>{done.x, done.y, done.z + 1});
    real.push(grabbed, {mm_from_units(done.x), mm_from_units(done.y), mm_from_units(done.z)});
    EXPECT_GT(compare(tissue, exact, real).units, 0);
}

TEST(Exactness, LargeHeterogeneousPushIsTheSameForEverySolverBrickSizeAndThreadCount) {
    Random random(kExactnessSeed + 7);
    const Instance instance = random_instance(random, 40, 48, false);
    const std::vector<Vec3i> first = {{20, 20, 20}, {21, 20, 20}}, second = {{25, 18, 22}};
    std::set<std::uint64_t> hashes;
    std::set<std::tuple<std::int64_t, double>> reports;
    const auto run = [&](ChainMailSolver solver, int brick_size, int threads) {
        const TaskArena arena(threads);
        ChainMail tissue = make_tissue(instance, solver, brick_size, arena);
        ASSERT_TRUE(tissue.push_elements(first, {2.5, -1.25, 0.75}).ok());
        const auto report = tissue.push_elements(second, {-3, 2, 1});
        ASSERT_TRUE(report.ok());
        hashes.insert(tissue.hash());
        reports.insert({report->moved_elements, report->step_fraction});
    };
    run(ChainMailSolver::Heap, 8, 1);
    for (const int threads : {1, 2, 4})
        for (const int brick_size : {4, 8, 16}) run(ChainMailSolver::Sweep, brick_size, threads);
    EXPECT_EQ(hashes.size(), 1u);
    EXPECT_EQ(reports.size(), 1u);
    EXPECT_GT(std::get<0>(*reports.begin()), 5000);
}

/// Tissue of a few materials with some balls of bone.
Instance instance_with_bone(Random& random) {
    Instance instance = random_instance(random, 36, 44, false);
    const Grid& grid = instance.volume.grid;
    constexpr std::int16_t kBone = 1000;
    auto& voxels = std::get<VoxelArray<std::int16_t>>(instance.volume.voxels);
    for (int ball = 0; ball < 5; ++ball) {
        const Vec3i centre{random.whole(0, grid.size.x - 1), random.whole(0, grid.size.y - 1),
                           random.whole(0, grid.size.z - 1)};
        const int radius = random.whole(1, 5);
        for (int z = 0; z < grid.size.z; ++z)
            for (int y = 0; y < grid.size.y; ++y)
                for (int x = 0; x < grid.size.x; ++x) {
                    const Vec3i d = Vec3i{x, y, z} - centre;
                    if (d.x * d.x + d.y * d.y + d.z * d.z <= radius * radius)
                        voxels[voxel_index(grid, {x, y, z})] = kBone;
                }
    }
    instance.law = [law = instance.law](int value) {
        ElementLimits limits = law(value);
        limits.fixed = value == kBone;
        limits.max_movement_mm = 500;
        return limits;
    };
    return instance;
}

/// Sweeps leave out the raises that bone cancels; the heap doesn't.
TEST(Exactness, PushesThatBoneShortensAreThoseOfTheHeap) {
    int shortened = 0;
    for (std::uint64_t n = 0; n < 6 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kExactnessSeed + n));
        Random random(kExactnessSeed + n);
        const Instance instance = instance_with_bone(random);
        const TaskArena one(1), two(2);
        ChainMail heap = make_tissue(instance, ChainMailSolver::Heap, 8, one);
        std::vector<ChainMail> sweeps;
        sweeps.push_back(make_tissue(instance, ChainMailSolver::Sweep, 8, one));
        sweeps.push_back(make_tissue(instance, ChainMailSolver::Sweep, 8, two));
        sweeps.push_back(make_tissue(instance, ChainMailSolver::PlainSweep, 5, two));
        for (int step = 0; step < 4; ++step) {
            const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
            const Vec3d push_mm = random.vector(step % 2 ? 4 : 20);
            const auto expected = heap.push_elements(grabbed, push_mm);
            ASSERT_TRUE(expected.ok());
            shortened += expected->limited_by == LimitedBy::Bone && expected->step_fraction > 0;
            for (ChainMail& sweep : sweeps) {
                const auto report = sweep.push_elements(grabbed, push_mm);
                ASSERT_TRUE(report.ok());
                EXPECT_EQ(sweep.hash(), heap.hash());
                EXPECT_EQ(report->step_fraction, expected->step_fraction);
                EXPECT_EQ(report->moved_elements, expected->moved_elements);
                EXPECT_EQ(report->message, expected->message);
            }
        }
    }
    EXPECT_GE(shortened, 10);
}

}  // namespace
}  // namespace pliant::test
