// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Forces of the cells' volume energy, −bulk (V/V₀ − 1) ∂V/∂x (cell_volume.h): first per cell, eight
// cells at a time, then per node, so that sums have a fixed order for any number of threads.
//
// Positions and the forces on corners are stored as x, y, z, 0, so that each is one load of 32
// bytes. Four of them make a vector of each axis by a transposition, which is faster than gathering
// each axis. A tetrahedron reads and writes 128 bytes each, and takes about 110 additions and
// multiplications and two divisions. No operation is fused: vectors and scalars give the same bits.

#pragma once

#include "springs/sweep_plan.h"

namespace pliant {

struct VolumeArrays {
    const double* seen;    ///< [local] x, y, z, 0
    double* corner_force;  ///< [index in cell_nodes] x, y, z, 0
    const double* load[3];
    double* force[3];  ///< [local] load and force of the volume energy
};

struct VolumeKernel {
    /// Computes corner forces of packs of cells.
    void (*cells)(const SweepPlan& plan, const VolumeArrays& arrays, std::int64_t begin,
                  std::int64_t end);
    /// Sums the corner forces of nodes, in local numbers.
    void (*nodes)(const SweepPlan& plan, const VolumeArrays& arrays, std::int64_t begin,
                  std::int64_t end);
};

VolumeKernel plain_volume_sweep();
/// Kernel for the best instruction set of this processor.
VolumeKernel vector_volume_sweep();

}  // namespace pliant
