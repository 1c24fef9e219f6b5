// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parts of a catheter's scene: checked settings, the wall's constraints, the wire.

#pragma once

#include <pliant/models/catheter.h>

#include "base/units.h"
#include "catheter/wire.h"

namespace pliant::catheter {

/// @returns InvalidArgument that names the setting
Status check(const CatheterSettings& settings);
/// Makes the wall: its constraints on an elastic foundation, fixed at its open ends.
/// @param settings  with the actual sub-steps
Result<PbdBody> body_of(const VesselWall& wall, const CatheterSettings& settings);
/// Checks that the guide and the initially inserted part end inside of the vessel.
/// @returns InvalidArgument that names the setting
Status check_entry(const VesselWall& wall, const CatheterEntry& entry, double segment_mm);
/// Number of sub-steps: the setting, or more if contact needs them. Motion per sub-step is limited
/// for the tip's segments and the wall's tetrahedra (docs/method/vessel.md).
int sub_steps_of(const VesselWall& wall, const CatheterSettings& settings);
WireSettings wire_settings(const CatheterSettings& settings);

}  // namespace pliant::catheter
