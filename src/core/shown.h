// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Text that comes out of files, for terminals and messages: such text may hold escape sequences,
// line ends and anything else, at any length.

#pragma once

#include <string>
#include <string_view>

namespace pliant {

/// A quoted part: ASCII, at most 60 characters, with '?' for all else.
inline std::string shown(std::string_view text) {
    constexpr std::size_t kMost = 60;
    std::string result(text.substr(0, kMost));
    for (char& c : result)
        if (c < ' ' || c > '~') c = '?';
    return text.size() > kMost ? result + "…" : result;
}

/// Length of the UTF-8 character that a text begins with; 0 for control characters and for bytes
/// that begin none.
inline std::size_t printable_length(std::string_view text) {
    const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
    if (byte(0) < 0x80) return byte(0) >= ' ' && byte(0) != 0x7f ? 1 : 0;
    const std::size_t length = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
    if (byte(0) < 0xc2 || byte(0) > 0xf4 || text.size() < length) return 0;
    for (std::size_t n = 1; n < length; ++n)
        if ((byte(n) & 0xc0) != 0x80) return 0;
    return byte(0) == 0xc2 && byte(1) < 0xa0 ? 0 : length;  // C1 control characters
}

/// One line of a terminal: '?' for each byte that can't be shown, and an ellipsis for what is
/// beyond max_bytes.
inline std::string printable(std::string_view text, std::size_t max_bytes = 300) {
    std::string result;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = printable_length(text.substr(at));
        if (result.size() + (length ? length : 1) > max_bytes) return result + "…";
        if (length)
            result += text.substr(at, length);
        else
            result += '?';
        at += length ? length : 1;
    }
    return result;
}

}  // namespace pliant
