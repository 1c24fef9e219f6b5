// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice between NIfTI's two maps from voxels to the world.

#pragma once

#include <array>

namespace pliant {

/// Stored geometry of a NIfTI-1 header [NIfTI2007].
struct NiftiForms {
    int qform_code = 0, sform_code = 0;  ///< 0 or less: absent
    float qfac = 1;                      ///< pixdim[0]; negative: the third axis is mirrored
    std::array<float, 3> step{};         ///< pixdim[1…3]
    std::array<float, 3> quaternion{};   ///< b, c, d
    std::array<float, 3> offset{};
    std::array<float, 12> srow{};  ///< by rows
};

/// Steps along i, j and k and the position of the first voxel, in RAS and the file's unit.
struct NiftiMap {
    std::array<std::array<float, 3>, 4> columns{};
};

enum class NiftiChoice { None, Qform, Sform };

NiftiMap qform_of(const NiftiForms& forms);
NiftiMap sform_of(const NiftiForms& forms);

/// Chooses the map as programs with ITK 5.2 do. The sform counts if it has the scanner's code, if
/// there is no qform, or if it equals the qform; but only without shear and with the spacings of
/// pixdim.
/// @returns None if there is no qform and the sform is rejected
/// @pre all numbers are finite, and a present sform has no zero axis
NiftiChoice chosen_map(const NiftiForms& forms);

}  // namespace pliant
