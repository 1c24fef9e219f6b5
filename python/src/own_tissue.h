// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/own_tissue.h>

#include "arrays.h"

namespace pliant::python {

/// Error of a method that raised, with its text. @pre the interpreter's lock is held
Error error_of(const char* method, nb::python_error& raised);

/// A tissue whose methods are those of an object of Python. Object, scan and arena must outlive it.
std::unique_ptr<Tissue> make_own_tissue(nb::handle self, const Volume& scan,
                                        const TaskArena& arena);

/// Displaces elements of such a tissue. @param first  voxel (i, j, k)
/// @param displacements_mm  array (k, j, i, 3) [mm, LPS]
void displace_own(Tissue& tissue, Vec3d first, const nb::object& displacements_mm);

}  // namespace pliant::python
