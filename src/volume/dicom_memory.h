// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Whether the memory that a series and its decoder take is there. Linux promises more than it has.

#pragma once

#include "volume/text.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace pliant {

/// @returns true where the system doesn't say
inline bool has_room_for(std::uint64_t bytes) {
    std::ifstream file("/proc/meminfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("MemAvailable:"))
            for (const std::string_view word : split(line, ' '))
                if (const auto kib = whole_number_from(word))
                    return bytes >> 10 <= std::uint64_t(*kib);
    return true;
}

}  // namespace pliant
