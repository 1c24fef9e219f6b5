// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From a path to a judged header.

#pragma once

#include "volume/image_header.h"

#include <optional>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

std::optional<ImageFormat> format_by_name(const std::filesystem::path& path);
/// Whether there is a file that can be read, with something in it.
Status check_file(const std::filesystem::path& path);
/// Reads the header, if the first bytes fit the format.
Result<ImageHeader> read_image_header(const std::filesystem::path& path, ImageFormat format);

}  // namespace pliant
#pragma GCC visibility pop
