// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A picture in memory: returned by <pliant/render.h>, written by <pliant/view/png.h>.

#pragma once

#include <cstdint>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct Rgb8 {
    std::uint8_t r, g, b;
    friend constexpr bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// 8-bit sRGB picture, rows from the top.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<Rgb8> pixels;
};

}  // namespace pliant
#pragma GCC visibility pop
