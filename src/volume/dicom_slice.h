// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The header of one DICOM image. A file that can't be used as a slice says why, and which series it
// is of, so that it stands in the way of that series only.

#pragma once

#include "volume/dicom_walk.h"

#include <pliant/result.h>
#include <pliant/vec.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// How and where the pixels are stored.
struct DicomPixels {
    TransferSyntax syntax;
    bool is_signed = false;
    int bits_allocated = 16, bits_stored = 16, high_bit = 15;
    bool swapped_words = false;  ///< pairs of bytes are in the other order than little endian
    /// Uncompressed: one. Else the pieces of a codestream.
    std::vector<FilePart> parts;

    bool compressed() const { return syntax.codec != PixelCodec::None; }
};

/// What the header of a DICOM image says.
struct DicomSlice {
    std::filesystem::path path;
    std::string series_uid;  ///< kNoSeriesUid where the file has none; empty where it isn't known
    std::string description;
    int rows = 0, columns = 0;
    double slope = 1, intercept = 0;  ///< HU = slope·stored + intercept
    Vec3d position{};                 ///< centre of the first pixel [mm, LPS]
    Vec3d row{};                      ///< unit vector along a row: the i axis
    Vec3d column{};                   ///< unit vector down a column: the j axis
    Vec3d spacing_mm{};               ///< x: between columns, y: between rows; z unused
    DicomPixels pixels;
    bool has_modality_lut = false;
    std::optional<Error> fault;  ///< why it can't be a slice; then the rest may be missing
};

/// Name of the series of files that name none.
inline constexpr const char* kNoSeriesUid = "none";

/// @returns nothing if the file is no DICOM image
std::optional<DicomSlice> read_dicom_slice(const std::filesystem::path& path);

/// Whether a file starts as DICOM files do.
bool looks_like_dicom(const std::filesystem::path& path);

}  // namespace pliant
