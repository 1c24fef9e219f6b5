// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Parsing and printing of words, numbers and vectors, independent of the locale.

#pragma once

#include <pliant/core/files.h>  // shown()
#include <pliant/core/text.h>
#include <pliant/core/vec.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// Parses a number from the whole text, including "nan" and "inf".
std::optional<double> number_from(std::string_view text);
std::optional<std::int64_t> whole_number_from(std::string_view text);

/// Splits a text at separators (runs of blanks count as one), without empty parts.
std::vector<std::string_view> split(std::string_view text, char separator);
/// Parses numbers between separators; nullopt if one of them is no number.
std::optional<std::vector<double>> numbers_from(std::string_view text, char separator = ' ');

/// "a, b, c"
std::string text_of(Vec3d vector);
std::string text_of(Vec3i vector);
/// "a, b, c" with at most six digits each
std::string short_text(Vec3d vector);
/// "64 × 64 × 93"
std::string text_of_sizes(const std::vector<std::int64_t>& sizes);
std::string text_of_size(Vec3i size);

}  // namespace pliant
#pragma GCC visibility pop
