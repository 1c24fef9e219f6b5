// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sources of a live deformation's voxels: their displacement, and the local growth of tissue.
// Covers: resample/source_jacobian.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>

#include "chainmail/chainmail_impl.h"
#include "resample/lattices.h"
#include "resample/random_tissue.h"
#include "resample/source_jacobian.h"
#include "support/random.h"

namespace pliant::test {
namespace {

struct Fields {
    std::vector<float> displacement_mm, jacobian;
    friend bool operator==(const Fields&, const Fields&) = default;
};

Fields fields_of(const LiveDeformation& live) {
    const Box3i all = voxel_box(live.volume().grid);
    Fields fields{std::vector<float>(voxel_count(live.volume().grid)),
                  std::vector<float>(voxel_count(live.volume().grid))};
    live.displacement_mm(all, fields.displacement_mm);
    live.jacobian(all, fields.jacobian);
    return fields;
}

/// det ∂φ/∂X by differences of φ itself, in the cell that holds X + toward.
double jacobian_by_differences(const Lattice& lattice, Vec3d x, Vec3d toward) {
    constexpr double kStep = 1e-4;
    Mat3d f{};
    for (int a = 0; a < 3; ++a) {
        Vec3d before = x + toward, after = x + toward;
        before[a] -= kStep;
        after[a] += kStep;
        f.columns[a] =
            (0.5 / kStep) * (deformed_place(lattice, after) - deformed_place(lattice, before));
    }
    return determinant(f);
}

TEST(Sources, RandomPushesCutsAndCarvesGiveTheInverseOfTheOneShotForm) {
    // The last two once found errors that the others missed: gaps among folds, and a strip whose
    // shift changed without a change of its cells.
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8, 15, 132}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(1 + int(seed % 3));
        // Named, because the order of evaluation of arguments is unspecified.
        const Vec3i size{random.whole(30, 50), random.whole(30, 44), random.whole(20, 40)};
        const Vec3d spacing_mm{1, random.real(0.6, 1.4), random.real(0.8, 2)};
        const Volume volume = turned_noise(random, size, spacing_mm);
        ChainMail tissue = tissue_of(volume, arena, seed % 3 == 0 ? 5 : 8);
        LiveDeformation live = LiveDeformation::create(tissue).value();
        LiveDeformation plain = LiveDeformation::create(tissue).value();
        const int begin = random.whole(0, 6);
        Fields before;
        for (int step = 0; step < 12; ++step) {
            if (step == begin) {
                EXPECT_FALSE(live.keeps_sources());
                ASSERT_TRUE(live.keep_sources(true));
                before = fields_of(live);
            }
            if (seed % 2 && step % 4 == 3)
                cut_or_carve(random, tissue);
            else if (step == 9)
                tissue.reset();
            else
                ASSERT_TRUE(tissue.push(random_push(random, volume.grid, 12)).ok());
            const LiveUpdate update = live.update().value();
            (void)plain.update();
            const Deformed once = deform_volume(tissue, Mapping::Cells, true).value();
            ASSERT_EQ(live.volume().voxels, plain.volume().voxels) << "step " << step;
            ASSERT_EQ(live.volume().voxels, once.volume.voxels) << "step " << step;
            if (step < begin) continue;
            const Fields now = fields_of(live);
            const VectorField inverse = inverse_field(once).value();
            const Vec3i n = volume.grid.size;
            std::size_t v = 0;
            for (int z = 0; z < n.z; ++z)
                for (int y = 0; y < n.y; ++y)
                    for (int x = 0; x < n.x; ++x, ++v) {
                        const Vec3f u = inverse.vectors_mm[v];
                        const float moved = std::sqrt(u.x * u.x + u.y * u.y + u.z * u.z);
                        ASSERT_EQ(now.displacement_mm[v], moved)
                            << "step " << step << " at " << x << ' ' << y << ' ' << z;
                        const bool is_told = std::any_of(update.boxes.begin(), update.boxes.end(),
                                                         [&](const Box3i& box) {
                                                             return contains(box, {x, y, z});
                                                         });
                        if (is_told) continue;
                        ASSERT_EQ(now.displacement_mm[v], before.displacement_mm[v]);
                        ASSERT_EQ(now.jacobian[v], before.jacobian[v])
                            << "step " << step << " at " << x << ' ' << y << ' ' << z;
                    }
            before = now;
        }
    }
}

