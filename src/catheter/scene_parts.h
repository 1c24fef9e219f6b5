// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a catheter's scene is made of: its settings within bounds, the wall's constraints, the wire.

#pragma once

#include <pliant/catheter.h>

#include <memory>
#include <string>

#include "catheter/wire.h"

namespace pliant::catheter {

inline constexpr double kMicronewtons = 1e6;  ///< in a newton

/// @returns InvalidArgument that names the setting
Status check(const CatheterSettings& settings);
/// The wall as neo-Hookean tissue on a foundation, held at its open ends.
Result<PbdParts> parts_of(const VesselWall& wall, const WallTissue& tissue);
/// Whether the guide and the part inserted at first end inside the vessel.
/// @returns InvalidArgument that names the setting
Status check_entry(const VesselWall& wall, const CatheterEntry& entry, double segment_mm);
/// As many as asked for, and no fewer than contact wants: the tip's segments and the wall's
/// tetrahedra may not go too far in one (docs/vessel.md).
int sub_steps_of(const VesselWall& wall, const CatheterSettings& settings);
std::unique_ptr<Wire> make_wire(const CatheterSettings& settings);

}  // namespace pliant::catheter
