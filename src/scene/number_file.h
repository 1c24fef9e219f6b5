// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue's state in a file: what it is of, how many numbers, the numbers, and a checksum of all
// that is before it, which is all that a session keeps of the file.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Appears whole or not at all. @param magic  of that kind of state
Status save_numbers(const std::filesystem::path& path, std::uint64_t magic,
                    std::span<const double> numbers);
/// @returns Unreadable for a file of another kind, or one that is damaged or cut short
Result<std::vector<double>> load_numbers(const std::filesystem::path& path, std::uint64_t magic);

}  // namespace pliant
#pragma GCC visibility pop
