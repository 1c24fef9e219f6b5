// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reads the DICOM slices of a folder as a volume. An unusable file blocks its own series only; if
// its series is unknown, it blocks every series that isn't chosen by name.

#pragma once

#include "formats/dicom_pixels.h"
#include "formats/dicom_slice.h"

#include <pliant/result.h>
#include <pliant/volume.h>

#include <filesystem>
#include <string>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// A series in a folder.
struct DicomSeries {
    std::string uid;
    std::string description;
    int slices = 0;
};

/// Series of a folder to choose from, by their UIDs: the usable ones, or all if none is usable.
Result<std::vector<DicomSeries>> list_series(const std::filesystem::path& folder);

/// Sorts slices of one series along their normal.
/// @param[out] notes  tolerated deviations
/// @returns grid of the stack
Result<Grid> stack_slices(const std::filesystem::path& folder, std::vector<DicomSlice>& slices,
                          std::vector<std::string>& notes);

/// Reads the DICOM slices of a folder.
Result<Volume> read_dicom_folder(const std::filesystem::path& folder, const ReadOptions& options,
                                 ReadNotes& notes, const DecoderChoice& decoder = {});

}  // namespace pliant
#pragma GCC visibility pop
