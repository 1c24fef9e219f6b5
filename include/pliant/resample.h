// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From the deformed lattice back to the grid.
//
// The new value at grid point p is the original scan's value at φ⁻¹(p), where φ(X) = X + u(X). It
// is always the original that is read, so repeated pushes don't blur.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/volume.h>

#include <cstdint>

namespace pliant {

/// How φ⁻¹ is found inside a deformed cell.
enum class Mapping {
    Cells,  ///< the trilinear map of the whole cell, inverted in vectors; the value is trilinear
            ///< too
    CellsScalar,  ///< the same in double precision, one voxel at a time: its readable twin
    Tetrahedra,   ///< twelve tetrahedra, barycentric [Draeger2005, 3.6.3]: the reference
};

struct Deformed {
    Volume volume;  ///< on the grid of the original, with its key/value pairs
    /// Smallest box with every voxel that was written; empty if nothing moved inside the scan.
    Box3i dirty_box;
    std::int64_t written_voxels = 0;
    std::int64_t gap_voxels = 0;  ///< of these: covered by no cell, filled with air
    double resample_ms = 0;
    /// φ⁻¹(p) − p [mm, LPS] for the voxels of dirty_box, i fastest; zero where p is at rest. Empty
    /// unless asked for.
    std::vector<Vec3f> inverse_mm;
};

/// Writes the deformed scan. The same bits for any number of threads.
Deformed deform_volume(const ChainMail& tissue, Mapping mapping = Mapping::Cells,
                       bool with_inverse = false);

/// Forward displacement at every rest voxel centre of the scan.
VectorField displacement_field(const ChainMail& tissue);

/// Inverse displacement on the whole grid, in the direction that resampling filters expect.
/// @pre deformed was made with_inverse
VectorField inverse_field(const Deformed& deformed);

/// Of all voxels and their grid's size: to compare results.
std::uint64_t hash_volume(const Volume& volume);

}  // namespace pliant
