// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A line of a session's file: a checksum, a blank, the text.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/hash.h"
#include "protocol/messages.h"

namespace pliant::serve {

inline constexpr std::size_t kChecksumDigits = 16;

/// Checksum of a line's text and of all lines before it.
inline std::uint64_t line_checksum(std::uint64_t chain, std::string_view text) {
    Hash64 hash;
    hash.add_word(chain);
    hash.add(std::span<const char>(text));
    return hash.value();
}

/// @param chain  checksum of the previous line; becomes that of this line
inline std::string session_line(std::uint64_t& chain, std::string_view text) {
    chain = line_checksum(chain, text);
    return hex_text(chain, kChecksumDigits) + " " + std::string(text) + "\n";
}

}  // namespace pliant::serve
