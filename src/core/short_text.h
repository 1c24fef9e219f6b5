// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <charconv>
#include <string>

namespace pliant {

/// A number with six digits at most, as messages show it.
inline std::string short_text(double number) {
    char text[32];
    const auto end =
        std::to_chars(text, text + sizeof(text), number, std::chars_format::general, 6);
    return {text, end.ptr};
}

}  // namespace pliant
