// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small sheet to draw on: anti-aliased lines, dots, polygons and numbers in a plane of the
// caller's own units. Titles and labels belong in the page that shows the picture.

#pragma once

#include <pliant/render.h>

#include <span>
#include <string_view>
#include <vector>

namespace pliant::results {

struct Point2 {
    double x, y;
};

struct Ink {
    Rgb8 colour{40, 44, 52};
    double width_px = 1;
    double opacity = 1;
};

inline constexpr Rgb8 kPaper{255, 255, 255};
inline constexpr Rgb8 kFaint{214, 218, 224};
inline constexpr Rgb8 kDark{40, 44, 52};
inline constexpr Rgb8 kBlue{38, 110, 190};
inline constexpr Rgb8 kRed{200, 66, 48};

/// From pale to dark with growing t in 0…1; for amounts of displacement.
Rgb8 shade_of(double t);

class Plot {
  public:
    /// @param low, high  what is drawn at the picture's top left and bottom right corners
    Plot(int width, int height, Point2 low, Point2 high, Rgb8 background = kPaper);

    const Image& image() const { return m_image; }
    Point2 pixel_of(Point2 p) const;
    Point2 point_of(Point2 pixel) const;

    /// Mixes a colour into one pixel; outside of the picture nothing happens.
    void dab(int x, int y, Rgb8 colour, double opacity);
    void line(Point2 from, Point2 to, const Ink& ink);
    /// Every second piece of a given length [pixels] is left out.
    void dashed_line(Point2 from, Point2 to, const Ink& ink, double dash_px);
    void polyline(std::span<const Point2> points, const Ink& ink, bool closed = false);
    void dot(Point2 centre, double radius_px, Rgb8 colour, double opacity = 1);
    /// Pixels whose centre lies inside; neighbours with a common edge leave no seam.
    void polygon(std::span<const Point2> corners, Rgb8 colour);
    /// Digits, point and minus; the text's middle is at a place.
    void number(Point2 centre, std::string_view digits, double height_px, Rgb8 colour = kDark);

  private:
    Image m_image;
    Point2 m_low, m_scale;
};

/// Pictures of equal height in a row, with white between them.
Image row_of(std::span<const Image> pictures, int gap_px = 12);

}  // namespace pliant::results
