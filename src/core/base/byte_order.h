// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Numbers of files and messages that are little-endian on every machine.

#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace pliant {

inline constexpr bool kIsBigEndian = std::endian::native == std::endian::big;

/// Converts a number between the machine's byte order and little-endian; its own inverse.
template <class T>
T little_endian(T number) {
    if constexpr (kIsBigEndian && sizeof(T) > 1) {
        std::array<std::byte, sizeof(T)> bytes;
        std::memcpy(bytes.data(), &number, sizeof number);
        std::reverse(bytes.begin(), bytes.end());
        std::memcpy(&number, bytes.data(), sizeof number);
    }
    return number;
}

}  // namespace pliant
