// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volumes, labels, directions and laws from a program: invalid ones are refused with a one-line
// message, and valid extreme ones work.
// Covers: chainmail/check.cpp, lattice/allowance.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include "chainmail/oracle.h"
#include "material/limit_units.h"
#include "support/broken_volumes.h"
#include "support/made.h"
#include "support/one_thread.h"

namespace pliant::test {
namespace {

/// The middle of a volume [mm, LPS].
Vec3d middle_mm(const Grid& grid) {
    return world_from_voxel(
        grid, {0.5 * (grid.size.x - 1), 0.5 * (grid.size.y - 1), 0.5 * (grid.size.z - 1)});
}

/// A push of at most 0.4 of the smallest spacing.
Push small_push(Random& random, const Grid& grid) {
    const double h = std::min({grid.spacing_mm.x, grid.spacing_mm.y, grid.spacing_mm.z});
    return {middle_mm(grid), random.vector(0.4 * h), random.whole(0, 1) ? 2 * h : 0};
}

TEST(HostVolumes, OneWithABrokenFieldIsRefusedWhereverAChainMailIsMade) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const BrokenVolume broken = broken_volume(random);
        expect_refused(ChainMail::create(broken.volume, {}, one_thread()),
                       "volume." + broken.field);
        const Volume good = good_volume(random);
        ChainMailSettings settings{.label_materials = {{.values = {1}, .along_direction = true}}};
        settings.labels = std::make_shared<const Volume>(broken.volume);
        expect_refused(ChainMail::create(good, settings, one_thread()), "labels." + broken.field);
        settings.labels = std::make_shared<const Volume>(good);
        VectorField field{good.grid, FieldKind::Modeling, std::vector<Vec3f>(3)};
        settings.directions = std::make_shared<const VectorField>(field);
        expect_refused(ChainMail::create(good, settings, one_thread()), "directions.vectors_mm");
        // Later calls, too, change nothing.
        auto tissue = made(ChainMail::create(good, {}, one_thread()));
        ChainMailSettings changed{.label_materials = {{.values = {1}}}};
        changed.labels = std::make_shared<const Volume>(broken.volume);
        EXPECT_FALSE(tissue.set_materials(changed).ok());
        EXPECT_TRUE(tissue.settings().label_materials.empty());
    }
}

TEST(HostVolumes, ThinOnesAndStrangeValuesArePushedWithinTheirLimits) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume =
            random.whole(0, 1) ? good_volume(random, 1) : volume_with_strange_values(random);
        auto labels = volume_with_strange_values(random);
        labels.grid = volume.grid;
        labels.voxels = VoxelArray<float>(std::vector<float>(
            voxel_count(volume.grid), random.whole(0, 1) ? 1 : float(kNotANumber)));
        ChainMailSettings settings{.bone_threshold_hu = 3000, .max_elements = 300'000};
        if (random.whole(0, 1)) {
            settings.label_materials = {{.values = {1}, .along_direction = true}};
            settings.labels = std::make_shared<const Volume>(labels);
            settings.directions = std::make_shared<const VectorField>(
                VectorField{volume.grid, FieldKind::Modeling,
                            std::vector<Vec3f>(voxel_count(volume.grid),
                                               {float(kNotANumber), 1, float(kInfinity)})});
        }
        auto tissue = made(ChainMail::create(volume, settings, one_thread()));
        // By elements: in the middle of a thin volume a rounded point is beside it.
        const Vec3i middle{volume.grid.size.x / 2, volume.grid.size.y / 2, volume.grid.size.z / 2};
        const auto report =
            tissue.push_elements({&middle, 1}, small_push(random, volume.grid).push_mm);
        EXPECT_TRUE(report.ok() || report.error().code == ErrorCode::LimitExceeded)
            << report.error().message;
        const LatticeState state = tissue.state();
        EXPECT_EQ(state.max_violation_mm, 0);
        EXPECT_LE(state.max_movement_mm, 20);
    }
}

