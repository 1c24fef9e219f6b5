// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue's state in a file: the frame of core/state_frame.h with its kind, the count of numbers,
// and the numbers. A session records the frame's checksum.

#pragma once

#include <pliant/result.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace pliant {

/// Writes the file atomically. @param kind  of tissue
Status save_numbers(const std::filesystem::path& path, std::uint64_t kind,
                    std::span<const double> numbers);
/// @returns Unreadable for a file of another kind, or one that is damaged or cut short
Result<std::vector<double>> load_numbers(const std::filesystem::path& path, std::uint64_t kind);

}  // namespace pliant
