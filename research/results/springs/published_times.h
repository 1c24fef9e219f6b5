// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Times of the paper's sheet, a layer each [Choi2004, Table 3].

#pragma once

#include <array>

namespace pliant::results {

struct Published {
    int layers, nodes;
    double search_ms, update_ms;
};
inline constexpr std::array<Published, 8> kTable3{{{1, 7, 0.02, 0.14},
                                                   {2, 19, 0.07, 0.38},
                                                   {3, 37, 0.1, 0.49},
                                                   {4, 61, 0.27, 0.97},
                                                   {5, 91, 0.44, 1.42},
                                                   {10, 331, 2.56, 5.87},
                                                   {15, 721, 10.57, 14.79},
                                                   {20, 1261, 28.79, 30.97}}};

}  // namespace pliant::results
