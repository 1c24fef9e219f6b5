// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "output_text.h"

#include <cstdio>
#include <fstream>

namespace pliant::app {

std::string hex_of(std::uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
    std::ofstream stream(path, std::ios::binary);
    stream << text;
    stream.close();
    if (stream) return Ok{};
    return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
}

}  // namespace pliant::app
