// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local measures of the deformation: see jacobian_field and strain_field.

#pragma once

#include <pliant/resample.h>

#include "field/field.h"

namespace pliant {

Volume jacobian_of_field(const Field& field, const TaskArena& arena);
Volume strain_of_field(const Field& field, const TaskArena& arena);

}  // namespace pliant
