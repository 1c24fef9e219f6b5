// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The DICOM files of a folder, by their series, and the choice of one of them. Folders in a folder
// are searched if it has no slices itself, up to a depth and a number of files. An unusable file
// blocks its own series only; if its series is unknown, it blocks every series that isn't chosen.

#pragma once

#include "formats/dicom_slice.h"

#include <pliant/result.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct SeriesFiles {
    std::vector<DicomSlice> slices;
    std::optional<Error> fault;  ///< the first fault of its slices
};

/// Contents of a folder.
struct DicomFolder {
    std::map<std::string, SeriesFiles> series;
    std::vector<DicomSlice> strays;  ///< damaged before the series' UID
    std::size_t others = 0, linked_folders = 0;
    bool went_deeper = false;  ///< its folders were searched too

    bool is_empty() const { return series.empty() && strays.empty(); }
};

/// Whether a file is the directory of the files in its folder.
bool is_dicomdir(const std::filesystem::path& file);
/// Folder for which the file DICOMDIR stands.
std::filesystem::path folder_of_dicomdir(const std::filesystem::path& file);

/// "1 file", "2 files"
std::string counted(std::size_t count, const char* one, const char* several);

/// Looks into a folder, and below it if it has no slice.
/// @param may_lack_geometry  as of read_dicom_slices
/// @returns NotFound if there is no image; Unreadable for a file that can't be read
Result<DicomFolder> read_dicom_headers(const std::filesystem::path& folder,
                                       bool may_lack_geometry = false);

/// Slices of the wanted series.
/// @param wanted  UID, number, or part of the description; empty: the only usable series
/// @param[out] notes  files and series that are left out
/// @returns an error with a table of the series if not exactly one fits
Result<std::vector<DicomSlice>> choose_series(const std::filesystem::path& folder,
                                              DicomFolder found, const std::string& wanted,
                                              std::vector<std::string>& notes);

}  // namespace pliant
