// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A movie as a few cameras and the times at which they are reached: the file that the page saves.
// The same sums are in viewer/src/maths/keyframes.ts, so that both make the same movie.

#pragma once

#include <pliant/result.h>
#include <pliant/vec.h>

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

/// @returns at least one, the first at 0 s, the others each later than the one before
Result<std::vector<Keyframe>> read_keyframes(const std::string& file);

/// What the movie shows at a time: the eye on a Catmull-Rom curve through the keyframes, the camera
/// turned by slerp, the numbers changed evenly.
Keyframe shot_at(const std::vector<Keyframe>& frames, double seconds);

}  // namespace pliant::app
