// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Small text files of others: settings, scenes, curves, logs. They are read as a whole, and checked
// for the depths that parsers don't bear before one sees them.

#pragma once

#include <pliant/result.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

/// Refuses folders, pipes, sockets, devices and links to themselves, without opening them.
/// @param expected  the kind of file, for errors: "a settings file"
/// @returns NotFound, or Unreadable
Status check_is_file(const std::filesystem::path& path, std::string_view expected);

/// All bytes of a file.
/// @returns as check_is_file; Unreadable also for a file of more than max_bytes
Result<std::string> read_small_file(const std::filesystem::path& path, std::size_t max_bytes,
                                    std::string_view expected);
inline constexpr std::size_t kMaxSmallFileBytes = std::size_t(16) << 20;

enum class TextSyntax { Toml, Json };

/// Parsers and the destructors of their results go one level down the stack for each level of
/// nesting. Texts nested deeper than anything that Pliant reads are refused: more than 64 brackets
/// in each other, or 32 dots in a TOML key. Brackets and dots in texts and comments don't count.
/// @returns Unreadable, which names the line and no file
Status check_nesting(std::string_view text, TextSyntax syntax);

/// A text from a file, for messages: its printable ASCII characters, '?' for the others, at
/// most 60.
std::string shown(std::string_view text);

/// The same text for a terminal: line ends become spaces, other control characters and broken UTF-8
/// become '?'.
/// @param max_bytes  length at which it is cut, with an ellipsis
std::string printable(std::string_view text, std::size_t max_bytes = std::string_view::npos);

/// Likewise a whole message; where it is longer than 400 bytes, its middle is left out.
std::string one_line(std::string_view message);

}  // namespace pliant
#pragma GCC visibility pop
