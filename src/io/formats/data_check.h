// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checks that all data of an image exist, before memory for them is allocated.

#pragma once

#include "formats/image_header.h"

namespace pliant {

/// Maximum number of bytes that are decompressed and skipped before an image's data.
inline constexpr std::uint64_t kMaxInnerSkip = std::uint64_t(1) << 28;

/// Checks that there are data files, and that each is a regular file.
Status check_data_files(const std::filesystem::path& path, const DataLocation& data);

/// Checks that the data files can hold all numbers: raw files are long enough; compressed files and
/// text can be.
/// @pre check_header(path, …, header) and check_data_files succeeded
Status check_data(const std::filesystem::path& path, const ImageHeader& header);

/// Offset of the data in the file `name`, one of header.data.files: after headers, skipped lines
/// and skipped bytes.
/// @returns Unreadable if the file ends too early; @pre as for check_data
Result<std::uint64_t> find_data_start(const std::filesystem::path& path, const ImageHeader& header,
                                      const std::filesystem::path& name);

/// Bytes behind the data in raw files, which the header doesn't count. @pre check_data succeeded
Result<std::uint64_t> bytes_beyond(const std::filesystem::path& path, const ImageHeader& header);

/// Expands a pattern such as "slice%03d.raw 1 40 1" (first, last, step) to file names.
std::vector<std::string> numbered_names(std::string_view text);

}  // namespace pliant
