// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which of NIfTI's two maps from voxels to the world counts.

#pragma once

#include <array>

namespace pliant {

/// The geometry in a NIfTI-1 header, as it is stored [NIfTI2007].
struct NiftiForms {
    int qform_code = 0, sform_code = 0;  ///< 0 or less: not there
    float qfac = 1;                      ///< pixdim[0]; below 0: the third axis is mirrored
    std::array<float, 3> step{};         ///< pixdim[1…3]
    std::array<float, 3> quaternion{};   ///< b, c, d
    std::array<float, 3> offset{};
    std::array<float, 12> srow{};  ///< by rows
};

/// Steps along i, j and k and the place of the first voxel, in RAS and the file's unit.
struct NiftiMap {
    std::array<std::array<float, 3>, 4> columns{};
};

enum class NiftiChoice { None, Qform, Sform };

NiftiMap qform_of(const NiftiForms& forms);
NiftiMap sform_of(const NiftiForms& forms);

/// The map that programs on ITK 5.2 take. The sform counts if it is the scanner's, if there is no
/// qform, or if it says the same as the qform; but only if it has no shear, and the spacings of
/// pixdim.
/// @returns None where there is no qform, and the sform is not taken
/// @pre all numbers are finite, and no axis of the sform is zero if it is there
NiftiChoice chosen_map(const NiftiForms& forms);

}  // namespace pliant
