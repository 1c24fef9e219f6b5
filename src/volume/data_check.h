// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whether all data of an image are there, before memory for them is asked for.

#pragma once

#include "volume/image_header.h"

namespace pliant {

/// Whether there are data files, and each of them is a file.
Status check_data_files(const std::filesystem::path& path, const DataPlace& data);

/// Whether the data files can hold all numbers: raw ones are long enough, compressed ones and text
/// may be.
/// @pre check_header(path, …, header) and check_data_files were fine
Status check_data(const std::filesystem::path& path, const ImageHeader& header);

/// Where in the file `name`, one of header.data.files, the data start: after headers, skipped lines
/// and skipped bytes.
/// @returns Unreadable if the file ends too early; @pre as for check_data
Result<std::uint64_t> find_data_start(const std::filesystem::path& path, const ImageHeader& header,
                                      const std::filesystem::path& name);

/// Names of the data files from a text such as "slice%03d.raw 1 40 1" (first, last, step).
std::vector<std::string> numbered_names(std::string_view text);

}  // namespace pliant
