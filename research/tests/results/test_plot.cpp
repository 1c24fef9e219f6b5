// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The drawing of the results' pages.
// Covers: results_page/plot.cpp.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "chart.h"
#include "glyphs.h"
#include "page.h"
#include "plot.h"
#include "slices.h"
#include "support/temporary_folder.h"

namespace pliant::results {
namespace {

Rgb8 at(const Image& image, int x, int y) {
    return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
}

/// How much ink a white picture took, in fully covered black pixels.
double ink_of(const Image& image) {
    double sum = 0;
    for (const Rgb8 p : image.pixels) sum += (255 - p.g) / 255.0;
    return sum;
}

constexpr Rgb8 kBlack{0, 0, 0};

TEST(Plot, ALineTakesAsMuchInkAsItsLengthTimesItsWidthAtAnyAngle) {
    for (int n = 0; n < 12; ++n) {
        const double angle = 0.1 + n * std::numbers::pi / 6;
        Plot plot(100, 100, {0, 0}, {100, 100});
        const Point2 to{50 + 40 * std::cos(angle), 50 + 40 * std::sin(angle)};
        plot.line({50, 50}, to, {kBlack, 3, 1});
        // The ends are round, half a disc each.
        EXPECT_NEAR(ink_of(plot.image()), 40 * 3 + std::numbers::pi * 1.5 * 1.5, 3) << n;
    }
}

TEST(Plot, NeighbouringPolygonsLeaveNoSeamAndDoNotOverlap) {
    Plot plot(40, 40, {0, 0}, {40, 40});
    const Point2 middle{17.3, 22.9}, corners[] = {{3, 2}, {37, 5}, {33, 38}, {6, 31}};
    int coloured = 0;
    for (int n = 0; n < 4; ++n) {
        Plot one(40, 40, {0, 0}, {40, 40});
        const std::array<Point2, 3> triangle = {middle, corners[n], corners[(n + 1) % 4]};
        plot.polygon(triangle, kBlack);
        one.polygon(triangle, kBlack);
        coloured += int(std::lround(ink_of(one.image())));
    }
    Plot whole(40, 40, {0, 0}, {40, 40});
    whole.polygon(corners, kBlack);
    EXPECT_EQ(plot.image().pixels, whole.image().pixels);
    EXPECT_EQ(coloured, int(std::lround(ink_of(whole.image()))));
}

TEST(Plot, WhatLiesOutsideIsLeftOut) {
    Plot plot(20, 20, {0, 0}, {20, 20});
    plot.line({-500, -30}, {-400, 90}, {kBlack, 5, 1});
    plot.dot({25, 10}, 4, kBlack);
    const std::array<Point2, 3> triangle = {{{30, 0}, {50, 9}, {30, 20}}};
    plot.polygon(triangle, kBlack);
    EXPECT_EQ(ink_of(plot.image()), 0);
}

TEST(Plot, EachCharacterOfTheFontLooksDifferentAndTheUnknownOnesAreQuestionMarks) {
    const auto drawn = [](std::string_view text) {
        Plot plot(40, 40, {0, 0}, {40, 40});
        plot.text({20, 20}, text, 18, kBlack);
        return plot.image();
    };
    std::vector<Image> seen;
    for (std::string_view all =
             "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNPQRSTUVWXYZ"  // no O: it is a 0
             ".,:;?!'+-=/%()[]<>…°×±·µ→≤≥";
         !all.empty();) {
        std::string_view rest = all;
        take_glyph(rest);
        const std::string_view character = all.substr(0, all.size() - rest.size());
        all = rest;
        const Image image = drawn(character);
        EXPECT_GT(ink_of(image), 3) << character;
        for (const Image& other : seen) EXPECT_NE(image.pixels, other.pixels) << character;
        seen.push_back(image);
    }
    EXPECT_EQ(drawn("\u1234").pixels, drawn("?").pixels);
}

TEST(Plot, ATextIsAsWideAsItSaysAndStandsWhereItIsAligned) {
    for (const Align align : {Align::Left, Align::Middle, Align::Right}) {
        Plot plot(300, 40, {0, 0}, {300, 40});
        plot.text({150, 20}, "HEIGHT [mm]", 12, kBlack, align);
        int first = 300, last = -1;
        for (int x = 0; x < 300; ++x)
            for (int y = 0; y < 40; ++y)
                if (at(plot.image(), x, y) != kPaper) first = std::min(first, x), last = x;
        const double width = text_width_px("HEIGHT [mm]", 12);
        const double left = align == Align::Left    ? 150
                            : align == Align::Right ? 150 - width
                                                    : 150 - 0.5 * width;
        EXPECT_NEAR(first, left, 2);
        EXPECT_NEAR(last, left + width, 2);
    }
}

TEST(Plot, AnArrowEndsAtItsTipAndAScaleBarHasItsLength) {
    Plot arrow(100, 40, {0, 0}, {100, 40});
    arrow.arrow({10, 20}, {90, 20}, {kBlack, 2, 1});
    EXPECT_EQ(at(arrow.image(), 86, 20), kBlack);
    EXPECT_EQ(at(arrow.image(), 92, 20), kPaper);
    EXPECT_NE(at(arrow.image(), 82, 17), kPaper);  // the head is wider than the shaft
    EXPECT_EQ(at(arrow.image(), 50, 17), kPaper);
    Plot bar(200, 60, {0, 0}, {100, 30});  // two pixels a unit
    bar.scale_bar(40, "40 mm", kBlack);
    int length = 0;
    for (int x = 0; x < 200; ++x) length += at(bar.image(), x, 47) == kBlack;
    EXPECT_NEAR(length, 80, 3);
}

TEST(Chart, CurvesEndAtTheAxesAndEachNameIsInTheLegend) {
    const Axis x{"x [mm]", 0, 10, 5}, y{"y [N]", 0, 1, 0.5, 1};
    const std::array<Point2, 2> steep = {{{0, 0}, {10, 10}}};  // leaves through the top at x = 1
    const auto coloured = [&](std::string_view name) {
        Chart chart(240, 160, x, y);
        chart.curve(steep, {kRed, 2, 1}, name);
        return chart.image();
    };
    const Image plain = coloured(""), named = coloured("a name");
    int last = 0;
    for (int row = 0; row < plain.height; ++row)
        for (int column = 0; column < plain.width; ++column)
            if (at(plain, column, row) == kRed) last = std::max(last, column);
    EXPECT_NEAR(last, 52 + 0.1 * (240 - 52 - 20), 5);
    EXPECT_GT(named.height, plain.height);
    int red = 0;
    for (int row = plain.height; row < named.height; ++row)
        for (int column = 0; column < named.width; ++column) red += at(named, column, row) == kRed;
    EXPECT_GT(red, 20);
}

TEST(Plot, ARowHasItsPicturesSideBySide) {
    const Image pictures[] = {Plot(3, 2, {0, 0}, {1, 1}, kBlack).image(),
                              Plot(4, 5, {0, 0}, {1, 1}, kBlack).image()};
    const Image row = row_of(pictures, 2);
    EXPECT_EQ(row.width, 9);
    EXPECT_EQ(row.height, 5);
    EXPECT_EQ(ink_of(row), 3 * 2 + 4 * 5);
    EXPECT_EQ(at(row, 3, 0), kPaper);
    EXPECT_EQ(at(row, 5, 0), kBlack);
}

TEST(Chart, AHistogramShowsEachClassAndTheOnesBeyondTheMarkInRed) {
    const double values[] = {1, 1, 1, 7, 50};
    const Image image = histogram(values, {"time [ms]", 0, 10, 5}, 5, 5, "limit", 200, 120);
    int blue = 0, red = 0;
    for (const Rgb8 p : image.pixels) {
        blue += p == kBlue;
        red += p == kRed;
    }
    EXPECT_GT(blue, 100);
    EXPECT_NEAR(double(red) / blue, 2.0 / 3, 0.15);
}

TEST(Contour, OfACircleAndOfASquareHaveTheDeviationsThatThePageNames) {
    PlaneField field{{0, 1, 0}, {0, 81, 0, 81}, {0.5, 0.5, 0.5}, {}};
    PlaneField square = field;
    for (int d = 0; d < 81; ++d)
        for (int a = 0; a < 81; ++a) {
            const double x = 0.5 * a - 20, y = 0.5 * d - 20;
            field.values.push_back(20 - std::hypot(x, y));
            square.values.push_back(20 - std::abs(x) - std::abs(y));
        }
    const Contour round = contour_around(field, {20, 20}, 10);
    EXPECT_NEAR(round.mean_mm, 10, 0.02);
    EXPECT_LT(round.deviation, 0.005);
    const Contour corners = contour_around(square, {20, 20}, 10);
    // Radius between 10/√2 and 10, mean (20/π)·√2·artanh(1/√2)·… ≈ 7.94.
    EXPECT_NEAR(corners.deviation, (10 - 10 / std::numbers::sqrt2) / corners.mean_mm, 0.002);
    EXPECT_NEAR(corners.deviation, 0.37, 0.005);
}

TEST(Page, AppearsWithItsPicturesOrNotAtAll) {
    const test::TemporaryFolder folder;
    {
        Page page{folder.path()};
        page.heading(2, "Title");
        page.picture("one", "a picture", Plot(4, 4, {0, 0}, {1, 1}).image());
        page.table({"a", "b"}, {{"1", grouped_text(1234567)}});
        EXPECT_FALSE(std::filesystem::exists(folder / "one.png"));
        ASSERT_TRUE(page.finish().ok());
    }
    EXPECT_EQ(test::bytes_of(folder / "README.md"),
              "## Title\n\n![a picture](one.png)\n\n| a | b |\n|---|---:|\n"
              "| 1 | 1\u202f234\u202f567 |\n");
    EXPECT_TRUE(std::filesystem::exists(folder / "one.png"));
    Page lost{folder / "missing"};
    lost.picture("one", "a picture", Plot(4, 4, {0, 0}, {1, 1}).image());
    const Status status = lost.finish();
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::Unwritable);
}

}  // namespace
}  // namespace pliant::results
