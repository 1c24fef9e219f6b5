// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A stroke font for axis names, units and legends: lines and rounded lines on a grid of units,
//
//     y = 0  top of capitals and digits
//     y = 2  top of small letters
//     y = 6  base line
//     y = 8  lowest descender

#pragma once

#include <string_view>
#include <vector>

namespace pliant::results {

inline constexpr double kCapHeight = 6;  ///< [units]

struct GlyphStroke {
    struct Vertex {
        double x, y;  ///< [units]
    };
    std::vector<Vertex> vertices;  ///< one vertex: a dot
};
struct Glyph {
    std::vector<GlyphStroke> strokes;
    double width = 0;  ///< [units], without the gap to the next glyph
};

/// Removes the first character of a UTF-8 text and returns its glyph; '?' for characters that are
/// not in the font. @pre text is not empty
Glyph take_glyph(std::string_view& text);

}  // namespace pliant::results
