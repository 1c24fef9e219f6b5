// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Combined pictures.
//
//   endoscope │ axial
//   ──────────┼─────────
//   coronal   │ sagittal

#include <pliant/scan_values.h>

#include <array>
#include <charconv>

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

/// Fixed-point text, independent of the locale.
std::string number(double value, int digits) {
    std::array<char, 64> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                   std::chars_format::fixed, digits);
    return end.ec == std::errc{} ? std::string(text.data(), end.ptr) : "?";
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
    std::string place{style.axis, ' '};
    place += number(section.point_mm[axis], length_scale(volume.grid) < 0.1 ? 3 : 1);
    label_top(panel, place + " mm", style.colour, 1);
    const int digits = digits_of(section.window_hu);
    label_bottom(panel, "W " + number(section.window_hu, digits) + "  L " +
                            number(section.level_hu, digits));
    return panel;
}

}  // namespace

Image four_up_view(const Volume& scan, const FourUp& settings, int width, int height,
                   const TaskArena& arena) {
    const Volume& volume = render::volume_or_air(scan);
    Image all = render::make_image(width, height, kSeparator);
    const int line = std::max(1, std::min(all.width, all.height) / 512);
    const int left = std::max(1, (all.width - line) / 2);
    const int top = std::max(1, (all.height - line) / 2);
    const int right = std::max(1, all.width - line - left);
    const int bottom = std::max(1, all.height - line - top);

    Image view = RayCaster(volume, arena).endoscope_view(settings.endoscope, left, top);
    label_top(view, "endoscope", kInk);
    label_top(view,
              "iso " + number(settings.endoscope.iso_hu, digits_of(settings.section.window_hu)) +
                  value_unit(scan),
              kInk, 1);
    if (!settings.caption.empty()) label_bottom(view, settings.caption);
    render::paste(all, view, {0, 0});

    const auto section = [&](Orientation orientation, int w, int h, Pixel at) {
        render::paste(all, section_panel(volume, settings.section, orientation, w, h, arena), at);
    };
    section(Orientation::Axial, right, top, {left + line, 0});
    section(Orientation::Coronal, left, bottom, {0, top + line});
    section(Orientation::Sagittal, right, bottom, {left + line, top + line});
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
