// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pictures of surfaces from outside, and outlines of tools.

#include <gtest/gtest.h>
#include <pliant/view/surface_view.h>

#include <cmath>
#include <limits>
#include <vector>

#include "render/analytic_volumes.h"

namespace pliant {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

Rgb8 at(const Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
}

/// A square of 40 mm at a depth y, seen from the front.
std::vector<Vec3d> square(double y, double half = 20) {
    return {{-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}};
}
const Triangles kSquare{{0, 1, 2}, {0, 2, 3}};
const SurfaceView kFront{.look = {0, 1, 0}};

TEST(SurfaceView, TheNearerSurfaceHidesTheFartherInAnyOrder) {
    const auto near = square(0), far = square(10);
    const DrawnSurface red{.nodes_mm = near, .triangles = kSquare, .colour = {200, 0, 0}};
    const DrawnSurface green{.nodes_mm = far, .triangles = kSquare, .colour = {0, 200, 0}};
    const Image a = surface_view(std::array{red, green}, {}, kFront, 120, 100);
    const Image b = surface_view(std::array{green, red}, {}, kFront, 120, 100);
    EXPECT_EQ(a.pixels, b.pixels);
    ASSERT_EQ(a.width, 120);
    ASSERT_EQ(a.height, 100);
    EXPECT_GT(at(a, 60, 40).r, 100);
    EXPECT_EQ(at(a, 60, 40).g, 0);
    EXPECT_EQ(at(a, 2, 2), at(a, 117, 2));  // the sheet
}

TEST(SurfaceView, ATranslucentSurfaceShowsTheWireBehindItAndHasNoSeams) {
    const auto wall = square(0);
    const std::vector<Vec3d> wire{{-10, 5, 0}, {10, 5, 0}};
    DrawnSurface drawn{
        .nodes_mm = wall, .triangles = kSquare, .colour = {0, 0, 200}, .opacity = 0.5};
    const DrawnWire yellow{.points_mm = wire, .radius_mm = 3, .colour = {250, 250, 0}};
    const Image through = surface_view({&drawn, 1}, {&yellow, 1}, kFront, 200, 200);
    EXPECT_GT(at(through, 100, 100).r, 60);
    EXPECT_EQ(at(through, 100, 60).r, at(through, 130, 60).r);
    // The diagonal between the two triangles is blended once: all pixels of a row look the same.
    for (int x = 60; x < 140; ++x) EXPECT_EQ(at(through, x, 60), at(through, 100, 60)) << x;
    drawn.opacity = 1;
    const Image hidden = surface_view({&drawn, 1}, {&yellow, 1}, kFront, 200, 200);
    EXPECT_EQ(at(hidden, 100, 100).r, 0);
}

TEST(SurfaceView, ValuesHaveTheColoursOfTheScaleAndItsEndIsMarkedWhereTheyExceedIt) {
    const auto nodes = square(0);
    const std::vector<double> low(4, 0.0), full(4, 2.0), above(4, 2.5);
    SurfaceView view = kFront;
    view.full = 2;
    view.scale = "displacement [mm]";
    const auto drawn = [&](const std::vector<double>& values) {
        const DrawnSurface s{.nodes_mm = nodes, .triangles = kSquare, .values = values};
        return surface_view({&s, 1}, {}, view, 400, 400);
    };
    const Image cold = drawn(low), warm = drawn(full), beyond = drawn(above);
    EXPECT_GT(at(cold, 200, 150).b, at(cold, 200, 150).r);
    EXPECT_GT(at(warm, 200, 150).r, 2 * at(warm, 200, 150).b);
    EXPECT_EQ(at(warm, 200, 150), at(beyond, 200, 150));
    EXPECT_NE(warm.pixels, beyond.pixels);  // "2", ">= 2"
}

TEST(SurfaceView, TheBarHasItsLength) {
    const auto nodes = square(0);
    const DrawnSurface s{.nodes_mm = nodes, .triangles = kSquare, .colour = {90, 0, 0}};
    const Image image = surface_view({&s, 1}, {}, kFront, 300, 300);
    // 40 mm fill 76 % of 300 pixels; the bar is 10 mm: a quarter of the width is 13 mm.
    int bar = 0, side = 0;
    for (int x = 0; x < 300; ++x) {
        side += at(image, x, 150).r > 60 && at(image, x, 150).g == 0;
        int high = 0;
        for (int y = 240; y < 300; ++y) high = std::max(high, int(at(image, x, y).g > 220));
        bar += high != 0 && x < 100;
    }
    EXPECT_NEAR(side, 228, 2);
    EXPECT_NEAR(bar, 57, 2);
}

TEST(SurfaceView, DamagedSurfacesAreLeftOut) {
    auto nodes = square(0);
    nodes.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
    const Triangles some{{0, 1, 2}, {0, 2, 9}, {0, -1, 2}, {0, 4, 2}};
    const DrawnSurface s{.nodes_mm = nodes, .triangles = some};
    EXPECT_EQ(surface_view({&s, 1}, {}, {}, 50, 50).pixels.size(), 2500u);
    EXPECT_EQ(surface_view({}, {}, {}, 0, 0).pixels.size(), 1u);
}

TEST(OutlineTool, DrawsTheCirclesOfTheSphereInTheSectionsThatItReaches) {
    const Volume volume =
        test::make_volume<std::int16_t>(test::plain_grid({40, 40, 40}), [](Vec3d) { return 40.0; });
    const TaskArena arena(1);
    FourUp view;
    view.section.point_mm = {20, 20, 20};
    view.section.width_mm = 40;
    view.section.crosshair = false;
    view.endoscope.eye_mm = {20, -60, 20};
    const Image plain = four_up_view(volume, view, 400, 400, arena);
    const auto changed = [&](Vec3d centre, double radius) {
        Image image = plain;
        outline_tool(image, volume, view, centre, radius);
        std::array<int, 4> count{};  // of the four pictures
        for (int y = 0; y < 400; ++y)
            for (int x = 0; x < 400; ++x)
                if (!(at(image, x, y) == at(plain, x, y)))
                    ++count[std::size_t((x >= 200) + 2 * (y >= 200))];
        return count;
    };
    const auto middle = changed({20, 20, 20}, 8);
    for (const int n : middle) EXPECT_GT(n, 100);
    EXPECT_NEAR(middle[1], middle[2], 20);  // three circles of one size
    EXPECT_NEAR(middle[1], middle[3], 20);
    const auto above = changed({20, 20, 32}, 8);  // beyond the axial section
    EXPECT_EQ(above[1], 0);
    EXPECT_GT(above[2], 100);
    const auto point = changed({20, 20, 20}, 0);
    EXPECT_EQ(point[0], 0);
    EXPECT_GT(point[1], 10);
    EXPECT_LT(point[1], 100);
}

}  // namespace
}  // namespace pliant
