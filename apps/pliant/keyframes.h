// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A movie as a list of cameras with times: the file that the page saves.
// viewer/src/maths/keyframes.ts has the same formulas, so that both make the same movie.

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <string>
#include <vector>

namespace pliant::app {

struct Keyframe {
    double seconds = 0;  ///< since the movie's start
    Vec3d eye_mm{0, 0, 0}, look{0, 1, 0}, up{0, 0, 1};
    double field_of_view_deg = 80;
    double iso_hu = -500;
    double window_hu = 1500, level_hu = -200;
};

/// @returns at least one keyframe, the first at 0 s, in ascending order
Result<std::vector<Keyframe>> read_keyframes(const std::string& file);

/// Camera at a time: the eye on a Catmull-Rom curve through the keyframes, orientation by slerp,
/// numbers by linear interpolation.
Keyframe shot_at(const std::vector<Keyframe>& frames, double seconds);

}  // namespace pliant::app
