// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local measures of the deformation: see jacobian_field and strain_field.

#pragma once

#include <pliant/resample.h>

#include "chainmail/lattice.h"

namespace pliant {

Volume jacobian_by_lattice(const Lattice& lattice, const TaskArena& arena);
Volume strain_by_lattice(const Lattice& lattice, const TaskArena& arena);

}  // namespace pliant
