// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Number of elements that LiveDeformation::approach() has time for.

#pragma once

#include <pliant/resample.h>

#include <algorithm>
#include <cstdint>

#include "protocol/limits.h"

namespace pliant::serve {

/// Elements of the next update, so that it takes about kNearTime.
/// @param elements  of the last one. Small updates, which tell little, leave it as it is
inline std::int64_t near_elements(std::int64_t elements, const LiveUpdate& update) {
    if (update.written_voxels < kNearElements / 8) return elements;
    return std::max(kNearElements / 8,
                    std::int64_t(double(update.written_voxels) * kNearTime.count() /
                                 std::max(update.resample_ms, 1.0)));
}

}  // namespace pliant::serve
