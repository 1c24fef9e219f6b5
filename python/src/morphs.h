// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "arrays.h"

namespace pliant::python {

/// Binds Morph. @pre Field and Volume are bound
void bind_morph(nb::module_& m);

}  // namespace pliant::python
