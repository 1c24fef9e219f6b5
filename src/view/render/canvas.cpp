// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "render/canvas.h"

#include <algorithm>

#include "render/font.h"

namespace pliant::render {
namespace {

bool inside(const Image& image, Pixel p) {
    return p.x >= 0 && p.x < image.width && p.y >= 0 && p.y < image.height;
}

Rgb8& pixel(Image& image, Pixel p) {
    return image.pixels[std::size_t(p.y) * std::size_t(image.width) + std::size_t(p.x)];
}

/// Calls body(character, index); UTF-8 continuation bytes are skipped.
template <class Body>
void for_each_character(std::string_view text, const Body& body) {
    int index = 0;
    for (char c : text)
        if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) body(c, index++);
}

void draw_glyphs(Image& image, Pixel at, std::string_view text, Rgb8 colour, int scale,
                 double opacity) {
    for_each_character(text, [&](char c, int index) {
        for (int row = 0; row < kGlyphRows; ++row)
            for (int column = 0; column < kGlyphColumns; ++column) {
                if (!glyph_dot(c, column, row)) continue;
                const Pixel dot{at.x + (index * kGlyphAdvance + column) * scale,
                                at.y + row * scale};
                fill_box(image, dot, {dot.x + scale, dot.y + scale}, colour, opacity);
            }
    });
}

}  // namespace

Image make_image(int width, int height, Rgb8 colour) {
    width = std::max(width, 1);
    height = std::max(height, 1);
    return {width, height, std::vector<Rgb8>(std::size_t(width) * std::size_t(height), colour)};
}

void blend(Image& image, Pixel at, Rgb8 colour, double opacity) {
    if (!inside(image, at)) return;
    Rgb8& p = pixel(image, at);
    const auto mix = [&](std::uint8_t under, std::uint8_t over) {
        return std::uint8_t(under + (over - under) * opacity + 0.5);
    };
    p = {mix(p.r, colour.r), mix(p.g, colour.g), mix(p.b, colour.b)};
}

void fill_box(Image& image, Pixel begin, Pixel end, Rgb8 colour, double opacity) {
    for (int y = std::max(begin.y, 0); y < std::min(end.y, image.height); ++y)
        for (int x = std::max(begin.x, 0); x < std::min(end.x, image.width); ++x)
            blend(image, {x, y}, colour, opacity);
}

void paste(Image& image, const Image& part, Pixel at) {
    for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x)
            blend(image, {at.x + x, at.y + y},
                  part.pixels[std::size_t(y) * std::size_t(part.width) + std::size_t(x)], 1);
}

int text_width(std::string_view text, int scale) {
    int count = 0;
    for_each_character(text, [&](char, int) { ++count; });
    return count > 0 ? (count * kGlyphAdvance - 1) * scale : 0;
}

void draw_text(Image& image, Pixel at, std::string_view text, Rgb8 colour, int scale) {
    constexpr Rgb8 kRim{0, 0, 0};
    constexpr double kRimOpacity = 0.45;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0)
                draw_glyphs(image, {at.x + dx, at.y + dy}, text, kRim, scale, kRimOpacity);
    draw_glyphs(image, at, text, colour, scale, 1);
}

}  // namespace pliant::render
