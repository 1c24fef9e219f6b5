// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A pre-shaped catheter in a straight vessel with the paper's constraints: stretch, bend and volume
// [VesselPbd2016]. Its tip bends and presses into the wall.

#pragma once

#include <pliant/models/pbd.h>
#include <pliant/models/vessel.h>

#include <vector>

namespace pliant::results {

/// Fractions of each constraint that a projection removes [VesselPbd2016, Eq. 1].
inline constexpr double kStretch = 0.1, kBend = 0.05, kVolume = 1;
inline constexpr double kPressingRadius_mm = 1;

struct PressedVessel {
    VesselWall wall;
    PbdParts parts;  ///< with volume constraints in every run
};
/// 40 mm long, radii 4 and 7 mm; its ends and its outer surface are held.
PressedVessel pressed_vessel();

struct PressedRun {
    std::vector<Vec3d> wall_mm, wire_mm;
    VolumeChange change{};
    std::int64_t inverted = 0;
    double moved_mm = 0;       ///< largest displacement of a wall node
    double thinnest_mm = 0;    ///< smallest distance of an inner node from the outer ones
    double mean_near_tip = 0;  ///< mean error of the tetrahedra within 4 mm of the tip
};
/// @param volumes  whether tetrahedra keep their volume
/// @param tip_deg  angle of the tip's rest shape, reached after 5/8 of the steps
PressedRun run_pressed(const PressedVessel& vessel, bool volumes, double tip_deg,
                       const TaskArena& arena, int steps = 4000);
}  // namespace pliant::results
