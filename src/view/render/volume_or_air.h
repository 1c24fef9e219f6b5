// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// For functions that return a picture or a position and no error: air replaces a volume that
// check_volume refuses.

#pragma once

#include <pliant/volume.h>

namespace pliant::render {

inline const Volume& small_air_volume() {
    static const Volume air{
        {.size = {2, 2, 2}}, VoxelArray<std::int16_t>(std::vector<std::int16_t>(8, kAirHu)), {}};
    return air;
}

inline const Volume& volume_or_air(const Volume& volume) {
    return check_volume(volume).ok() ? volume : small_air_volume();
}

}  // namespace pliant::render
