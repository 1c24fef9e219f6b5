// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cases of small scans, against the oracle, and the scores of registrations whose error is known.
// Covers: truth/*.cpp.

#include <gtest/gtest.h>
#include <pliant/data/truth.h>
#include <pliant/resample.h>

#include <random>

#include "support/made.h"
#include "support/random.h"
#include "truth/regions.h"

namespace pliant::test {
namespace {

Volume phantom(const char* name, int size) {
    const TaskArena arena(2);
    return test::made(make_phantom({.name = name, .size = {size, size, size}}, arena)).volume;
}

std::uint64_t fresh_seed() {
    return std::random_device{}() % 1000000;
}

Vec3d centre(const Grid& grid, std::size_t n) {
    const auto nx = std::size_t(grid.size.x), ny = std::size_t(grid.size.y);
    return world_from_voxel(grid, {double(n % nx), double(n / nx % ny), double(n / nx / ny)});
}

const VoxelArray<std::int16_t>& values_of(const Volume& volume) {
    return *std::get_if<VoxelArray<std::int16_t>>(&volume.voxels);
}

class Kinds : public testing::TestWithParam<const char*> {};

TEST_P(Kinds, Fields_are_inverses_at_every_voxel_with_a_counterpart) {
    const std::uint64_t seed = fresh_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("airway", 48);
    const TaskArena arena(2);
    const auto maker = TruthMaker::create(scan, {}, {.kinds = GetParam(), .motions = 2}, arena);
    ASSERT_TRUE(maker.ok());
    const auto made = maker->make(seed);
    ASSERT_TRUE(made.ok()) << made.error().message;
    EXPECT_FALSE(made->motions.empty());
    EXPECT_GT(made->max_displacement_mm, 0.1);
    EXPECT_LE(made->inverse_error_mm, 1e-4);
    EXPECT_LE(made->landmark_error_mm, 1e-4);
    std::int64_t moved = 0, exact = 0;
    for (std::size_t n = 0; n < voxel_count(scan.grid); ++n) {
        const Vec3d p = centre(scan.grid, n);
        if (values_of(made->moving_mask)[n] == std::int16_t(TruthMask::Exact)) {
            const Vec3f v = made->inverse.vectors_mm[n];
            const Vec3d from = p + Vec3d{v.x, v.y, v.z};
            if (v == Vec3f{0, 0, 0}) continue;
            ++moved;
            const auto back = made->map->moving_from_fixed(from);
            ASSERT_TRUE(back);
            EXPECT_LE(norm(*back - p), 1e-4);
        } else {
            EXPECT_EQ(made->inverse.vectors_mm[n], (Vec3f{0, 0, 0}));
        }
        if (values_of(made->fixed_mask)[n] == std::int16_t(TruthMask::Exact)) {
            const Vec3f u = made->forward.vectors_mm[n];
            if (u == Vec3f{0, 0, 0} || n % 7) continue;
            ++exact;
            const auto back = made->map->fixed_from_moving(p + Vec3d{u.x, u.y, u.z});
            ASSERT_TRUE(back);
            EXPECT_LE(norm(*back - p), 1e-4);
        }
    }
    EXPECT_GT(moved, 10);  // a contact may be as small as its smallest sphere
    EXPECT_GT(exact, 0);
}
INSTANTIATE_TEST_SUITE_P(All, Kinds,
                         testing::Values("contact", "slide", "cut", "interface", "breathing",
                                         "contact,slide,cut,interface,breathing"));

TEST(TruthCases, Same_bits_for_any_number_of_threads) {
    const std::uint64_t seed = fresh_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("airway", 48);
    const TaskArena one(1), two(2), four(4);
    const auto hash = [&](const TaskArena& arena, std::uint64_t s) {
        const auto maker = TruthMaker::create(scan, {}, {.motions = 4}, arena);
        EXPECT_TRUE(maker.ok());
        const auto made = maker->make(s);
        EXPECT_TRUE(made.ok());
        return made->hash;
    };
    const std::uint64_t expected = hash(one, seed);
    EXPECT_EQ(hash(two, seed), expected);
    EXPECT_EQ(hash(four, seed), expected);
    EXPECT_EQ(hash(two, seed), expected);
    EXPECT_NE(hash(two, seed + 1), expected);
}

TEST(TruthCases, The_moving_scan_is_the_fixed_one_at_the_sources) {
    const std::uint64_t seed = fresh_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("airway", 48);
    const TaskArena arena(2);
    const auto maker = TruthMaker::create(scan, {}, {}, arena);
    const auto made = maker->make(seed);
    ASSERT_TRUE(made.ok());
    for (std::size_t n = 0; n < voxel_count(scan.grid); ++n) {
        if (values_of(made->moving_mask)[n] != std::int16_t(TruthMask::Exact)) continue;
        const Vec3f v = made->inverse.vectors_mm[n];
        const Vec3d from = centre(scan.grid, n) + Vec3d{v.x, v.y, v.z};
        EXPECT_NEAR(double(values_of(made->moving)[n]),
                    double(sample_linear(scan, voxel_from_world(scan.grid, from))), 2);
    }
}

TEST(TruthCases, Bone_never_moves_and_labels_follow_the_values) {
    const std::uint64_t seed = fresh_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Volume scan = phantom("knee", 64);
    const TaskArena arena(2);
    const auto maker = TruthMaker::create(scan, {}, {.motions = 3}, arena);
    ASSERT_TRUE(maker.ok());
    const auto made = maker->make(seed);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::int64_t bone = 0;
    for (std::size_t n = 0; n < voxel_count(scan.grid); ++n) {
        const auto label = TruthLabel(values_of(made->labels)[n]);
        const int value = values_of(scan)[n];
        EXPECT_EQ(label == TruthLabel::Air, value < -500);
        EXPECT_EQ(label == TruthLabel::Bone, value > 300);
        if (label != TruthLabel::Bone) continue;
        ++bone;
        EXPECT_EQ(made->forward.vectors_mm[n], (Vec3f{0, 0, 0}));
    }
    EXPECT_GT(bone, 100);
}

TEST(TruthCases, Bad_settings_are_named) {
    const Volume scan = phantom("airway", 32);
    const TaskArena arena(1);
    EXPECT_EQ(TruthMaker::create(scan, {}, {.kinds = "contact,push"}, arena).error().field,
              "kinds");
    EXPECT_EQ(TruthMaker::create(scan, {}, {.motions = 0}, arena).error().field, "motions");
    Volume thin = scan;
    thin.grid.size = {32, 32, 4};
    thin.voxels = VoxelArray<std::int16_t>(32 * 32 * 4);
    EXPECT_EQ(TruthMaker::create(thin, {}, {}, arena).error().field, "scan");
    Volume air = scan;
    VoxelArray<std::int16_t> values(voxel_count(scan.grid));
    for (std::int16_t& v : values) v = -1000;
    air.voxels = values;
    const auto maker = TruthMaker::create(air, {}, {.kinds = "contact"}, arena);
    ASSERT_TRUE(maker.ok());
    EXPECT_EQ(maker->make(1).error().code, ErrorCode::NotFound);
}

TEST(TruthRegions, Distances_equal_those_of_brute_force) {
    const std::uint64_t seed = fresh_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Grid grid{{11, 9, 13}, {0.7, 1.3, 2.1}};
    std::vector<std::uint8_t> sources(voxel_count(grid), 0);
    for (int n = 0; n < 6; ++n) sources[std::size_t(random.whole(0, 11 * 9 * 13 - 1))] = 1;
    const TaskArena arena(2);
    const std::vector<float> found = truth::distances_mm(grid, sources, arena);
    for (std::size_t n = 0; n < found.size(); ++n) {
        double least = 1e9;
        for (std::size_t m = 0; m < found.size(); ++m)
            if (sources[m]) least = std::min(least, norm(centre(grid, n) - centre(grid, m)));
        EXPECT_NEAR(double(found[n]), least, 1e-4);
    }
    const std::vector<float> none =
        truth::distances_mm(grid, std::vector<std::uint8_t>(sources.size(), 0), arena);
    EXPECT_TRUE(std::isinf(none[17]));
}

class Scores : public testing::Test {
  protected:
    const Volume scan = phantom("airway", 48);
    const TaskArena arena{2};
    const TruthCase made = *TruthMaker::create(scan, {}, {.motions = 3}, arena)->make(5);

