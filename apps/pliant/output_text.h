// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Text that commands write into their outputs.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace pliant::app {

/// A hash as reports show it: 16 hexadecimal digits.
std::string hex_of(std::uint64_t hash);

/// Writes a text to a file. @returns Unwritable
Status write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace pliant::app
