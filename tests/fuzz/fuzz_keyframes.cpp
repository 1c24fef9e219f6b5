// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Keyframes of a movie from the page, and the movie's shots.

#include <cmath>

#include "../../apps/pliant/keyframes.h"
#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("k.json", fuzz::text_of(data, size));
    const auto frames = app::read_keyframes(file.string());
    if (!frames.ok()) {
        fuzz::expect_one_line(frames.error().message);
        return 0;
    }
    const double last = frames->back().seconds;
    for (const double part : {0.0, 0.1, 0.5, 0.77, 1.0, 1.5}) {
        const app::Keyframe shot = app::shot_at(*frames, part * last);
        fuzz::expect(is_finite(shot.eye_mm) && is_finite(shot.look) && is_finite(shot.up),
                     "finite poses");
        fuzz::expect(norm(shot.look) > 0 && norm(shot.up) > 0, "directions");
        fuzz::expect(std::isfinite(shot.field_of_view_deg) && std::isfinite(shot.iso_hu) &&
                         std::isfinite(shot.window_hu) && std::isfinite(shot.level_hu),
                     "finite numbers");
    }
    return 0;
}
