// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: render/aim_endoscope.cpp, render/find_endoscope.cpp, render/lumen.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/hash.h"
#include "render/analytic_volumes.h"
#include "render/camera.h"

namespace pliant {
namespace {

using test::make_volume;
using test::plain_grid;

int brightness(const Image& image, int x, int y) {
    const Rgb8 p = image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
    return p.r + p.g + p.b;
}

/// Tissue beyond a plane y = wall_mm.
Volume wall_at(double wall_mm) {
    return make_volume<std::int16_t>(plain_grid({81, 91, 81}), [=](Vec3d p) {
        return -1000 + 1000 * std::clamp(p.y - wall_mm + 0.5, 0.0, 1.0);
    });
}

Endoscope from_the_front() {
    Endoscope e;
    e.eye_mm = {40, 2, 40};
    e.look = {0, 1, 0};
    e.up = {0, 0, 1};
    return e;
}

TEST(Camera, MapsTheEdgeToTheFieldOfViewAndBendsItByTheBarrelFormula) {
    Endoscope e = from_the_front();
    for (double k : {0.0, 0.15, 0.4}) {
        e.barrel_distortion = k;
        const render::Camera camera(e, 300, 200);
        const double edge = std::tan(e.field_of_view_deg / 2 * std::numbers::pi / 180);
        for (double r : {0.0, 0.3, 0.7, 1.0, 1.5}) {
            const Vec3d d = camera.direction(150 + 100 * r, 100);  // to the right
            EXPECT_NEAR(norm(d), 1, 1e-12);
            EXPECT_NEAR(d.x / d.y, edge * r * (1 + k * r * r), 1e-12);
            EXPECT_NEAR(d.z, 0, 1e-12);
            const Vec3d u = camera.direction(150, 100 - 100 * r);  // up
            EXPECT_NEAR(u.z / u.y, edge * r * (1 + k * r * r), 1e-12);
        }
    }
}

TEST(Camera, HasTheDirectionsOfThePixelsMiddlesRowByRow) {
    Endoscope e = from_the_front();
    e.look = {1, 2, -0.5};
    const int width = 5, height = 3;
    const render::Camera camera(e, width, height);
    const auto directions = view_directions(e, width, height);
    ASSERT_EQ(directions.size(), std::size_t(width * height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Vec3d expected = camera.direction(x + 0.5, y + 0.5);
            EXPECT_EQ(norm(directions[std::size_t(y * width + x)] - expected), 0);
        }
    EXPECT_EQ(view_directions(e, 0, -3).size(), 1u);  // as a picture, which has a pixel at least
}

TEST(Camera, PutsThePatientsLeftOnTheRightWhenItLooksToTheBackWithTheHeadUp) {
    const render::Camera camera(from_the_front(), 100, 100);
    EXPECT_GT(camera.direction(90, 50).x, 0.1);
    EXPECT_GT(camera.direction(50, 10).z, 0.1);
}

TEST(Camera, ChoosesAnUpWhereTheGivenOneIsParallel) {
    Endoscope e = from_the_front();
    e.look = {0, 0, -2};
    e.up = {0, 0, 1};
    const Vec3d d = render::Camera(e, 64, 64).direction(10, 20);
    EXPECT_TRUE(is_finite(d));
    EXPECT_NEAR(norm(d), 1, 1e-12);
}

TEST(EndoscopeView, ShowsTheWallAndFogWhereNothingIs) {
    TaskArena arena(2);
    const Volume volume = make_volume<std::int16_t>(
        plain_grid({81, 61, 81}), [](Vec3d p) { return p.y > 30 && p.x > 40.5 ? 0 : -1000; });
    Endoscope e = from_the_front();
    const Image image = RayCaster(volume, arena).endoscope_view(e, 96, 96);
    ASSERT_EQ(image.pixels.size(), 96u * 96u);
    EXPECT_EQ(image.pixels[48 * 96 + 20], e.fog);
    EXPECT_GT(brightness(image, 70, 48), 150);
    e.surface = {40, 200, 60};
    const Image green = RayCaster(volume, arena).endoscope_view(e, 96, 96);
    const Rgb8 p = green.pixels[48 * 96 + 70];
    EXPECT_GT(p.g, p.r + 40);
}

TEST(EndoscopeView, GetsDarkerWithDistanceAndWithFog) {
    TaskArena arena(2);
    Endoscope e = from_the_front();
    int before = 1000;
    for (double wall : {10.0, 20.0, 40.0, 60.0, 80.0}) {
        e.fog_distance_mm = 0;
        const Volume volume = wall_at(wall);
        const RayCaster caster(volume, arena);
        const int clear = brightness(caster.endoscope_view(e, 33, 33), 16, 16);
        EXPECT_LT(clear, before) << "wall at " << wall;
        before = clear;
        int thinner = clear;
        for (double fog : {200.0, 100.0, 50.0, 20.0}) {
            e.fog_distance_mm = fog;
            const int foggy = brightness(caster.endoscope_view(e, 33, 33), 16, 16);
            EXPECT_LT(foggy, thinner) << "wall at " << wall << " fog " << fog;
            thinner = foggy;
        }
    }
}

TEST(EndoscopeView, IsTheSameForAnyThreadCount) {
    const Volume volume = make_volume<std::int16_t>(plain_grid({60, 60, 60}), [](Vec3d p) {
        return 600 * std::sin(p.x * 0.4) * std::cos(p.y * 0.3) + 500 * std::sin(p.z * 0.35);
    });
    Endoscope e = from_the_front();
    e.eye_mm = {30, 30, 30};
    e.iso_hu = 100;
    std::uint64_t expected = 0;
    for (int threads : {1, 2, 4}) {
        TaskArena arena(threads);
        const Image image = RayCaster(volume, arena).endoscope_view(e, 133, 97);
        Hash64 hash;
        hash.add(std::span<const Rgb8>(image.pixels));
        if (threads == 1) expected = hash.value();
        EXPECT_EQ(hash.value(), expected) << threads << " threads";
    }
}

TEST(FindEndoscope, ChoosesTheTubeAndLooksAlongIt) {
    TaskArena arena(2);
    const Vec3d axis = normalized({0.1, 0.2, 1}), on_axis{50, 45, 50};
    const Volume volume = make_volume<std::int16_t>(plain_grid({100, 90, 100}), [&](Vec3d p) {
        const double r = norm(p - Vec3d{20, 45, 45});
        if (r < 14) return -850.0;                              // lung
        if (p.y < 8 || norm(p - on_axis) > 70) return -1000.0;  // air around
        if (std::abs(p.z - 50) > 42) return 40.0;               // the tube is closed at both ends
        return test::tube_hu(p, on_axis, axis, 6);
    });
    const auto e = find_endoscope(volume, -500, Polarity::Rising, arena);
    ASSERT_TRUE(e);
    const Vec3d d = e->eye_mm - on_axis;
    EXPECT_LT(norm(d - dot(d, axis) * axis), 3);
    EXPECT_LT(std::abs(dot(d, axis)), 42);
    EXPECT_GT(std::abs(dot(normalized(e->look), axis)), 0.9);
    EXPECT_GT(norm(cross(e->look, e->up)), 0.1);
    EXPECT_EQ(e->iso_hu, -500);
}

TEST(FindEndoscope, FindsABrightLumenWhenTheWallIsDarker) {
    TaskArena arena(2);
    const Vec3d axis{1, 0, 0}, on_axis{0, 20, 24};
    const Volume volume = make_volume<float>(plain_grid({70, 40, 50}), [&](Vec3d p) {
        return p.x < 3 || p.x > 66 ? 40.0 : 40 - 0.3 * (test::tube_hu(p, on_axis, axis, 5) - 40);
    });
    const auto e = find_endoscope(volume, 200, Polarity::Falling, arena);
    ASSERT_TRUE(e);
    EXPECT_LT(std::hypot(e->eye_mm.y - 20, e->eye_mm.z - 24), 2);
    EXPECT_GT(std::abs(e->look.x), 0.95);
}

TEST(FindEndoscope, PrefersGasInTheBodyToTheAirBetweenItAndTheTable) {
    TaskArena arena(2);
    // A body on a table, with a hollow of its back over the table, and gas in its belly.
    const Volume volume =
        make_volume<std::int16_t>(plain_grid({100, 75, 80}, {3, 3, 3}), [](Vec3d p) {
            const double x = p.x - 150, y = p.y - 105;
            if (std::hypot(x, y + 45) < 12 && std::abs(p.z - 120) < 35) return -1000.0;  // gas
            if (p.y > 190 && p.y < 193) return -200.0;                                   // table
            if (p.y >= 193 || x * x / 2 + y * y > 8100) return -1000.0;
            const bool hollow = std::hypot(x, p.y - 190) < 22;
            return hollow ? -1000.0 : 40.0;
        });
    const auto e = find_endoscope(volume, -500, Polarity::Rising, arena);
    ASSERT_TRUE(e);
    EXPECT_LT(std::hypot(e->eye_mm.x - 150, e->eye_mm.y - 60), 12);
}

TEST(FindEndoscope, FollowsTheSizeOfTheSpecimen) {
    TaskArena arena(2);
    for (const double scale : {1.0, 0.01}) {
        const Volume volume = make_volume<std::int16_t>(
            plain_grid({120, 60, 60}, {scale, scale, scale}), [&](Vec3d p) {
                if (std::abs(p.x / scale - 60) > 50) return 40.0;
                return test::tube_hu((1 / scale) * p, {0, 28, 33}, normalized({1, 0.1, 0}),
                                     p.x < 60 * scale ? 7 : 4);
            });
        const auto e = find_endoscope(volume, -500, Polarity::Rising, arena);
        ASSERT_TRUE(e) << scale;
        EXPECT_DOUBLE_EQ(e->fog_distance_mm, scale == 1 ? 120 : 120 * 0.012);
        const Vec3d eye = (1 / scale) * e->eye_mm, d = eye - Vec3d{0, 28, 33};
        const Vec3d axis = normalized({1, 0.1, 0});
        EXPECT_LT(norm(d - dot(d, axis) * axis), 3) << scale;
        EXPECT_LT(std::abs(eye.x - 60), 50) << scale;
        EXPECT_GT(std::abs(dot(normalized(e->look), axis)), 0.9) << scale;
    }
}

TEST(FindEndoscope, TheWholeScanIsInViewFromOutside) {
    const Volume volume =
        make_volume<float>(test::odd_grid({20, 30, 25}), [](Vec3d) { return 40.0; });
    const Endoscope e = view_of_whole(volume);
    const render::Camera camera(e, 400, 400);
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d ijk{corner & 1 ? 19.0 : 0, corner & 2 ? 29.0 : 0, corner & 4 ? 24.0 : 0};
        const Vec3d to = normalized(world_from_voxel(volume.grid, ijk) - e.eye_mm);
        EXPECT_GT(dot(to, normalized(e.look)),
                  std::cos(e.field_of_view_deg * std::numbers::pi / 360));
    }
}

TEST(FindEndoscope, FindsNothingInSolidTissue) {
    TaskArena arena(1);
    const Volume volume = make_volume<float>(plain_grid({20, 20, 20}), [](Vec3d) { return 40.0; });
    EXPECT_FALSE(find_endoscope(volume, -500, Polarity::Rising, arena));
}

TEST(AimEndoscope, SeesTheTargetFromFreeAirAgainstThePush) {
    TaskArena arena(2);
    const Vec3d axis{0, 0, 1}, on_axis{45, 45, 0};
    const Volume volume = make_volume<std::int16_t>(
        plain_grid({90, 90, 110}), [&](Vec3d p) { return test::tube_hu(p, on_axis, axis, 16); });
    const RayCaster caster(volume, arena);
    for (Vec3d side : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, normalized({1, 1, 0})}) {
        const Vec3d target = Vec3d{45, 45, 55} + 16.5 * side;
        const Endoscope e =
            aim_endoscope(volume, target, 5.0 * side, -500, Polarity::Rising, arena);
        const double distance = norm(e.eye_mm - target);
        EXPECT_GT(distance, 12);
        EXPECT_LT(distance, 46);
        EXPECT_LT(std::hypot(e.eye_mm.x - 45, e.eye_mm.y - 45), 16 - 2);  // room around it
        EXPECT_LT(dot(e.look, e.eye_mm - target), 0);
        EXPECT_GT(dot(normalized(e.look), side), 0.1);
        const auto hit = caster.first_hit(e.eye_mm, e.look, -500, Polarity::Rising);
        ASSERT_TRUE(hit);
        EXPECT_LT(norm(hit->point_mm - target), 3);
        EXPECT_GT(norm(cross(e.look, e.up)), 0.1);
    }
}

TEST(AimEndoscope, LooksAtTheTargetEvenInSolidTissue) {
    TaskArena arena(1);
    const Volume volume = make_volume<float>(plain_grid({20, 20, 20}), [](Vec3d) { return 40.0; });
    const Vec3d target{10, 10, 10};
    const Endoscope e = aim_endoscope(volume, target, {0, 0, 4}, -500, Polarity::Rising, arena);
    EXPECT_LT(norm(normalized(target - e.eye_mm) - normalized(e.look)), 1e-9);
    EXPECT_GT(e.look.z, 0);
}

}  // namespace
}  // namespace pliant
