// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Elastic bodies whose motion is known.

#include <gtest/gtest.h>

#include <cmath>

#include "morph/elastic_part.h"
#include "morph/parts.h"
#include "morph/shapes.h"

namespace pliant::test {
namespace {

using morph::BodyField;
using morph::ElasticSettings;
using morph::Part;

const ElasticSettings kPlain{0, 1000, 0, {0.003, 0.01, 0.03}};

Part ellipsoids(Vec3d radii_from, Vec3d centre_to, Vec3d radii_to) {
    const TaskArena arena(2);
    const Grid grid = cube_grid();
    auto parts = morph::find_parts(
        shape(grid,
              [&](Vec3d x) {
                  return in_ellipsoid(x, {0, 0, 0}, radii_from);
              }),
        shape(grid, [&](Vec3d x) { return in_ellipsoid(x, centre_to, radii_to); }), {}, arena);
    return parts.value().list.at(0);
}

TEST(ElasticPart, A_shifted_body_moves_by_the_shift) {
    const Vec3d shift{5, -2.5, 7.5};  // whole voxels: the two maps are alike
    const BodyField field = move_body(ellipsoids({60, 40, 50}, shift, {60, 40, 50}), kPlain);
    for (const Vec3d x : {Vec3d{0, 0, 0}, Vec3d{40, 10, -10}, Vec3d{-20, 25, 30}}) {
        EXPECT_LT(norm(field.at(x) - shift), 0.3);
        for (const Vec3d& column : field.gradient(x).columns) EXPECT_LT(norm(column), 0.01);
    }
}

TEST(ElasticPart, An_ellipsoid_that_grows_is_scaled_per_axis) {
    const BodyField field = move_body(ellipsoids({50, 40, 45}, {3, 0, 0}, {60, 44, 45}), kPlain);
    for (const Vec3d x : {Vec3d{0, 0, 0}, Vec3d{30, 10, -10}, Vec3d{-20, 20, 20}}) {
        const Vec3d expected{3 + 0.2 * x.x, 0.1 * x.y, 0};
        EXPECT_LT(norm(field.at(x) - expected), 0.6);
    }
}

// A bar of two materials in series has the same stress everywhere, so strains are as 1 : 10.
TEST(ElasticPart, The_soft_half_of_a_bar_is_stretched_more) {
    constexpr double kHalf = 200, kLonger = 1.1;
    const TaskArena arena(2);
    const Grid grid{{120, 16, 16}, {4, 4, 4}, {-240, -32, -32}, kIdentity3};
    const auto bar = [&](double half, bool has_halves) {
        Volume labels = shape(grid, [&](Vec3d x) {
            return std::abs(x.x) < half && std::abs(x.y) < 24 && std::abs(x.z) < 24;
        });
        auto& voxels = *std::get_if<0>(&labels.voxels);
        for (std::size_t n = 0; has_halves && n < voxels.size(); ++n)
            if (voxels[n] && grid.origin_mm.x + grid.spacing_mm.x * double(n % 120) > 0)
                voxels[n] = 2;
        return labels;
    };
    const MorphModulus moduli[] = {{2, 10}};
    const auto parts =
        morph::find_parts(bar(kHalf, true), bar(kLonger * kHalf, false), moduli, arena);
    ElasticSettings plain = kPlain;
    plain.bending_mm2 = 0;
    Part part = parts.value().list.at(0);
    const BodyField field = move_body(part, plain);
    const auto strain = [](const BodyField& f, double x) {
        return f.gradient({x, 0, 0}).columns[0].x;
    };
    part.moduli.clear();
    const BodyField uniform = move_body(part, plain);
    const double soft = strain(field, -100), stiff = strain(field, 100);
    EXPECT_NEAR(soft / stiff, 10, 1);
    EXPECT_NEAR(0.5 * (soft + stiff), strain(uniform, 0), 0.01);
    EXPECT_NEAR(strain(uniform, -100), strain(uniform, 100), 0.002);
}

TEST(ElasticPart, The_gradient_is_that_of_the_field) {
    ElasticSettings prior = kPlain;
    prior.back = 1;
    const BodyField field = move_body(ellipsoids({50, 40, 45}, {3, 0, 0}, {60, 44, 50}), prior);
    constexpr double h = 1e-3;
    for (const Vec3d x : {Vec3d{0, 0, 0}, Vec3d{30, 10, -10}}) {
        const Mat3d g = field.gradient(x);
        for (int a = 0; a < 3; ++a) {
            Vec3d step{0, 0, 0};
            step[a] = h;
            const Vec3d slope = (0.5 / h) * (field.at(x + step) - field.at(x - step));
            EXPECT_LT(norm(slope - g.columns[a]), 1e-5);
        }
    }
}

TEST(ElasticPart, The_back_of_a_lung_that_grows_expands_more_whichever_way_it_lies) {
    const Part part = ellipsoids({50, 40, 45}, {0, 0, 0}, {56, 45, 50});
    ElasticSettings prior = kPlain;
    const auto growth = [&](double y) {
        const Mat3d g = move_body(part, prior).gradient({0, y, 0});
        return g.columns[0].x + g.columns[1].y + g.columns[2].z;
    };
    prior.back = 1;
    const double back = growth(20), front = growth(-20);
    EXPECT_GT(back, front + 0.03);
    prior.back = -1;
    EXPECT_NEAR(growth(-20), back, 0.03);
    EXPECT_NEAR(growth(20), front, 0.03);
    prior.back = 0;
    EXPECT_NEAR(growth(20), growth(-20), 0.02);
}

}  // namespace
}  // namespace pliant::test
