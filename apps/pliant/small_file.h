// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/result.h>

#include <string>

namespace pliant::app {

/// A file of up to 16 MiB as a whole.
/// @param expected  the kind of file, for errors: "keyframes"
/// @returns NotFound; Unreadable for a folder or a larger file
Result<std::string> read_small_file(const std::string& file, const std::string& expected);

}  // namespace pliant::app