ElementLimits random_limits(Random& random) {
    ElementLimits limits{.max_movement_mm = random.real(0, 30)};
    for (int b = 0; b < 3; ++b) {
        limits.compress[b] = random.whole(0, 3) ? random.ratio(1e-3, 1) : random.whole(0, 1);
        limits.stretch[b] = random.whole(0, 3) ? random.ratio(1e-3, 50) : 0;
        limits.shear[b] = random.whole(0, 3) ? random.ratio(1e-3, 50) : 0;
    }
    limits.yield = random.whole(0, 1) ? random.real(0, 1) : 0;
    if (random.whole(0, 20) == 0) limits.stretch.x = kInfinity;
    return limits;
}

/// Invalidates one number of the limits. @returns the name of its field
std::string spoil(Random& random, ElementLimits& limits) {
    const int axis = random.whole(0, 2);
    const double bad[] = {kNotANumber, -1, -1e-9, -kInfinity};
    const double wrong = bad[random.whole(0, 3)];
    switch (random.whole(0, 5)) {
        case 0:
            limits.compress[axis] = wrong;
            return "compress";
        case 1:
            limits.compress[axis] = random.ratio(1.0001, 1e9);
            return "compress";
        case 2:
            limits.stretch[axis] = wrong;
            return "stretch";
        case 3:
            limits.shear[axis] = wrong;
            return "shear";
        case 4:
            limits.max_movement_mm = wrong;
            return "max_movement_mm";
        default:
            limits.yield = random.whole(0, 1) ? wrong : random.ratio(1.0001, 1e9);
            return "yield";
    }
}

TEST(HostLaws, RandomOnesHoldAndOneNumberOutOfItsRangeIsRefusedWithItsValue) {
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const Volume volume = good_volume(random, 2);
        const ElementLimits soft = random_limits(random), hard = random_limits(random);
        const int turn = random.whole(-1024, 400);
        ChainMailSettings settings{.bounded = random.whole(0, 1) == 1,
                                   .max_elements = 100'000,
                                   .custom_law = [=](int v) { return v < turn ? soft : hard; }};
        auto tissue = made(ChainMail::create(volume, settings, one_thread()));
        const auto report = tissue.push(small_push(random, volume.grid));
        EXPECT_TRUE(report.ok() || report.error().code == ErrorCode::LimitExceeded)
            << report.error().message;
        EXPECT_EQ(tissue.state().max_violation_mm, 0);

        ElementLimits bad = hard;
        const std::string field = spoil(random, bad);
        const int from = random.whole(-32767, 32767);
        settings.custom_law = [=](int v) { return v >= from ? bad : soft; };
        const std::string where = "custom_law at value " + std::to_string(from) + ": " + field;
        expect_refused(ChainMail::create(volume, settings, one_thread()), where);
        // The existing tissue continues with its own law.
        const std::uint64_t before = tissue.hash();
        expect_refused(tissue.set_materials(settings), where);
        EXPECT_EQ(tissue.hash(), before);
    }
}

TEST(HostLaws, ALabelWhoseFactorTakesALimitOutOfItsRangeIsRefusedWithItsNumber) {
    Random random(1);
    const Volume volume = good_volume(random);
    ChainMailSettings settings{
        .label_materials = {{.values = {1}, .along_direction = true},
                            {.values = {2}, .offset = 0.5, .factor = {1, 3, 1}}}};
    Volume labels = volume;
    labels.voxels = VoxelArray<std::int16_t>(voxel_count(volume.grid));
    settings.labels = std::make_shared<const Volume>(labels);
    settings.directions = std::make_shared<const VectorField>(VectorField{
        volume.grid, FieldKind::Modeling, std::vector<Vec3f>(voxel_count(volume.grid))});
    expect_refused(ChainMail::create(volume, settings, one_thread()),
                   "[[label]] 2 at value -32767: compress.y");
    settings.label_materials[1].factor.y = 2;
    EXPECT_TRUE(ChainMail::create(volume, settings, one_thread()).ok());
    settings.label_materials[1] = {
        .values = {2}, .law = LabelLaw::Constant, .compress = {0, 0, 1.5}};
    expect_refused(ChainMail::create(volume, settings, one_thread()), "[[label]] 2 compress");
}

