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
/// More sub-steps are not made.
inline constexpr std::int32_t kMaxSubSteps = 1000;
/// Number of sub-steps: the setting, or more if contact needs them. Motion per sub-step is limited
/// for the tip's segments and the wall's tetrahedra (docs/method/vessel.md).
std::int32_t needed_sub_steps(const VesselWall& wall, const CatheterSettings& settings);
/// Compliance of the surfaces: the setting, or from the wire's stiffness [mm/N].
double contact_mm_per_n_of(const CatheterShape& catheter);
WireSettings wire_settings(const CatheterSettings& settings);

}  // namespace pliant::catheter
