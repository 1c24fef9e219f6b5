// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Detection and reading of image headers.

#pragma once

#include "formats/image_header.h"

#include <optional>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

std::optional<ImageFormat> format_by_name(const std::filesystem::path& path);
/// Checks that a file exists, is readable and isn't empty.
Status check_file(const std::filesystem::path& path);
/// Reads the header if the first bytes match the format.
Result<ImageHeader> read_image_header(const std::filesystem::path& path, ImageFormat format);
/// Number of images in a file, or of volumes in a DICOM file or folder, to choose from with
/// ReadOptions::frame.
/// @param series  ReadOptions::series_uid
Result<std::int64_t> count_images(const std::filesystem::path& path, const std::string& series);

}  // namespace pliant
#pragma GCC visibility pop
