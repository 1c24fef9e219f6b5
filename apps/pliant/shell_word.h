// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace pliant::app {

/// Quotes a file name as one word of a POSIX shell's command, if needed. The word is never an
/// option.
inline std::string shell_word(const std::string& name) {
    const std::string whole = name.starts_with('-') ? "./" + name : name;
    constexpr const char* kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
    if (!whole.empty() && whole.find_first_not_of(kPlain) == std::string::npos) return whole;
    std::string word = "'";
    for (const char c : whole) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

}  // namespace pliant::app
