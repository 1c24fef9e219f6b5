// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reads the DICOM slices of a folder, or of a file of several frames, as a volume.

#pragma once

#include "formats/dicom_pixels.h"
#include "formats/dicom_slice.h"
#include "formats/straighten.h"

#include <pliant/result.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Slices closer than this are at the same position [mm].
inline constexpr double kSameSliceMm = 1e-3;
/// Rounding tolerance of direction cosines.
inline constexpr double kSameSliceAxes = 1e-4;

/// A sorted series.
struct DicomStack {
    Grid grid;
    /// Positions of the slices, if they aren't those of the grid. The grid's size is the stack's.
    std::optional<SliceStack> irregular{};
};

/// Feature in which two slices differ, so that they can't be in one volume; null: none.
const char* difference_of(const DicomSlice& a, const DicomSlice& b);

/// Sorts slices of one series along their normal. @pre difference_of is null for all
/// @param straighten   slices that are tilted, shifted, missing or unequally spaced are irregular;
///                     otherwise they are refused
/// @param[out] notes  tolerated deviations, and those that make a stack irregular
Result<DicomStack> stack_slices(const std::filesystem::path& folder,
                                std::vector<DicomSlice>& slices, bool straighten,
                                std::vector<std::string>& notes);

/// Splits a series into its volumes, those of the most slices first. Copies and localizers are
/// left out.
/// @param[out] notes  the files that are left out
std::vector<std::vector<DicomSlice>> split_volumes(std::vector<DicomSlice> slices,
                                                   std::vector<std::string>& notes);

/// Places slices without a geometry above each other, in the order of their Instance Numbers, or
/// of the frames of a file. Copies are left out.
/// @returns Unsupported if that order is unknown
Status place_in_order(const std::filesystem::path& path, std::vector<DicomSlice>& slices,
                      Vec3d spacing_mm, std::vector<std::string>& notes);

/// Number of volumes of a file or folder to choose from with ReadOptions::frame.
/// @param series  ReadOptions::series_uid
Result<std::int64_t> count_dicom_volumes(const std::filesystem::path& path,
                                         const std::string& series);

/// Reads the labels of a segmentation or of a label map, with the names of its segments as keys.
/// ReadOptions::frame chooses one of its segments, in the order of their numbers.
/// @returns InvalidArgument if segments overlap and none is chosen
Result<Volume> read_dicom_segments(const std::filesystem::path& path, const ReadOptions& options,
                                   ReadNotes& notes, const DecoderChoice& decoder = {});
/// Number of segments to choose from.
Result<std::int64_t> count_dicom_segments(const std::filesystem::path& path);

/// Reads the frames of a file. The file DICOMDIR stands for its folder.
Result<Volume> read_dicom_file(const std::filesystem::path& path, const ReadOptions& options,
                               ReadNotes& notes, const DecoderChoice& decoder = {});

/// Reads the DICOM slices of a folder.
Result<Volume> read_dicom_folder(const std::filesystem::path& folder, const ReadOptions& options,
                                 ReadNotes& notes, const DecoderChoice& decoder = {});

}  // namespace pliant
#pragma GCC visibility pop
