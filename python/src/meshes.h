// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "arrays.h"

namespace pliant::python {

/// An array (n, 3) that keeps the points.
nb::object points_of(std::vector<Vec3d> points);

}  // namespace pliant::python