    static const TruthErrors& at(const TruthScore& score, TruthRow row) {
        return score.rows[std::size_t(row)];
    }
};

TEST_F(Scores, The_truth_has_no_error_at_voxels) {
    const auto score = score_field(made, made.forward, arena);
    ASSERT_TRUE(score.ok());
    for (const TruthRow row : {TruthRow::Moved, TruthRow::Still, TruthRow::Bone})
        EXPECT_EQ(at(*score, row).max_mm, 0);
    EXPECT_GT(at(*score, TruthRow::Moved).count, 100);
    EXPECT_GT(at(*score, TruthRow::Landmarks).count, 20);
    std::vector<Vec3d> points;
    for (const TruthLandmark& landmark : made.landmarks) points.push_back(landmark.moving_mm);
    const auto by_points = score_points(made, points);
    ASSERT_TRUE(by_points.ok());
    EXPECT_EQ(at(*by_points, TruthRow::Landmarks).max_mm, 0);
    EXPECT_FALSE(by_points->folded_share);
}

TEST_F(Scores, A_constant_error_is_found_everywhere) {
    VectorField found = made.forward;
    for (Vec3f& v : found.vectors_mm) v = v + Vec3f{0.3F, 0, -0.4F};
    const auto score = score_field(made, found, arena);
    ASSERT_TRUE(score.ok());
    for (const TruthRow row : {TruthRow::Moved, TruthRow::Still}) {
        EXPECT_NEAR(at(*score, row).mean_mm, 0.5, 1e-5);
        EXPECT_NEAR(at(*score, row).median_mm, 0.5, 1e-5);
        EXPECT_NEAR(at(*score, row).p95_mm, 0.5, 1e-5);
        EXPECT_NEAR(at(*score, row).max_mm, 0.5, 1e-5);
    }
}

TEST_F(Scores, Nothing_found_leaves_the_displacements) {
    const auto score = score_nothing(made, arena);
    ASSERT_TRUE(score.ok());
    VectorField zero{scan.grid, FieldKind::Resampling,
                     std::vector<Vec3f>(voxel_count(scan.grid), {0, 0, 0})};
    const auto by_field = score_field(made, zero, arena);
    ASSERT_TRUE(by_field.ok());
    for (std::size_t row = 0; row < score->rows.size(); ++row) {
        EXPECT_EQ(score->rows[row].count, by_field->rows[row].count);
        EXPECT_EQ(score->rows[row].mean_mm, by_field->rows[row].mean_mm);
    }
    EXPECT_GE(at(*score, TruthRow::Moved).median_mm, kTruthMovedMm);
    EXPECT_LT(at(*score, TruthRow::Still).max_mm, kTruthMovedMm);
}

TEST_F(Scores, Folds_are_counted) {
    VectorField found = made.forward;
    const Grid& grid = scan.grid;
    for (int k = 0; k < grid.size.z; ++k)
        for (int j = 0; j < grid.size.y; ++j)
            for (int i = 20; i < 28; ++i)  // du/dx = −2
                found.vectors_mm[voxel_index(grid, {i, j, k})].x =
                    float(-2 * grid.spacing_mm.x * (i - 24));
    const auto score = score_field(made, found, arena);
    ASSERT_TRUE(score.ok());
    std::int64_t tissue = 0;
    for (const std::int16_t label : values_of(made.labels)) tissue += label != 0;
    EXPECT_GT(score->folded_voxels, 100);
    EXPECT_NEAR(*score->folded_share, double(score->folded_voxels) / double(tissue), 1e-12);
}

TEST_F(Scores, A_field_on_another_grid_is_interpolated) {
    VectorField found{{{2, 2, 2}, {500, 500, 500}, {-250, -250, -250}},
                      FieldKind::Resampling,
                      std::vector<Vec3f>(8, {0, 0.25F, 0})};
    const auto score = score_field(made, found, arena);
    ASSERT_TRUE(score.ok());
    EXPECT_NEAR(at(*score, TruthRow::Bone).count ? at(*score, TruthRow::Bone).max_mm : 0.25, 0.25,
                1e-5);
    EXPECT_GE(at(*score, TruthRow::Still).max_mm, 0.2);
}

TEST_F(Scores, A_grid_of_32_bits_is_that_of_the_truth) {
    VectorField found = made.forward;
    for (Vec3f& v : found.vectors_mm) v = {1, 1, 1};
    const auto expected = score_field(made, found, arena);
    for (int a = 0; a < 3; ++a) {  // as NIfTI stores them
        found.grid.origin_mm[a] = float(found.grid.origin_mm[a] + 1e-6);
        found.grid.spacing_mm[a] = float(found.grid.spacing_mm[a]);
    }
    ASSERT_NE(found.grid, made.forward.grid);
    const auto score = score_field(made, found, arena);
    ASSERT_TRUE(score.ok() && expected.ok());
    for (const TruthRow row : {TruthRow::Moved, TruthRow::Still, TruthRow::Bone}) {
        EXPECT_EQ(at(*score, row).mean_mm, at(*expected, row).mean_mm);
        EXPECT_EQ(at(*score, row).max_mm, at(*expected, row).max_mm);
    }
    EXPECT_EQ(at(*score, TruthRow::Landmarks).max_mm, at(*expected, TruthRow::Landmarks).max_mm);
}

TEST_F(Scores, Bad_input_is_named) {
    EXPECT_EQ(score_points(made, {}).error().field, "points");
    VectorField found = made.forward;
    found.vectors_mm.pop_back();
    EXPECT_FALSE(score_field(made, found, arena).ok());
}

TEST(TruthErrorsOf, Percentiles_are_nearest_ranks) {
    std::vector<float> distances;
    for (int n = 100; n > 0; --n) distances.push_back(float(n));
    const TruthErrors errors = errors_of(distances);
    EXPECT_EQ(errors.count, 100);
    EXPECT_EQ(errors.mean_mm, 50.5);
    EXPECT_EQ(errors.median_mm, 50);
    EXPECT_EQ(errors.p95_mm, 95);
    EXPECT_EQ(errors.max_mm, 100);
}

}  // namespace
}  // namespace pliant::test
