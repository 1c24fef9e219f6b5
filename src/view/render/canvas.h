// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Drawing on pictures: lines, text, pictures into pictures. Everything is clipped.

#pragma once

#include <pliant/render.h>

#include <string_view>

namespace pliant::render {

struct Pixel {
    int x, y;
};

/// Height and advance of a character at scale 1 [pixels], without descenders.
inline constexpr int kGlyphHeight = 7;
inline constexpr int kGlyphAdvance = 6;

Image make_image(int width, int height, Rgb8 colour);

/// Mixes a colour into a pixel. @param opacity  0…1
void blend(Image& image, Pixel at, Rgb8 colour, double opacity);
/// Filled rectangle, begin ≤ pixel < end.
void fill_box(Image& image, Pixel begin, Pixel end, Rgb8 colour, double opacity = 1);
/// Pastes a picture with its top left corner at a pixel.
void paste(Image& image, const Image& part, Pixel at);

/// Width of a text [pixels]. UTF-8; all characters have the same width.
int text_width(std::string_view text, int scale);
/// Draws text with a dark rim, its top left corner at a pixel. '?' replaces characters that are not
/// in the built-in font.
void draw_text(Image& image, Pixel at, std::string_view text, Rgb8 colour, int scale);

}  // namespace pliant::render