TEST(Sources, TheJacobianIsThatOfTheMapItself) {
    for (std::uint64_t seed = 11; seed <= 16; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        const Volume volume = turned_noise(random, {32, 30, 28}, {1, 1.3, 0.8});
        const bool edited = seed % 2 == 0;
        ChainMail tissue = tissue_of(volume, arena, 8, seed == 16);
        LiveDeformation live = LiveDeformation::create(tissue).value();
        if (edited) cut_or_carve(random, tissue);
        for (int push = 0; push < 4; ++push)
            ASSERT_TRUE(tissue.push(random_push(random, volume.grid, 5)).ok());
        (void)live.update();
        ASSERT_TRUE(live.keep_sources(true));
        const Fields fields = fields_of(live);
        const VectorField inverse =
            inverse_field(deform_volume(tissue, Mapping::Cells, true).value()).value();
        const Lattice& lattice = lattice_of(tissue);
        int moved = 0, changed = 0;
        for (std::size_t v = 0; v < inverse.vectors_mm.size(); ++v) {
            const Vec3f u = inverse.vectors_mm[v];
            if (u == Vec3f{0, 0, 0}) {
                ASSERT_EQ(fields.jacobian[v], 1.0F);
                continue;
            }
            ++moved;
            const Vec3i n = volume.grid.size;
            const Vec3d p{double(int(v) % n.x), double(int(v) / n.x % n.y),
                          double(int(v) / (n.x * n.y))};
            const Vec3d x = voxel_from_world(
                volume.grid, world_from_voxel(volume.grid, p) + Vec3d{u.x, u.y, u.z});
            // On a face either cell is correct.
            double nearest = INFINITY;
            for (int side = 0; side < 8; ++side) {
                const auto way = [&](int a) { return side >> a & 1 ? 2e-3 : -2e-3; };
                const double found = jacobian_by_differences(lattice, x, {way(0), way(1), way(2)});
                if (std::abs(found - fields.jacobian[v]) < std::abs(nearest - fields.jacobian[v]))
                    nearest = found;
            }
            ASSERT_NEAR(fields.jacobian[v], nearest, 0.02 + 0.01 * std::abs(nearest))
                << "voxel " << p.x << ' ' << p.y << ' ' << p.z;
            changed += std::abs(nearest - 1) > 0.05;
        }
        EXPECT_GT(moved, 500);
        EXPECT_GT(changed, 20);
    }
}

TEST(Sources, AnAffineMapHasItsDeterminantEverywhere) {
    Random random(21);
    const Volume volume = turned_noise(random, {20, 20, 20}, {1, 1.5, 0.7});
    // u = M·x in millimetres along the lattice's axes, so F = I + M there.
    const Mat3d m{{{0.1, 0.02, -0.03}, {0.05, -0.2, 0.01}, {0.0, 0.04, 0.3}}};
    Mat3d f = m;
    for (int a = 0; a < 3; ++a) f.columns[a][a] += 1;
    const Lattice lattice = displaced_lattice(volume, {{0, 0, 0}, {20, 20, 20}}, [&](Vec3d p) {
        return m * Vec3d{p.x, 1.5 * p.y, 0.7 * p.z};
    });
    Snapshot snapshot;
    const TaskArena arena(1);
    snapshot.take(lattice, {}, arena);
    SourceJacobian jacobian(lattice, snapshot);
    for (int n = 0; n < 200; ++n)
        EXPECT_NEAR(jacobian.at({random.real(0, 18.9), random.real(0, 18.9), random.real(0, 18.9)}),
                    determinant(f), 1e-5);
    EXPECT_EQ(jacobian.at({-8.5, 3, 3}), 1);
}

TEST(Sources, TheBitsAreTheSameForAnyNumberOfThreads) {
    const auto fields_with = [](int threads) {
        Random random(31);
        const TaskArena arena(threads);
        const Volume volume = turned_noise(random, {40, 36, 30}, {1, 1, 1.2});
        ChainMail tissue = tissue_of(volume, arena);
        LiveDeformation live = LiveDeformation::create(tissue).value();
        EXPECT_TRUE(live.keep_sources(true));
        for (int push = 0; push < 6; ++push) {
            EXPECT_TRUE(tissue.push(random_push(random, volume.grid, 9)).ok());
            (void)live.update();
        }
        return fields_of(live);
    };
    const Fields one = fields_with(1);
    EXPECT_GT(*std::max_element(one.displacement_mm.begin(), one.displacement_mm.end()), 1.0F);
    EXPECT_EQ(fields_with(2), one);
    EXPECT_EQ(fields_with(4), one);
}

TEST(Sources, WhatIsAtRestAgainHasNotMovedAndWhatIsGivenUpBeginsAnew) {
    Random random(41);
    const TaskArena arena(2);
    const Volume volume = turned_noise(random, {32, 32, 32}, {1, 1, 1});
    ChainMail tissue = tissue_of(volume, arena);
    LiveDeformation live = LiveDeformation::create(tissue).value();
    ASSERT_TRUE(live.keep_sources(true));
    ASSERT_TRUE(
        tissue
            .push({.point_mm = world_from_voxel(volume.grid, {16, 16, 16}), .push_mm = {4, 1, -2}})
            .ok());
    (void)live.update();
    const Fields pushed = fields_of(live);
    EXPECT_GT(*std::max_element(pushed.displacement_mm.begin(), pushed.displacement_mm.end()), 4);
    EXPECT_FALSE(live.keep_sources(false));
    EXPECT_FALSE(live.keeps_sources());
    ASSERT_TRUE(live.keep_sources(true));
    EXPECT_EQ(fields_of(live), pushed);
    EXPECT_TRUE(live.update().value().boxes.empty());
    tissue.reset();
    (void)live.update();
    const Fields still = fields_of(live);
    EXPECT_EQ(still.displacement_mm, std::vector<float>(still.displacement_mm.size(), 0));
    EXPECT_EQ(still.jacobian, std::vector<float>(still.jacobian.size(), 1));
    EXPECT_EQ(live.volume().voxels, volume.voxels);
}

}  // namespace
}  // namespace pliant::test
