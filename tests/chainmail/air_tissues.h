// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random scans with air, with bricks whose limits are equal for all directions of a push and
// others.

#pragma once

#include <pliant/chainmail.h>

#include <algorithm>
#include <vector>

#include "chainmail/tissues.h"

namespace pliant::test {

/// Blobs of tissue with a few values, with or without single deviating elements, and air.
inline Volume scan_with_air(Random& random, int largest) {
    struct Blob {
        Vec3d centre;
        int value;
    };
    const Vec3i size{random.whole(8, largest), random.whole(8, largest), random.whole(8, largest)};
    std::vector<Blob> blobs;
    for (int n = random.whole(3, 9); n > 0; --n)
        blobs.push_back(
            {{random.real(0, size.x), random.real(0, size.y), random.real(0, size.z)},
             random.whole(0, 2) ? random.whole(-200, 900) : int(kAirHu) + random.whole(0, 300)});
    const bool grainy = random.whole(0, 1);
    Volume volume = volume_of(size, [&](Vec3i e) {
        const Vec3d p{double(e.x), double(e.y), double(e.z)};
        const auto nearest = std::min_element(blobs.begin(), blobs.end(), [&](auto& a, auto& b) {
            return norm(a.centre - p) < norm(b.centre - p);
        });
        return nearest->value + (grainy ? random.whole(-60, 60) : 0);
    });
    for (int a = 0; a < 3; ++a)
        volume.grid.spacing_mm[a] = random.whole(0, 1) ? 1 : random.real(0.7, 2.5);
    return volume;
}

/// Air with default settings; tissue soft or hard, bricks of any size, mostly of 8.
inline ChainMailSettings settings_with_air(Random& random) {
    ChainMailSettings settings;
    settings.offset = random.ratio(0.08, 0.3);
    settings.bone_threshold_hu = random.whole(0, 2) ? 4000 : 700;
    settings.bounded = random.whole(0, 2) == 0;
    if (random.whole(0, 3) == 0) settings.brick_size = random.whole(5, 12);
    if (random.whole(0, 3) == 0) settings.air_compress = random.ratio(0.3, 1);
    if (random.whole(0, 3) == 0) settings.air_stretch = random.ratio(0.1, 9);
    return settings;
}

}  // namespace pliant::test
