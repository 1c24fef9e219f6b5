// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A small font for labels: five by seven dots, two more rows for what hangs below the line.

#pragma once

namespace pliant::render {

inline constexpr int kGlyphColumns = 5;
inline constexpr int kGlyphRows = 9;

/// Whether the character has a dot there. Characters outside of printable ASCII look like '?'.
/// @pre 0 ≤ column < kGlyphColumns, 0 ≤ row < kGlyphRows
bool glyph_dot(char character, int column, int row);

}  // namespace pliant::render
