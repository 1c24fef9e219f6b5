// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small text files from outside: settings, scenes, curves, logs. They are read as a whole. Their
// nesting is checked before a parser runs, because parsers recurse.

#pragma once

#include <pliant/result.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

/// Refuses folders, pipes, sockets, devices and circular links, without opening them.
/// @param expected  the kind of file, for errors: "a settings file"
/// @returns NotFound, or Unreadable
Status check_is_file(const std::filesystem::path& path, std::string_view expected);

/// Reads a whole file.
/// @returns an error of check_is_file; Unreadable for more than max_bytes
Result<std::string> read_small_file(const std::filesystem::path& path, std::size_t max_bytes,
                                    std::string_view expected);
inline constexpr std::size_t kMaxSmallFileBytes = std::size_t(16) << 20;

enum class TextSyntax { Toml, Json };

/// Checks the nesting of a text. Parsers, and destructors of their results, recurse once per level.
/// A text deeper than every format of Pliant is refused: more than 64 nested brackets, or 32 dots
/// in a TOML key. Brackets and dots in strings and comments don't count.
/// @returns Unreadable, which names the line but no file
Status check_nesting(std::string_view text, TextSyntax syntax);

/// Quotes a text from a file in a message: its printable ASCII characters, '?' for the others, at
/// most 60.
std::string shown(std::string_view text);

/// Makes a text safe for a terminal: line ends become spaces; other control characters and broken
/// UTF-8 become '?'.
/// @param max_bytes  longer texts are truncated with an ellipsis
std::string printable(std::string_view text, std::size_t max_bytes = std::string_view::npos);

/// Makes a whole message printable; if it is longer than 400 bytes, its middle is left out.
std::string one_line(std::string_view message);

}  // namespace pliant
#pragma GCC visibility pop
