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

}  // namespace pliant
#pragma GCC visibility pop
