// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What ITK does: it reads headers, and the few kinds of data that are not simply
// there (data_stream.h). Its warnings, and those of the libraries below it,
// go nowhere: what they have to say comes back as a Status.

#pragma once

#include "volume/image_header.h"

#include <filesystem>

namespace pliant {

/// Reads what ITK says of a file of header.format: sizes, components, their type, grid and
/// key/value pairs (sorted; NIfTI has none), in place of what the header had.
/// @returns Unreadable with ITK's own words, which may be several lines; Unsupported where the type
/// of numbers isn't known
Status itk_read_header(const std::filesystem::path& path, ImageHeader& header);

/// Reads all numbers of an image, NIfTI's with slope and intercept applied.
/// @param header      as itk_read_header left it
/// @param[out] values  room for voxel_count(header.grid)·components numbers of header.component
Status itk_read_values(const std::filesystem::path& path, const ImageHeader& header, void* values);

}  // namespace pliant
