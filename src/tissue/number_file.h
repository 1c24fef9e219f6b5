// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue's state in a file: its kind, the count of numbers, the numbers, and a checksum of all
// the preceding bytes, which is the only part of the file that a session records.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace pliant {

/// Writes the file atomically. @param magic  of that kind of state
Status save_numbers(const std::filesystem::path& path, std::uint64_t magic,
                    std::span<const double> numbers);
/// @returns Unreadable for a file of another kind, or one that is damaged or cut short
Result<std::vector<double>> load_numbers(const std::filesystem::path& path, std::uint64_t magic);

}  // namespace pliant
