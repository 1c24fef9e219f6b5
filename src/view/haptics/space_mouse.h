// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A local SpaceMouse, through libspnav and its daemon spacenavd. The library is loaded when the
// device is opened, so no build needs it. It displays no force.
//
//   libspnav ──events──► a thread: the cap's deflection is a speed ──positions──► the servo, as for
//   a browser's device

#pragma once

#include <pliant/view/haptics.h>

namespace pliant {

/// Loads a file, or a library of the system. @returns null; why, unless it says something already
void* load_library(const std::string& name, std::string& why);

/// @param library  a file; empty: the system's library
/// @returns NotFound or Unsupported, with one line that names the missing part and the remedy
Result<std::unique_ptr<HapticDevice>> open_space_mouse(const std::string& library);

/// Deflection of the cap in libspnav's units: to the right, up, away from the user, and rotation
/// about the last axis.
struct CapMotion {
    double x = 0, y = 0, z = 0, roll = 0;
};
struct CapPosition {
    Vec3d position_mm{0, 0, 0};
    double roll_rad = 0;
};
/// Integrates the motion, within 100 mm of the middle.
CapPosition cap_moved(const CapPosition& from, const CapMotion& motion, double passed_s);

}  // namespace pliant
