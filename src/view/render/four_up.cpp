// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Combined pictures.
//
//   endoscope │ axial
//   ──────────┼─────────
//   coronal   │ sagittal

#include <pliant/core/text.h>
#include <pliant/data/scan_values.h>
#include <pliant/view/surface_view.h>

#include <cmath>

#include "base/hypot.h"
#include "render/camera.h"
#include "render/section.h"
#include "render/volume_or_air.h"
#include "volume/value_unit.h"

namespace pliant {
namespace {

using render::Pixel;

constexpr Rgb8 kSeparator{70, 70, 74};
constexpr Rgb8 kInk{235, 235, 235};

/// Digits behind the point for values under a window of this width.
int digits_of(double window) {
    return window < 10 ? 3 : 0;
}

int label_scale(int panel_height) {
    return std::max(1, (panel_height + 8) / 256);
}

/// @param line  0: the top line
void label_top(Image& panel, const std::string& text, Rgb8 colour, int line = 0) {
    const int scale = label_scale(panel.height);
    render::draw_text(panel, {4 * scale, (4 + line * (render::kGlyphHeight + 4)) * scale}, text,
                      colour, scale);
}

void label_bottom(Image& panel, const std::string& text) {
    const int scale = label_scale(panel.height);
    render::draw_text(panel, {4 * scale, panel.height - (5 + render::kGlyphHeight) * scale}, text,
                      kInk, scale);
}

Image section_panel(const Volume& volume, Section section, Orientation orientation, int width,
                    int height, const TaskArena& arena) {
    section.orientation = orientation;
    Image panel = section_view(volume, section, width, height, arena);
    const render::SectionStyle style = render::section_style(orientation);
    const int axis = style.axis - 'x';
    label_top(panel, style.name, style.colour);
    std::string label{style.axis, ' '};
    label += fixed_text(section.point_mm[axis], length_scale(volume.grid) < 0.1 ? 3 : 1);
    label_top(panel, label + " mm", style.colour, 1);
    const int digits = digits_of(section.window_hu);
    label_bottom(panel, "W " + fixed_text(section.window_hu, digits) + "  L " +
                            fixed_text(section.level_hu, digits));
    return panel;
}

/// The four pictures in the picture.
struct Panels {
    int line, left, top, right, bottom;  ///< [pixels]: the gap, widths and heights

    Panels(int width, int height)
        : line(std::max(1, std::min(width, height) / 512)),
          left(std::max(1, (width - line) / 2)),
          top(std::max(1, (height - line) / 2)),
          right(std::max(1, width - line - left)),
          bottom(std::max(1, height - line - top)) {}

    /// Calls body(orientation, width, height, corner) for each section.
    template <class Body>
    void for_each_section(const Body& body) const {
        body(Orientation::Axial, right, top, Pixel{left + line, 0});
        body(Orientation::Coronal, left, bottom, Pixel{0, top + line});
        body(Orientation::Sagittal, right, bottom, Pixel{left + line, top + line});
    }
};

constexpr Rgb8 kTool{255, 190, 60};

/// Outlines the pixels for which is_in(x, y) holds, in a panel.
template <class IsIn>
void outline(Image& all, Pixel corner, int width, int height, const IsIn& is_in) {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool in = is_in(x, y);
            if (in != is_in(x + 1, y) || in != is_in(x, y + 1))
                render::fill_box(all, {corner.x + x, corner.y + y},
                                 {std::min(corner.x + x + 2, corner.x + width),
                                  std::min(corner.y + y + 2, corner.y + height)},
                                 kTool, 0.9);
        }
}

}  // namespace

void outline_tool(Image& picture, const Volume& scan, const FourUp& settings, Vec3d centre_mm,
                  double radius_mm) {
    const Volume& volume = render::volume_or_air(scan);
    const Panels panels(picture.width, picture.height);
    const Endoscope& endoscope = settings.endoscope;
    const Vec3d way = centre_mm - endoscope.eye_mm;
    if (radius_mm > 0 && norm(way) > radius_mm) {
        const render::Camera camera(endoscope, panels.left, panels.top);
        outline(picture, {0, 0}, panels.left, panels.top, [&](int x, int y) {
            const double along = dot(way, camera.direction(x + 0.5, y + 0.5));
            return along > 0 && dot(way, way) - along * along < radius_mm * radius_mm;
        });
    }
    panels.for_each_section([&](Orientation orientation, int width, int height, Pixel corner) {
        constexpr double kPoint_mm = 1, kPoint_px = 4;
        Section section = settings.section;
        section.orientation = orientation;
        const render::SectionPlane plane(volume.grid, section, width, height);
        const int axis = render::section_style(orientation).axis - 'x';
        const double off = centre_mm[axis] - section.point_mm[axis];
        const double inside = radius_mm * radius_mm - off * off;
        const double radius_px = inside > 0 ? std::sqrt(inside) / plane.mm_per_pixel()
                                 : radius_mm == 0 && std::abs(off) < kPoint_mm ? kPoint_px
                                                                               : 0;
        if (radius_px == 0) return;
        const Pixel at = plane.pixel_of(centre_mm);
        outline(picture, corner, width, height,
                [&](int x, int y) { return hypot(x - at.x, y - at.y) < radius_px; });
    });
}

Image four_up_view(const Volume& scan, const FourUp& settings, int width, int height,
                   const TaskArena& arena) {
    const Volume& volume = render::volume_or_air(scan);
    Image all = render::make_image(width, height, kSeparator);
    const Panels panels(all.width, all.height);
    Image view =
        RayCaster(volume, arena).endoscope_view(settings.endoscope, panels.left, panels.top);
    label_top(view, "endoscope", kInk);
    label_top(view,
              "iso " +
                  fixed_text(settings.endoscope.iso_hu, digits_of(settings.section.window_hu)) +
                  value_unit(scan),
              kInk, 1);
    if (!settings.caption.empty()) label_bottom(view, settings.caption);
    render::paste(all, view, {0, 0});

    panels.for_each_section([&](Orientation orientation, int w, int h, Pixel at) {
        render::paste(all, section_panel(volume, settings.section, orientation, w, h, arena), at);
    });
    return all;
}

Image side_by_side(const Image& left, const Image& right) {
    const int line = std::max(2, std::max(left.height, right.height) / 256);
    Image all = render::make_image(left.width + line + right.width,
                                   std::max(left.height, right.height), kSeparator);
    render::paste(all, left, {0, 0});
    render::paste(all, right, {left.width + line, 0});
    return all;
}

}  // namespace pliant
