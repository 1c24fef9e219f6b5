// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A SpaceMouse at this machine, through libspnav and its daemon spacenavd. The library is looked
// for when the device is opened, so no build needs it. It shows no force to the hand.
//
//   libspnav ──events──► a thread: the cap is a speed ──places──► the servo, as of a browser's
//   device

#pragma once

#include <pliant/haptics_servo.h>

namespace pliant {

/// @param library  a file, or empty for the system's
/// @returns NotFound or Unsupported, with one line that says what is missing and what to do
Result<std::unique_ptr<HapticDevice>> open_space_mouse(const std::string& library);

/// How the cap is held, in libspnav's numbers: to the right, up and away, and turned about the
/// last.
struct CapMotion {
    double x = 0, y = 0, z = 0, roll = 0;
};
struct CapPlace {
    Vec3d position_mm{0, 0, 0};
    double roll_rad = 0;
};
/// Where the device is after some time, within 100 mm of the middle.
CapPlace cap_moved(const CapPlace& from, const CapMotion& motion, double passed_s);

}  // namespace pliant
