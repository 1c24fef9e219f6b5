// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Text of files on a terminal, where control characters would be commands.

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace pliant::app {

/// Line ends become spaces, other control characters '?'.
/// @param max_bytes  what is beyond becomes an ellipsis
inline std::string one_line(std::string_view text, std::size_t max_bytes = std::string::npos) {
    std::string line;
    for (std::size_t n = 0; n < text.size(); ++n) {
        const auto byte = static_cast<unsigned char>(text[n]);
        const bool continues = (byte & 0xc0) == 0x80;  // a UTF-8 character
        if (n >= max_bytes && !continues) return line + "…";
        const bool is_c1 =
            byte == 0xc2 && n + 1 < text.size() && static_cast<unsigned char>(text[n + 1]) < 0xa0;
        line += byte == '\t' || byte == '\n' || byte == '\r' ? ' '
                : byte < ' ' || byte == 0x7f || is_c1        ? '?'
                                                             : text[n];
    }
    return line;
}

}  // namespace pliant::app
