// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The warp of augmentation, which a prepared scan makes.

#pragma once

#include <pliant/data/warp.h>

#include "arrays.h"

namespace pliant::python {

/// A warp of arrays on a grid. One slice has no cells: the warp of such a grid has two, which move
/// alike (with_doubled_slices).
struct PyWarp {
    Warp warp;
    Grid grid;

    bool is_doubled() const { return grid.size != warp.grid().size; }
};

/// Binds PreparedScan. @pre Warp is bound
void bind_prepared_scan(nb::module_& m);

}  // namespace pliant::python
