// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drawing on pictures: lines, text, pictures into pictures. Whatever lies outside is left out.

#pragma once

#include <pliant/render.h>

#include <string_view>

namespace pliant::render {

struct Pixel {
    int x, y;
};

/// Height and advance of a character at scale 1 [pixels], without what hangs below the line.
inline constexpr int kGlyphHeight = 7;
inline constexpr int kGlyphAdvance = 6;

Image make_image(int width, int height, Rgb8 colour);

/// Mixes a colour into a pixel. @param opacity  0…1
void blend(Image& image, Pixel at, Rgb8 colour, double opacity);
/// Filled rectangle, begin ≤ pixel < end.
void fill_box(Image& image, Pixel begin, Pixel end, Rgb8 colour, double opacity = 1);
/// Pastes a picture with its top left corner at a pixel.
void paste(Image& image, const Image& part, Pixel at);

/// Width of a text [pixels]. UTF-8; every character takes the same room.
int text_width(std::string_view text, int scale);
/// Draws text with a dark rim, its top left corner at a pixel. Characters that the built-in font
/// doesn't have become '?'.
void draw_text(Image& image, Pixel at, std::string_view text, Rgb8 colour, int scale);

}  // namespace pliant::render
