// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Words and numbers of header texts, read and printed the same way in every locale.

#pragma once

#include <pliant/text_input.h>  // shown()
#include <pliant/vec.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

/// A number that fills the whole text, "nan" and "inf" included.
std::optional<double> number_from(std::string_view text);
std::optional<std::int64_t> whole_number_from(std::string_view text);

/// Texts between separators (runs of blanks count as one), without empty ones.
std::vector<std::string_view> split(std::string_view text, char separator);
/// Numbers between separators, or nothing if one of them is no number.
std::optional<std::vector<double>> numbers_from(std::string_view text, char separator = ' ');

/// Shortest text that reads back as the same number.
std::string text_of(double number);
/// With six digits at most, as messages show numbers.
std::string short_text(double number);
/// "a, b, c"
std::string text_of(Vec3d vector);
std::string text_of(Vec3i vector);
/// "64 × 64 × 93"
std::string text_of_sizes(const std::vector<std::int64_t>& sizes);
std::string text_of_size(Vec3i size);

}  // namespace pliant
#pragma GCC visibility pop
