// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// DICOM slices of a folder become a volume. Neither names nor slice numbers nor slice thickness are
// trusted: slices are sorted by where they are along their common normal,
//
//   n = row × column,   d = position · n,
//
// the distance between them is that of their positions, and a stack that leans (a tilted gantry),
// has gaps or holds a slice twice is refused.

#pragma once

#include "volume/voxel_builder.h"

#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// How the pixels are stored.
struct DicomPixels {
    bool compressed = false;
    bool is_signed = false;
    int bits_allocated = 16, bits_stored = 16, high_bit = 15;
    std::uint64_t bytes = 0;  ///< of pixels that aren't compressed
};

/// What the header of a DICOM image says.
struct DicomSlice {
    std::filesystem::path path;
    std::string series_uid;
    std::string description;
    int rows = 0, columns = 0;
    int frames = 1;
    int samples_per_pixel = 1;
    std::optional<double> slope, intercept;  ///< HU = slope·stored + intercept
    std::optional<Vec3d> position;           ///< centre of the first pixel [mm, LPS]
    std::optional<Vec3d> row;                ///< unit vector along a row: the i axis
    std::optional<Vec3d> column;             ///< unit vector down a column: the j axis
    std::optional<Vec3d> spacing_mm;         ///< x: between columns, y: between rows; z unused
    DicomPixels pixels;
};

/// Header of a file, or nothing if it is no DICOM image. @returns Unreadable if it is one that is
/// damaged or ends early
Result<std::optional<DicomSlice>> read_dicom_slice(const std::filesystem::path& path);

/// One of the series that lie in a folder.
struct DicomSeries {
    std::string uid;
    std::string description;
    int slices = 0;
};

/// All series of a folder, by their UIDs; files that are no DICOM images don't count.
Result<std::vector<DicomSeries>> list_series(const std::filesystem::path& folder);

/// Keeps the slices of one series. @param series_uid  empty: the only one there is
/// @returns an error that lists the series, where it isn't clear which
Result<std::vector<DicomSlice>> choose_series(const std::filesystem::path& folder,
                                              std::vector<DicomSlice> slices,
                                              const std::string& series_uid);

/// Sorts slices along their normal. @returns the grid they make
Result<Grid> stack_slices(const std::filesystem::path& folder, std::vector<DicomSlice>& slices);

/// Reads the DICOM slices of a folder.
Result<Volume> read_dicom_folder(const std::filesystem::path& folder, const ReadOptions& options,
                                 ReadNotes& notes);

/// Whether a file starts as DICOM files do.
bool looks_like_dicom(const std::filesystem::path& path);

}  // namespace pliant
