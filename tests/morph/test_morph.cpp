// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The whole: known motions, random points without folds, fields, errors.
// Covers: morph/morph.cpp, morph/settings_rows.cpp.

#include <gtest/gtest.h>
#include <pliant/data/morph.h>
#include <pliant/resample.h>

#include <random>
#include <string>
#include <vector>

#include "morph/shapes.h"
#include "support/random.h"

namespace pliant::test {
namespace {

struct Pairs {
    std::vector<Vec3d> from, to;
    MorphInput input() const { return {.from_mm = from, .to_mm = to}; }
};

TEST(Morph, Affine_motions_of_points_are_exact) {
    Random random(1);
    Pairs pairs;
    const Mat3d slope{{random.vector(0.2), random.vector(0.2), random.vector(0.2)}};
    for (int n = 0; n < 20; ++n) {
        pairs.from.push_back(random.vector(60));
        pairs.to.push_back(pairs.from.back() + Vec3d{3, 4, 5} + slope * pairs.from.back());
    }
    const auto morph = Morph::create(pairs.input(), {}, TaskArena(2));
    ASSERT_TRUE(morph.ok()) << morph.error().message;
    for (int n = 0; n < 20; ++n) {
        const Vec3d x = random.vector(40);
        EXPECT_LT(norm(morph->forward(x) - (x + Vec3d{3, 4, 5} + slope * x)), 1e-6);
        EXPECT_LT(norm(morph->inverse(morph->forward(x)) - x), 1e-6);
    }
    EXPECT_LT(morph->report().point_residual_mm, 1e-6);
    EXPECT_EQ(morph->report().points, 20);
    EXPECT_EQ(morph->report().softened, 0);
    Mat3d f = slope;
    for (int a = 0; a < 3; ++a) f.columns[a][a] += 1;
    EXPECT_LE(morph->report().least_volume, determinant(f) + 1e-9);
}

TEST(Morph, Random_points_that_cross_give_a_map_without_folds) {
    const std::uint64_t seed = std::uint64_t(std::random_device{}());
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const TaskArena arena(2);
    int softened = 0;
    for (int n = 0; n < 3; ++n) {
        Pairs pairs;
        const double size = n < 2 ? 15 : 60;
        for (int m = 0; m < 40; ++m) {
            pairs.from.push_back(random.vector(50));
            pairs.to.push_back(pairs.from.back() + random.vector(size));
        }
        const auto morph = Morph::create(pairs.input(), {.point_softness_mm = 0.01}, arena);
        ASSERT_TRUE(morph.ok()) << morph.error().message;
        EXPECT_GE(morph->report().least_volume, 0.05);
        softened += morph->report().softened > 0;
        for (int m = 0; m < 60; ++m) {
            const Vec3d x = random.vector(70);
            EXPECT_LT(norm(morph->inverse(morph->forward(x)) - x), 1e-5);
            EXPECT_LT(norm(morph->forward(morph->inverse(x)) - x), 1e-5);
        }
    }
    EXPECT_GT(softened, 0);
}

TEST(Morph, Points_that_mirror_the_inside_are_refused) {
    Random random(2);
    Pairs pairs;
    for (int m = 0; m < 20; ++m) {
        pairs.from.push_back(random.vector(50));
        pairs.to.push_back({-pairs.from.back().x, pairs.from.back().y, pairs.from.back().z});
    }
    const auto morph = Morph::create(pairs.input(), {}, TaskArena(1));
    ASSERT_FALSE(morph.ok());
    EXPECT_EQ(morph.error().field, "to_mm");
}

/// An ellipsoid that is shifted by whole voxels, and points in it.
struct Shifted {
    Volume from, to;
    Vec3d shift{7.5, -5, 2.5};
    Pairs pairs;

