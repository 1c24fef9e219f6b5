// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A device with externally supplied positions, some 60 per second: a game pad, a SpaceMouse or a
// mouse in a browser. It displays no force. Positions are smoothed with a delay of a few
// milliseconds. Without a new position for half a second the device is lost, and there is no force.

#pragma once

#include <pliant/view/haptics.h>

#include <memory>

#include "haptics/triple_buffer.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

struct PosedPosition {
    std::int64_t said_ns = 0;  ///< time of arrival, steady_now_ns(); 0: none yet
    Vec3d position_mm{0, 0, 0};
    double roll_rad = 0;  ///< accumulated over full turns
    std::uint32_t buttons = 0;
};

/// Written by the supplier's thread, read by the device on the servo's thread.
using PosedPositions = TripleBuffer<PosedPosition>;

/// @param name  of the device; a string literal
std::unique_ptr<HapticDevice> make_posed_device(std::shared_ptr<PosedPositions> positions,
                                                const char* name = "browser");

/// Smoothed motion towards the last supplied position. @param passed_s  since the last step
Vec3d posed_step(Vec3d from_mm, Vec3d to_mm, double passed_s);

}  // namespace pliant
#pragma GCC visibility pop
