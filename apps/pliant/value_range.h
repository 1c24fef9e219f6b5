// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/volume.h>

#include <cstddef>
#include <iterator>

namespace pliant::app {

inline constexpr double kPercents[] = {1, 5, 25, 50, 75, 95, 99};
inline constexpr std::size_t kPercentCount = std::size(kPercents);

struct ValueRange {
    double min = 0, max = 0;
    double percentiles[kPercentCount] = {};
};

/// Exact, without a copy of the values. @pre there are voxels, all finite
ValueRange value_range(const Volume& volume);

}  // namespace pliant::app