    explicit Shifted(int points) {
        const Grid grid = cube_grid();
        from = shape(grid, [](Vec3d x) { return in_ellipsoid(x, {-5, 0, 0}, {55, 40, 50}); });
        to = shape(grid, [&](Vec3d x) {
            return in_ellipsoid(x - shift, {-5, 0, 0}, {55, 40, 50});
        });
        Random random(3);
        for (int n = 0; n < points; ++n) {
            pairs.from.push_back(random.vector(30));
            pairs.to.push_back(pairs.from.back() + shift);
        }
    }
    MorphInput input() const {
        return {.from_mm = pairs.from, .to_mm = pairs.to, .from = &from, .to = &to};
    }
};

TEST(Morph, Shifted_maps_give_the_shift_with_points_and_without) {
    const TaskArena arena(2);
    for (const int points : {0, 1, 12}) {
        const Shifted s(points);
        const auto morph = Morph::create(s.input(), {}, arena);
        ASSERT_TRUE(morph.ok()) << morph.error().message;
        EXPECT_EQ(morph->report().parts, 1);
        EXPECT_FALSE(morph->report().has_prior);
        EXPECT_LT(morph->report().surface_residual_mm, 0.2);
        Random random(4);
        for (int n = 0; n < 20; ++n) {
            const Vec3d x = random.vector(30);
            EXPECT_LT(norm(morph->forward(x) - x - s.shift), 0.4);
        }
    }
}

TEST(Morph, Fields_are_the_map_and_its_inverse) {
    const TaskArena arena(2);
    const Shifted s(12);
    Pairs bent = s.pairs;
    for (std::size_t n = 0; n < bent.to.size(); ++n) bent.to[n].x += double(n % 3);
    MorphInput input = s.input();
    input.to_mm = bent.to;
    const auto morph = Morph::create(input, {}, arena);
    ASSERT_TRUE(morph.ok());
    const auto forward = morph->forward_field(s.from.grid, arena);
    const auto back = morph->inverse_field(s.to.grid, arena);
    ASSERT_TRUE(forward.ok() && back.ok());
    EXPECT_EQ(forward->kind, FieldKind::Modeling);
    EXPECT_EQ(back->kind, FieldKind::Resampling);
    Random random(5);
    for (int n = 0; n < 200; ++n) {
        // Nodes lie at voxels, so the written field is the map between voxels as well.
        const Vec3d x = random.vector(55);
        EXPECT_LT(norm(x + sample_field(*forward, x) - morph->forward(x)), 1e-4);
        const Vec3i p{random.whole(0, 63), random.whole(0, 51), random.whole(0, 63)};
        const Vec3d y = world_from_voxel(s.to.grid, {double(p.x), double(p.y), double(p.z)});
        const Vec3f v = back->vectors_mm[voxel_index(s.to.grid, p)];
        EXPECT_LT(norm(morph->forward(y + Vec3d{v.x, v.y, v.z}) - y), 1e-4);
    }
}

TEST(Morph, Results_do_not_depend_on_threads) {
    const Shifted s(12);
    const auto one = Morph::create(s.input(), {}, TaskArena(1));
    const auto three = Morph::create(s.input(), {}, TaskArena(3));
    ASSERT_TRUE(one.ok() && three.ok());
    Random random(6);
    for (int n = 0; n < 50; ++n) {
        const Vec3d x = random.vector(80);
        EXPECT_EQ(one->forward(x), three->forward(x));
        EXPECT_EQ(one->inverse(x), three->inverse(x));
    }
}

TEST(Morph, Bad_input_is_named) {
    const TaskArena arena(1);
    const auto message = [&](const MorphInput& input, const MorphSettings& settings = {}) {
        const auto morph = Morph::create(input, settings, arena);
        return morph.ok() ? std::string("ok") : morph.error().message;
    };
    Shifted s(5);
    EXPECT_EQ(message({}), "from_mm: expected a known point or label maps, found neither");
    MorphInput input = s.input();
    input.to_mm = input.to_mm.first(4);
    EXPECT_EQ(message(input), "to_mm: expected 5 points, as of from_mm, found 4");
    input = s.input();
    input.to = nullptr;
    EXPECT_EQ(message(input), "to: expected label maps of both phases, found one");
    input = s.input();
    s.pairs.to[2].y = 1e9;
    EXPECT_EQ(message(input),
              "to_mm: expected points within 1 km of the origin, found another one at 2");
    s.pairs.to[2].y = 0;
    EXPECT_EQ(message(input, {.poisson_ratio = 0.5}).rfind("poisson_ratio: expected", 0), 0u);
    EXPECT_EQ(message(input, {.point_softness_mm = 0}).rfind("point_softness_mm: expected", 0), 0u);
    s.from.grid.spacing_mm.x = 0;
    EXPECT_EQ(message(input).rfind("from", 0), 0u) << message(input);
    const std::vector<Vec3d> many(2001, Vec3d{0, 0, 0});
    EXPECT_EQ(message({.from_mm = many, .to_mm = many}),
              "from_mm: expected at most 2000 points, found 2001");
}

TEST(Morph, One_point_is_a_shift) {
    const Pairs pairs{{{10, 20, 30}}, {{11, 22, 33}}};
    const auto morph = Morph::create(pairs.input(), {}, TaskArena(1));
    ASSERT_TRUE(morph.ok());
    EXPECT_LT(norm(morph->forward({-50, 0, 9}) - Vec3d{-49, 2, 12}), 1e-9);
}

}  // namespace
}  // namespace pliant::test
