// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>

#include "collision.h"
#include "page.h"
#include "plot.h"

namespace collision {
namespace {

using namespace pliant;
using namespace pliant::results;

// Of one frame [mm]; the picture's y points down, as LPS does in an axial section.
constexpr double kLeft = -3, kRight = 66, kTop = -3, kBottom = 49;
constexpr double kPixels = 6.5;  // for 1 mm
constexpr int kMarginLeft = 64, kMarginTop = 10, kMarginBottom = 44, kMarginRight = 8;

struct Colours {
    Rgb8 box, edge;
};
constexpr Colours kColours[] = {{{176, 205, 236}, kBlue}, {{244, 196, 178}, {190, 110, 84}}};
constexpr Rgb8 kFixedBox{170, 120, 104}, kMet{200, 20, 30}, kGrabbed{30, 60, 110};
const Ink kAsked{kDark, 2}, kDone{kGreen, 4};

Plot sheet() {
    const double width = kPixels * (kRight - kLeft), height = kPixels * (kBottom - kTop);
    return Plot(int(width) + kMarginLeft + kMarginRight, int(height) + kMarginTop + kMarginBottom,
                {kLeft - kMarginLeft / kPixels, kTop - kMarginTop / kPixels},
                {kRight + kMarginRight / kPixels, kBottom + kMarginBottom / kPixels});
}

void draw_axes(Plot& plot) {
    for (int x = 0; x <= 60; x += 10) {
        plot.line({double(x), kTop}, {double(x), kBottom}, {kFaint, 1});
        plot.text({double(x), kBottom + 2.2}, std::to_string(x));
    }
    for (int y = 0; y <= 40; y += 10) {
        plot.line({kLeft, double(y)}, {kRight, double(y)}, {kFaint, 1});
        plot.text({kLeft - 1.2, double(y)}, std::to_string(y), kText_px, kDark, Align::Right);
    }
    plot.text({0.5 * (kLeft + kRight), kBottom + 5.2}, "x [mm]");
    plot.text({kLeft - 9.4, kTop + 1}, "y [mm]", kText_px, kDark, Align::Left);
    const Point2 corners[] = {{kLeft, kTop}, {kRight, kTop}, {kRight, kBottom}, {kLeft, kBottom}};
    plot.polyline(corners, {kDark, 1}, true);
    const Point2 wall[] = {{kLeft, kTop}, {kWall_mm, kTop}, {kWall_mm, kBottom}, {kLeft, kBottom}};
    plot.polygon(wall, {120, 124, 130});
}

std::array<Point2, 4> box_of(const Element& e) {
    return {{{e.x_mm - 0.5, e.y_mm - 0.5},
             {e.x_mm + 0.5, e.y_mm - 0.5},
             {e.x_mm + 0.5, e.y_mm + 0.5},
             {e.x_mm - 0.5, e.y_mm + 0.5}}};
}

/// Boxes of all elements, and the links between neighbours.
void draw_object(Plot& plot, const std::vector<Element>& elements, const Colours& colours) {
    for (const Element& e : elements) plot.polygon(box_of(e), e.fixed ? kFixedBox : colours.box);
    for (const Element& a : elements)
        for (const Element& b : elements) {
            const Vec3i d = b.ijk - a.ijk;
            if (d == Vec3i{1, 0, 0} || d == Vec3i{0, 1, 0})
                plot.line({a.x_mm, a.y_mm}, {b.x_mm, b.y_mm}, {colours.edge, 1});
        }
}

void draw_marks(Plot& plot, const Frame& frame) {
    const auto is = [&](const std::vector<Vec3i>& list, Vec3i e) {
        return std::find(list.begin(), list.end(), e) != list.end();
    };
    const ObjectPushReport& report = frame.report;
    for (int object = 0; object < 2; ++object)
        for (const Element& e : frame.objects[std::size_t(object)]) {
            if (object == frame.pushed && is(frame.grabbed, e.ijk))
                plot.dot({e.x_mm, e.y_mm}, 2.2, kGrabbed);
            if ((object == frame.pushed && e.ijk == report.element) ||
                (object == report.object && e.ijk == report.other_element))
                plot.polygon(box_of(e), kMet);
        }
    const Vec3d from = frame.start_mm, done = from + report.push.step_fraction * frame.push_mm,
                asked = from + frame.push_mm;
    plot.line({from.x, from.y}, {done.x, done.y}, kDone);
    plot.arrow({done.x, done.y}, {asked.x, asked.y}, kAsked);
}

Image panel(const Frame& frame) {
    Plot plot = sheet();
    draw_axes(plot);
    for (std::size_t n = 0; n < frame.objects.size(); ++n)
        draw_object(plot, frame.objects[n], kColours[n]);
    std::string title = frame.title;
    if (frame.pushed >= 0) {
        draw_marks(plot, frame);
        const PushReport& push = frame.report.push;
        const double whole = norm(frame.push_mm);
        title += ", " + fixed_text(push.step_fraction * whole, 1) + " of " + fixed_text(whole, 1) +
                 " mm, meets " +
                 (frame.report.wall >= 0         ? "wall"
                  : frame.report.object == kRing ? "ring"
                                                 : "tissue");
    }
    return captioned(plot.image(), title);
}

/// A panel with the legend in its upper left part.
Image legend_panel(int width, int height) {
    using enum LegendEntry::Mark;
    const LegendEntry entries[] = {{"ring: free, links ±30 %", {kColours[kRing].box, 8}, Box},
                                   {"tissue: links ±30 %", {kColours[kTissue].box, 8}, Box},
                                   {"fixed elements of the tissue", {kFixedBox, 8}, Box},
                                   {"wall", {{120, 124, 130}, 8}, Box},
                                   {"elements that the tool holds", {kGrabbed, 2.2}, Dot},
                                   {"boxes that met", {kMet, 8}, Box},
                                   {"push, the part that was done", kDone, Line},
                                   {"push, the rest", kAsked, Line}};
    Image panel{width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height), kPaper)};
    int top = 60;
    for (const LegendEntry& entry : entries) {
        const Image line = legend_of(std::span(&entry, 1), width);
        for (int y = 0; y < line.height && top + y < height; ++y)
            std::copy_n(line.pixels.begin() + std::ptrdiff_t(y) * width, width,
                        panel.pixels.begin() + std::ptrdiff_t(top + y) * width);
        top += line.height;
    }
    return panel;
}

}  // namespace

Image picture_of(const std::vector<Frame>& frames) {
    std::vector<Image> panels;
    for (const Frame& frame : frames) panels.push_back(panel(frame));
    panels.push_back(legend_panel(panels[0].width, panels[0].height));
    std::vector<Image> rows;
    for (std::size_t n = 0; n + 1 < panels.size(); n += 2)
        rows.push_back(row_of(std::span(panels).subspan(n, 2)));
    return column_of(rows);
}

}  // namespace collision
