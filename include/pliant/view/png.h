// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// PNG files.

#pragma once

#include <pliant/result.h>
#include <pliant/view/image.h>

#include <filesystem>

#pragma GCC visibility push(default)
namespace pliant {

/// Writes a picture. @returns Unwritable with the system's reason, InvalidArgument for a picture
/// whose size is not that of its pixels
Status write_png(const std::filesystem::path& path, const Image& image);

}  // namespace pliant
#pragma GCC visibility pop