/// Offsets at the two ends of the range, on bounded lattices of random values, against the oracle.
TEST(Offset, ZeroIsRigidAndOneIsAWholeLinkAsTheOracleHasThem) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        for (const double offset : {0.0, 1.0}) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", offset " + std::to_string(offset));
            Random random(seed);
            Volume volume = good_volume(random, 2);
            if (random.whole(0, 1)) {  // one hard element
                std::vector<float> values(voxel_count(volume.grid), 40);
                values[0] = 1000;
                volume.voxels = values;
            }
            ChainMailSettings settings{.offset = offset,
                                       .bone_threshold_hu = 500,
                                       .max_movement_mm = 500,
                                       .bounded = true,
                                       .air_enabled = false};
            const MaterialLaw law = draeger_law(settings);
            Oracle<std::int64_t> oracle(
                volume.grid, [&](Vec3i e) { return law(int(std::lround(volume.at(e)))); }, 0);
            const std::vector<Vec3i> grabbed{
                {volume.grid.size.x - 1, volume.grid.size.y - 1, volume.grid.size.z - 1}};
            const Vec3d push_mm = random.vector(3);
            for (const ChainMailSolver solver :
                 {ChainMailSolver::Sweep, ChainMailSolver::Heap, ChainMailSolver::PlainSweep}) {
                settings.solver = solver;
                auto tissue = made(ChainMail::create(volume, settings, one_thread()));
                const auto report = made(
                    tissue.push_elements(grabbed, world_from_lattice_vector(volume.grid, push_mm)));
                EXPECT_EQ(tissue.state().max_violation_mm, 0);
                if (report.step_fraction < 1) {
                    // Held by the hard element; if all is rigid, nothing moves at all.
                    EXPECT_EQ(report.limited_by, LimitedBy::Bone);
                    EXPECT_TRUE(offset > 0 || tissue.state().moved_elements == 0);
                    continue;
                }
                auto expected = oracle;
                expected.push(grabbed, {units_from_mm(push_mm.x), units_from_mm(push_mm.y),
                                        units_from_mm(push_mm.z)});
                double worst = 0;
                expected.for_each([&](Vec3i e) {
                    const Vec3d u =
                        lattice_from_world_vector(volume.grid, tissue.displacement_mm(e));
                    for (int a = 0; a < 3; ++a)
                        worst = std::max(
                            worst,
                            std::abs(u[a] - mm_from_units(Fixed(expected.displacement(e, a)))));
                    EXPECT_TRUE(offset > 0 || norm(u - push_mm) < 1e-5);
                });
                EXPECT_LT(worst, 1e-9);
            }
        }
    }
    for (const double offset : {-0.001, 1.001, kNotANumber})
        EXPECT_FALSE(ChainMail::create({{.size = {2, 2, 2}}, VoxelArray<float>(std::size_t(8)), {}},
                                       {.offset = offset}, one_thread())
                         .ok());
}

TEST(Offset, RigidTissueWithoutABorderNeedsMoreElementsThanThereMayBe) {
    Random random(1);
    const Volume volume = good_volume(random);
    auto tissue = made(ChainMail::create(
        volume,
        {.offset = 0, .bone_threshold_hu = 3000, .max_elements = 100'000, .air_enabled = false},
        one_thread()));
    const auto report = tissue.push({middle_mm(volume.grid), {0.1, 0, 0}});
    ASSERT_FALSE(report.ok());
    EXPECT_EQ(report.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(tissue.state().moved_elements, 0);
}

}  // namespace
}  // namespace pliant::test
