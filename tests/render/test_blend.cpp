// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/analytic_volumes.h"
#include "render/blend.h"
#include "render/colour.h"

namespace pliant {
namespace {

using test::centre_mm;
using test::make_volume;
using test::odd_grid;
using test::plain_grid;
using test::random_unit;

TEST(Blend, DimsThroughASlabAsBeerAndLambertSay) {
    // A uniform value: the path length is the ray's part inside of the grid's border.
    TaskArena arena(1);
    const auto slab =
        make_volume<std::int16_t>(plain_grid({31, 60, 60}), [](Vec3d) { return 100; });
    const render::VolumeRays rays(slab, arena);
    const TransferFunction transfer{.window_hu = 400, .level_hu = 100, .opacity_per_mm = 0.08};
    const render::Blender blender(rays, transfer);  // share of the window: 0.5
    for (int i = 0; i < 50; ++i) {
        const double slope = 0.01 * i;
        const Vec3d d = normalized({1, slope, 0.2});
        const auto seen = blender.along({-5, 10, 10}, d);
        const double length = 30 / d.x;
        EXPECT_NEAR(seen.transmittance, std::exp(-0.5 * 0.08 * length), 1e-12);
        // One colour: the light is that colour, as far as the slab is opaque.
        const double half_x = 0.5 * (render::linear_from_srgb(transfer.dim).x +
                                     render::linear_from_srgb(transfer.bright).x);
        EXPECT_NEAR(seen.light.x, half_x * (1 - seen.transmittance), 1e-12);
        EXPECT_GT(seen.light.x, seen.light.z);
    }
}

TEST(Blend, ConvergesToTheIntegralThroughARamp) {
    // Extinction that grows along the ray: ∫σ = opacity · ∫share.
    TaskArena arena(1);
    const auto ramp =
        make_volume<float>(plain_grid({101, 8, 8}, {0.5, 1, 1}), [](Vec3d p) { return 10 * p.x; });
    const render::VolumeRays rays(ramp, arena);
    const render::Blender blender(rays, {.window_hu = 400, .level_hu = 300, .opacity_per_mm = 0.1});
    const auto seen = blender.along({-1, 3, 3}, {1, 0, 0});
    // share: 0 up to 10 mm, 1 at 50 mm: the mean is a half over 40 mm.
    EXPECT_NEAR(seen.transmittance, std::exp(-0.1 * 20), 1e-4);
}

TEST(Blend, SkippingEmptyBricksChangesNoBit) {
    TaskArena arena(1);
    const Grid grid = odd_grid({70, 60, 50});
    const Vec3d c = centre_mm(grid);
    const auto volume = make_volume<std::int16_t>(grid, [&](Vec3d p) {
        return norm(p - c - Vec3d{9, 0, 0}) < 6 ? 300.0 : std::fmod(std::abs(p.x), 3.0) - 900;
    });
    const render::VolumeRays rays(volume, arena);
    const TransferFunction transfer;
    const render::Blender quick(rays, transfer), slow(rays, transfer, false);
    std::mt19937 random(62);
    int met = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec3d eye = c + 60.0 * random_unit(random);
        const Vec3d d = normalized(c + 12.0 * random_unit(random) - eye);
        const auto a = quick.along(eye, d), b = slow.along(eye, d);
        ASSERT_EQ(a.transmittance, b.transmittance) << "seed 62 ray " << i;
        ASSERT_EQ(a.light, b.light) << "seed 62 ray " << i;
        met += a.transmittance < 1;
    }
    EXPECT_GT(met, 500);
    EXPECT_LT(met, 3900);
}

TEST(Blend, ViewShowsTheBackgroundWhereThereIsNothing) {
    TaskArena arena(2);
    const auto volume = make_volume<std::int16_t>(plain_grid({30, 30, 30}), [](Vec3d p) {
        return norm(p - Vec3d{15, 15, 15}) < 8 ? 500 : -1000;
    });
    const RayCaster caster(volume, arena);
    Endoscope e;
    e.eye_mm = {15, -40, 15};
    e.fog = {10, 20, 30};
    const Image image = caster.blended_view(e, {}, 41, 41);
    EXPECT_EQ(image.pixels[0], e.fog);
    EXPECT_GT(image.pixels[20 * 41 + 20].r, 120);
}

}  // namespace
}  // namespace pliant
