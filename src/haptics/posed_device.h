// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A device whose place somebody else says, some 60 times a second: a game pad, a SpaceMouse or a
// mouse in a browser. It shows no force to the hand. Between two places it goes on smoothly, a few
// milliseconds late; where none comes for half a second, it is lost, and there is no force.

#pragma once

#include <pliant/haptics_servo.h>

#include <memory>

#include "haptics/triple_buffer.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

struct PosedPlace {
    std::int64_t said_ns = 0;  ///< steady_now_ns(); 0: not yet
    Vec3d position_mm{0, 0, 0};
    double roll_rad = 0;  ///< as often round as it was turned
    std::uint32_t buttons = 0;
};

/// By the thread that says it; the device reads it on the servo's.
using PosedPlaces = TripleBuffer<PosedPlace>;

/// @param name  of the device; a literal
std::unique_ptr<HapticDevice> make_posed_device(std::shared_ptr<PosedPlaces> places,
                                                const char* name = "browser");

/// One step of the way to the last place that was said. @param passed_s  since the last step
Vec3d posed_step(Vec3d from_mm, Vec3d to_mm, double passed_s);

}  // namespace pliant
#pragma GCC visibility pop
