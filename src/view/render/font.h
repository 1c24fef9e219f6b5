// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small font for labels: five by seven dots, with two more rows for descenders.

#pragma once

namespace pliant::render {

inline constexpr int kGlyphColumns = 5;
inline constexpr int kGlyphRows = 9;

/// Whether the character has a dot at this position. Characters outside of printable ASCII look
/// like '?'.
/// @pre 0 ≤ column < kGlyphColumns, 0 ≤ row < kGlyphRows
bool glyph_dot(char character, int column, int row);

}  // namespace pliant::render
