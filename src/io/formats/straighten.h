// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Resampling of a stack of parallel slices to a regular grid: slices that are shifted sideways
// (gantry tilt, shear), missing, or not equally spaced.
//
//        ____            ______
//      /    /           |    / |
//     /____/     →      | __/  |      trilinear in the slices' own coordinates (i, j, k),
//    /    /             |/     |      so that a voxel of the stack at a voxel of the grid keeps
//   /____/              |______|      its value
//
// The grid has the slices' axes and their spacing within a slice, and contains all voxels of the
// stack. Where a neighbour is padding, the nearest voxel is taken. Beyond the stack it is filled:
// with air, or with the stack's smallest value if no value is below zero (then values aren't
// Hounsfield units).

#pragma once

#include <pliant/result.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// Positions of parallel slices. Voxel (i, j) of slice k is at
///
///   origin + (i·step_i + j·lean_j + shift_i[k])·a0 + (j·step_j + shift_j[k])·a1 + height[k]·a2
struct SliceStack {
    Mat3d axes = kIdentity3;  ///< a0, a1, a2: perpendicular unit vectors, LPS
    Vec3d origin_mm{};
    double step_i_mm = 1, step_j_mm = 1;
    double lean_j_mm = 0;                          ///< along a0, for each step of j
    std::vector<double> heights_mm;                ///< ascending, from 0
    std::vector<double> shifts_i_mm, shifts_j_mm;  ///< one per slice
    double gap_mm = 1;                             ///< usual distance between slices
    std::vector<bool> padding;  ///< voxels that are never blended, i fastest; empty: none
};

/// The stack of a grid whose axes aren't perpendicular. @pre they span the space
SliceStack stack_of(const Grid& grid);
/// Largest deviation of two axes from a right angle.
double shear_degrees(const Grid& grid);

/// Resamples a stack. @param stacked  its voxels; the positions of its grid aren't used
/// @param[out] notes  changes that were made
Result<Volume> straightened(const std::filesystem::path& path, const Volume& stacked,
                            const SliceStack& stack, const ReadOptions& options,
                            std::vector<std::string>& notes);

}  // namespace pliant
