// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/models/catheter.h>

#include "arrays.h"

namespace pliant::python {

/// Where the guide ends: an open end of the vessel, or a position and a direction.
CatheterEntry entry_of(const nb::object& entry, double inwards, double inserted_mm,
                       const VesselWall& wall);

}  // namespace pliant::python
