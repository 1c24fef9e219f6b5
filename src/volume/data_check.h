// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whether all data of an image are there and undamaged, before ITK reads them: ITK takes some data
// that end early for whole ones and doesn't look at every checksum. Only a piece of them is in
// memory at a time.

#pragma once

#include "volume/image_header.h"

namespace pliant {

/// Whether there are data files, and each of them is a file.
Status check_data_files(const std::filesystem::path& path, const DataPlace& data);

/// Whether the data files hold all numbers: raw ones are long enough, compressed ones inflate to
/// the end with the right checksum, text has a number in each place.
/// @pre check_header(path, …, header) was fine
Status check_data(const std::filesystem::path& path, const ImageHeader& header);

/// Names of the data files from a text such as "slice%03d.raw 1 40 1" (first, last, step).
std::vector<std::string> numbered_names(std::string_view text);

}  // namespace pliant
