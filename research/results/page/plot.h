// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small sheet to draw on: anti-aliased lines, dots, polygons and text in a plane with
// user-defined units.

#pragma once

#include <pliant/render.h>

#include <span>
#include <string>
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
inline constexpr Rgb8 kGreen{64, 150, 84};
inline constexpr Rgb8 kOrange{222, 140, 40};

inline constexpr double kText_px = 10;  ///< height of capitals in names, numbers and legends
/// Width of a text. @param height_px  of its capitals
double text_width_px(std::string_view text, double height_px = kText_px);

/// Alignment of a text to its point, which is at half the height of its capitals.
enum class Align { Left, Middle, Right };

/// Scale from pale to dark with growing t in 0…1, for displacements.
Rgb8 shade_of(double t);

class Plot {
  public:
    /// @param low, high  coordinates of the picture's top left and bottom right corners
    Plot(int width, int height, Point2 low, Point2 high, Rgb8 background = kPaper);
    /// Draws over a picture in its own pixels.
    explicit Plot(Image picture);

    const Image& image() const { return m_image; }
    Point2 pixel_of(Point2 p) const;
    Point2 point_of(Point2 pixel) const;

    /// Mixes a colour into one pixel; pixels outside of the picture are ignored.
    void dab(int x, int y, Rgb8 colour, double opacity);
    void line(Point2 from, Point2 to, const Ink& ink);
    /// Leaves out every second piece of a given length [pixels].
    void dashed_line(Point2 from, Point2 to, const Ink& ink, double dash_px);
    void polyline(std::span<const Point2> points, const Ink& ink, bool closed = false);
    void dot(Point2 centre, double radius_px, Rgb8 colour, double opacity = 1);
    /// Fills pixels whose centre lies inside; neighbours with a common edge leave no seam.
    void polygon(std::span<const Point2> corners, Rgb8 colour);
    void arrow(Point2 from, Point2 to, const Ink& ink);
    /// Draws UTF-8 text; '?' replaces characters that are not in the font.
    void text(Point2 at, std::string_view text, double height_px = kText_px, Rgb8 colour = kDark,
              Align align = Align::Middle);
    /// A bar with its length, in the lower left corner. @param length  in the plot's units
    void scale_bar(double length, std::string_view text, Rgb8 colour = kDark);

  private:
    Image m_image;
    Point2 m_low, m_scale;
};

/// Pictures of equal height in a row, with white gaps.
Image row_of(std::span<const Image> pictures, int gap_px = 12);
/// Pictures of equal width in a column, with white gaps.
Image column_of(std::span<const Image> pictures, int gap_px = 12);
/// The picture with a line of text above it.
Image captioned(const Image& picture, std::string_view text);

/// An entry of a legend: a short line, a dot, or both.
struct LegendEntry {
    std::string text;
    Ink ink;
    enum class Mark { Line, LineAndDot, Dashes, Dot, Box } mark = Mark::Line;
};
/// The entries in the necessary number of lines.
Image legend_of(std::span<const LegendEntry> entries, int width);
/// The colours of shade_of with the ends of their scale.
/// @param darkest  value of the darkest colour. @param name  with its unit
/// @param largest  of the picture's values: beyond `darkest`, the end is marked "≥"
Image shade_bar(double darkest, int decimals, std::string_view name, double largest = 0);

}  // namespace pliant::results
