// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM slices of a folder become a volume. A file that can't be used stands in the way of its own
// series only; where that isn't known, in the way of all that aren't asked for by name.

#pragma once

#include "volume/dicom_pixels.h"
#include "volume/dicom_slice.h"

#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <filesystem>
#include <string>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// One of the series that lie in a folder.
struct DicomSeries {
    std::string uid;
    std::string description;
    int slices = 0;
};

/// The series of a folder between which there is a choice, by their UIDs: those that can be used,
/// or else all.
Result<std::vector<DicomSeries>> list_series(const std::filesystem::path& folder);

/// Sorts slices of one series along their normal.
/// @param[out] notes  deviations that were taken for straight
/// @returns the grid they make
Result<Grid> stack_slices(const std::filesystem::path& folder, std::vector<DicomSlice>& slices,
                          std::vector<std::string>& notes);

/// Reads the DICOM slices of a folder.
Result<Volume> read_dicom_folder(const std::filesystem::path& folder, const ReadOptions& options,
                                 ReadNotes& notes, const DecoderChoice& decoder = {});

}  // namespace pliant
#pragma GCC visibility pop
